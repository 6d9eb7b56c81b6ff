#include "lib/perception/rival_turns.h"

#include <numbers>

namespace secondlook::perception {
namespace {

constexpr int kAxisSteps = 24;

/// True when the symmetry makes `turn` no turn at all.
bool IsNoTurn(const RecognitionModel& model, const Pose& turn, double angle) {
  const PoseDistance distance =
      DistanceUpToSymmetry(Pose::Identity(), turn, model.symmetry, model.center_M, true);
  return distance.rotation < angle / 2.0;
}

}  // namespace

std::vector<Pose> RivalTurns(const RecognitionModel& model, double angle) {
  const Symmetry& symmetry = model.symmetry;
  const Eigen::Vector3d first = symmetry.axis ? symmetry.axis->direction : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d second = first.unitOrthogonal();
  std::vector<Pose> turns;
  for (const Eigen::Vector3d& direction : {first, second, Eigen::Vector3d(first.cross(second))}) {
    for (const double sign : {1.0, -1.0}) {
      turns.push_back(TurnAbout({model.center_M, direction}, sign * angle));
    }
  }
  if (symmetry.axis && !symmetry.axis_keeps_color) {
    for (int i = 1; i < kAxisSteps; ++i) {
      turns.push_back(TurnAbout(*symmetry.axis, 2.0 * std::numbers::pi * i / kAxisSteps));
    }
  }
  for (const SymmetryMotion& motion : symmetry.motions) {
    if (!motion.keeps_color) turns.push_back(motion.X_MS);
  }
  std::erase_if(turns, [&](const Pose& turn) { return IsNoTurn(model, turn, angle); });
  return turns;
}

}  // namespace secondlook::perception

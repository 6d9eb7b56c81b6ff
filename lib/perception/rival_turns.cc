#include "lib/perception/rival_turns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace secondlook::perception {
namespace {

constexpr int kAxisSteps = 24;
/// So near to a resting pose a model rests, and so much farther from it it does not.
constexpr double kRest_rad = 0.09;
constexpr double kOffRest_rad = 0.07;
/// Sides of a box that differ by no more than this share are alike.
constexpr double kAlikeSides = 0.2;
constexpr double kNoTurn_rad = 0.3;

/// The angle between two directions in M, up to the symmetry of shape [rad].
double AngleUpToSymmetry(const Eigen::Vector3d& a_M, const Eigen::Vector3d& b_M,
                         const Symmetry& symmetry) {
  const auto angle = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
  };
  double least = std::numbers::pi;
  for (const SymmetryMotion& motion : symmetry.motions) {
    const Eigen::Vector3d moved_M = motion.X_MS.linear() * a_M;
    least = std::min(least, symmetry.axis ? std::abs(angle(moved_M, symmetry.axis->direction) -
                                                     angle(b_M, symmetry.axis->direction))
                                          : angle(moved_M, b_M));
  }
  return least;
}

/// How far the model at X_WM is from the nearest pose in which it rests on a plane [rad].
double AngleFromRest(const RecognitionModel& model, const Pose& X_WM,
                     const Eigen::Vector3d& normal_W) {
  const Eigen::Vector3d down_M = -(X_WM.linear().transpose() * normal_W);
  double nearest = std::numbers::pi;
  for (const Eigen::Vector3d& resting_M : model.resting_M) {
    nearest = std::min(nearest, AngleUpToSymmetry(down_M, resting_M, model.symmetry));
  }
  return nearest;
}

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

std::vector<Pose> BoxTurns(const RecognitionModel& model) {
  Eigen::AlignedBox3f box_M;
  for (const Eigen::Vector3f& p_M : model.hull) box_M.extend(p_M);
  const Eigen::Vector3d sides = box_M.sizes().cast<double>();
  const Eigen::Vector3d middle_M = box_M.center().cast<double>();
  std::vector<Pose> turns;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      // The axes of M go to the axes x / 2 and y / 2, an odd number meaning backwards.
      if (x / 2 == y / 2) continue;
      const auto signed_axis = [](int i) -> Eigen::Vector3d {
        return (i % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(i / 2);
      };
      Eigen::Matrix3d R;
      R.col(0) = signed_axis(x);
      R.col(1) = signed_axis(y);
      R.col(2) = R.col(0).cross(R.col(1));
      const Eigen::Vector3d turned = (R * sides).cwiseAbs();
      if (((turned - sides).cwiseAbs().array() > kAlikeSides * sides.array()).any()) continue;
      Pose X_MS = Pose::Identity();
      X_MS.linear() = R;
      X_MS.translation() = middle_M - R * middle_M;
      turns.push_back(X_MS);
    }
  }
  std::erase_if(turns, [&](const Pose& turn) { return IsNoTurn(model, turn, kNoTurn_rad); });
  return turns;
}

Pose ShareOfTurn(const Pose& X_MS, const Eigen::Vector3d& center_M, double share) {
  const Eigen::AngleAxisd turn(X_MS.linear());
  return TurnAbout({center_M, turn.axis()}, share * turn.angle());
}

bool IsAtRest(const RecognitionModel& model, const Pose& X_WM, const Eigen::Vector3d& normal_W) {
  return AngleFromRest(model, X_WM, normal_W) < kRest_rad;
}

bool LeavesItsRest(const RecognitionModel& model, const Pose& X_WM, const Pose& X_MS,
                   const Eigen::Vector3d& normal_W) {
  const double before = AngleFromRest(model, X_WM, normal_W);
  return before < kRest_rad && AngleFromRest(model, X_WM * X_MS, normal_W) > before + kOffRest_rad;
}

}  // namespace secondlook::perception

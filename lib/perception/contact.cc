#include "lib/perception/contact.h"

#include <algorithm>
#include <cmath>

namespace secondlook::perception {

namespace {

struct LowestPoints {
  std::vector<Eigen::Vector3d> points_C;
  double height{};  ///< Of the lowest above the plane [m].
};

/// The points of the model that touch the plane when the lowest does; none when it is not near.
LowestPoints FindLowest(const RecognitionModel& model, const Pose& X_CM,
                        const world::SupportPlane& plane_C) {
  constexpr double kNear = 0.025;   // [m]
  constexpr float kLayer = 0.004F;  // what is this near to the lowest point touches as well [m]
  const Eigen::Vector3f up_M = (X_CM.linear().transpose() * plane_C.normal_A).cast<float>();
  const auto base = static_cast<float>(plane_C.HeightOf(X_CM.translation()));
  float lowest = 1e9F;
  for (const Eigen::Vector3f& p : model.hull) lowest = std::min(lowest, up_M.dot(p) + base);
  LowestPoints found;
  found.height = lowest;
  if (std::abs(lowest) > kNear) return found;
  for (const Eigen::Vector3f& p : model.hull) {
    if (up_M.dot(p) + base <= lowest + kLayer) found.points_C.push_back(X_CM * p.cast<double>());
  }
  return found;
}

}  // namespace

void AddContact(const RecognitionModel& model, const Pose& X_CM, const world::SupportPlane& plane_C,
                double weight, std::vector<geometry::PointPlanePair>* pairs) {
  const LowestPoints lowest = FindLowest(model, X_CM, plane_C);
  const double each = weight / static_cast<double>(lowest.points_C.size());
  for (const Eigen::Vector3d& p : lowest.points_C) {
    pairs->push_back({p, p - plane_C.HeightOf(p) * plane_C.normal_A, plane_C.normal_A, each});
  }
}

void AddContactHeight(const RecognitionModel& model, const Pose& X_CM,
                      const world::SupportPlane& plane_C, double weight,
                      std::vector<geometry::PointPlanePair>* pairs) {
  const LowestPoints lowest = FindLowest(model, X_CM, plane_C);
  const double each = weight / static_cast<double>(lowest.points_C.size());
  for (const Eigen::Vector3d& p : lowest.points_C) {
    pairs->push_back({p, p - lowest.height * plane_C.normal_A, plane_C.normal_A, each});
  }
}

}  // namespace secondlook::perception

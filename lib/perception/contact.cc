#include "lib/perception/contact.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace secondlook::perception {

void AddContact(const RecognitionModel& model, const Pose& X_CM, const world::SupportPlane& plane_C,
                double weight, std::vector<geometry::PointPlanePair>* pairs) {
  constexpr double kNear = 0.025;   // [m]
  constexpr float kLayer = 0.004F;  // what is this near to the lowest point touches as well [m]
  const Eigen::Vector3f up_M = (X_CM.linear().transpose() * plane_C.normal_A).cast<float>();
  const auto base = static_cast<float>(plane_C.HeightOf(X_CM.translation()));
  float lowest = 1e9F;
  for (const Eigen::Vector3f& p : model.hull) lowest = std::min(lowest, up_M.dot(p) + base);
  if (std::abs(lowest) > kNear) return;
  const std::size_t first = pairs->size();
  for (const Eigen::Vector3f& v : model.hull) {
    const float height = up_M.dot(v) + base;
    if (height > lowest + kLayer) continue;
    const Eigen::Vector3d p = X_CM * v.cast<double>();
    pairs->push_back({p, p - plane_C.HeightOf(p) * plane_C.normal_A, plane_C.normal_A, 1.0});
  }
  const double each = weight / static_cast<double>(pairs->size() - first);
  for (std::size_t i = first; i < pairs->size(); ++i) (*pairs)[i].weight = each;
}

}  // namespace secondlook::perception

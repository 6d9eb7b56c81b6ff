#pragma once

#include <vector>

#include "lib/common/pose.h"
#include "lib/geometry/kd_tree.h"
#include "lib/geometry/mesh.h"

namespace secondlook::apps {

/// How far an estimated pose carries a model from where it truly is (Hinterstoisser et al. 2012).
struct PoseError {
  double add{};   ///< Mean distance of each point from itself [m].
  double adds{};  ///< Mean distance of each true point from the estimate's surface [m].
};

/// Measures pose errors of one model.
class PoseErrorMetric {
 public:
  /// @pre !mesh.empty().
  explicit PoseErrorMetric(const geometry::Mesh& mesh);

  PoseError Of(const Pose& X_CM_estimate, const Pose& X_CM_truth) const;

 private:
  std::vector<Eigen::Vector3d> points_M_;
  geometry::KdTree surface_M_;
};

}  // namespace secondlook::apps

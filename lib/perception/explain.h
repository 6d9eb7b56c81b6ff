#pragma once

#include <vector>

#include "lib/geometry/camera_model.h"
#include "lib/geometry/mesh.h"
#include "lib/world/observation.h"

namespace secondlook::perception {

/// A cluster of these pixels of a frame: points, centre and order follow from them.
/// @param pixels Row-major indices, in any order, without duplicates.
/// @param depth [height, width] CV_32FC1, z_C [m].
world::Cluster MakeCluster(std::vector<int> pixels, const cv::Mat& depth,
                           const geometry::CameraModel& camera);

/// Takes out of `clusters` what a thing that is known already explains: the pixels within 3 px of
/// the silhouette of `mesh` at X_CM that were measured within 15 mm of its surface there. Returns
/// them as one cluster, empty when there are none. What is left of a cluster that gave some away is
/// kept when it has at least `min_left` pixels; it is then something else beside the known thing.
world::Cluster TakeExplained(const geometry::Mesh& mesh, const Pose& X_CM, const cv::Mat& depth,
                             const geometry::CameraModel& camera, int min_left,
                             std::vector<world::Cluster>* clusters);

/// How a surface that should be there agrees with a view.
struct SurfaceAgreement {
  int matching{};     ///< Pixels measured within 15 mm of it.
  int see_through{};  ///< Pixels measured more than 30 mm behind it.
};

/// Compares the silhouette of `mesh` at X_CM with the measured depth. Pixels without a measurement,
/// or measured in front of the surface, say nothing.
SurfaceAgreement CompareSurface(const geometry::Mesh& mesh, const Pose& X_CM, const cv::Mat& depth,
                                const geometry::CameraModel& camera);

}  // namespace secondlook::perception

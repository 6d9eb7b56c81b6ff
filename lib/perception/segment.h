#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/point_image.h"
#include "lib/perception/split.h"
#include "lib/world/observation.h"
#include "lib/world/support_plane.h"

namespace secondlook::perception {

/// How a view is cut into the plane that things stand on and the things.
struct SegmentConfig {
  double max_tilt_deg = 10.0;       ///< A support plane's normal lies this near to `up`.
  double max_range_m = 3.0;         ///< Points farther from the camera are left out.
  int min_plane_points = 1500;      ///< A plane with fewer is none.
  double min_plane_area_m2 = 0.06;  ///< Of what was seen of it; the top of a box has less.
  double min_plane_width_m =
      0.12;                     ///< The shorter side of its rectangle; a strip of wall has less.
  double min_height_m = 0.008;  ///< Lower than this, and than 3 sigma of the depth, is the plane.
  double max_height_m = 0.6;    ///< Higher than this is not on the table.
  double edge_clearance_m = 0.02;  ///< How far beyond the plane's convex extent things may reach.
  double cluster_gap_m = 0.015;    ///< Things farther apart are two.
  int min_cluster_points = 80;     ///< Smaller clusters are noise.
  bool split_touching = true;      ///< False: what touches is one cluster.
  SplitConfig split;

  template <class A>
  void Serialize(A* a) {
    a->Visit("max_tilt_deg", &max_tilt_deg);
    a->Visit("max_range_m", &max_range_m);
    a->Visit("min_plane_points", &min_plane_points);
    a->Visit("min_plane_area_m2", &min_plane_area_m2);
    a->Visit("min_plane_width_m", &min_plane_width_m);
    a->Visit("min_height_m", &min_height_m);
    a->Visit("max_height_m", &max_height_m);
    a->Visit("edge_clearance_m", &edge_clearance_m);
    a->Visit("cluster_gap_m", &cluster_gap_m);
    a->Visit("min_cluster_points", &min_cluster_points);
    a->Visit("split_touching", &split_touching);
    a->Visit("split", &split);
  }

  /// @throws ConfigError naming the value that is out of range.
  void Validate() const;
};

/// A further plane that things may stand on: a shelf, a second table, the top of a large box.
struct FurtherSupport {
  world::SupportPlane plane_C;
  std::vector<Eigen::Vector3d> points_C;  ///< As Segmentation::plane_points_C.
};

/// A view cut into planes and things.
struct Segmentation {
  std::optional<world::SupportPlane> plane_C;  ///< In the camera frame.
  /// The plane's measured points, thinned to about 2 cm: what its rectangle was fitted to [m].
  std::vector<Eigen::Vector3d> plane_points_C;
  std::vector<FurtherSupport> further;   ///< By falling extent; empty where there is no plane_C.
  std::vector<world::Cluster> clusters;  ///< Largest first.
  std::vector<int> stands_on;            ///< By cluster: 0 is plane_C, k is further[k - 1].
  /// Why there is no plane, or no cluster, with values; empty when there are both.
  std::string reason;

  /// All planes, by which stands_on counts; none when there is no plane_C.
  std::vector<world::SupportPlane> Planes() const {
    std::vector<world::SupportPlane> planes = FurtherPlanes();
    if (plane_C) planes.insert(planes.begin(), *plane_C);
    return planes;
  }

  /// The planes of `further`.
  std::vector<world::SupportPlane> FurtherPlanes() const {
    std::vector<world::SupportPlane> planes;
    for (const FurtherSupport& support : further) planes.push_back(support.plane_C);
    return planes;
  }
};

/// Finds the support plane by RANSAC: of the planes whose normal lies near `up_C`, the unit vector
/// against gravity in the camera frame (a wall is not a table), the highest that is large enough
/// (the floor is not a table either), then what stands on it: points over the convex extent of the
/// plane, clustered by Euclidean distance, cut where things touch (SplitAtCreases()), and with the
/// inside of what is hollow joined to its outside (FindOutsides()).
/// The other level planes that are large enough support things, too (FurtherSupport), but for the
/// lowest of several where it may be the floor; what stands over one is not of what is below it.
/// Points lower than `max_drop` [m] below the camera are left out: where the camera's height is
/// known, that takes the floor out of the question, and the largest plane is taken instead of the
/// highest (a crate beside the table may be higher).
/// Deterministic: the same points give the same result.
/// @throws InvalidArgument when `up_C` is not finite or zero, or when the cloud's values show that
/// it is not in metres (the median distance is over 50 m or under 2 cm).
Segmentation Segment(const geometry::PointImage& cloud, const Eigen::Vector3d& up_C,
                     const SegmentConfig& config,
                     double max_drop = std::numeric_limits<double>::infinity());

/// Makes that of the planes the first which continues `known_W`, where the camera is at about X_WC:
/// which of several tables is the largest may change with the view. No change when none lies within
/// 3 cm of its height.
void PutFirst(const world::SupportPlane& known_W, const Pose& X_WC, Segmentation* segmentation);

}  // namespace secondlook::perception

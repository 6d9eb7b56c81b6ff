#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"

namespace secondlook::fusion {

/// How far a centroid is from a box in the image.
enum class BoxDistance {
  kEightPoints,  ///< From the nearest of the corners and the middles of the edges (Hoseini 2018).
  kCenter,       ///< From the centre, in units of half the box's sides, times their mean [px].
};

struct CrossMatchConfig {
  BoxDistance distance{BoxDistance::kCenter};
  double max_distance_px{60.0};  ///< Between a centroid and a box (Hoseini 2018, 2.1).
  double max_deviations{3.0};    ///< Of a distance from the mean of all matches'.
  double position_sigma_m{
      0.01};               ///< Of a centroid in the other camera: depth, extent, calibration.
  double max_sigmas{3.0};  ///< How far from a box's cone of sight a centroid may lie.

  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The main camera's object `object` is the second camera's box `box`.
struct CrossMatch {
  int object{};
  int box{};
  double distance_px{};  ///< By the configured measure.
};

/// A main camera's object or a second camera's box that has no partner.
struct Unmatched {
  bool is_object{};  ///< Or a box.
  int index{};
  std::string reason;
};

struct CrossMatches {
  std::vector<CrossMatch> matches;  ///< By object.
  std::vector<Unmatched> unmatched;
};

/// Matches objects between a camera A with depth and a colour camera B (Hoseini 2018, 2.1): their
/// centroids `p_AO` [m] are projected into B; each component of the larger group is associated with
/// the nearest of the other; of several at one component the nearest stays. The paper's measure of
/// distance favours a neighbour whose edge crosses an object, so the centre is the default. Then
/// three gates: distances beyond max_distance_px; distances beyond max_deviations standard
/// deviations above the mean of all other matches', where there are three or more; and, not in the
/// paper, centroids farther from the cone of sight of their box than max_sigmas position_sigma_m.
/// @throws InvalidArgument for a centroid that is not finite or a box without pixels, naming it,
/// and for a camera or pose that is none; ConfigError when `config` is not valid.
CrossMatches MatchAcrossCameras(const std::vector<Eigen::Vector3d>& p_AO,
                                const std::vector<cv::Rect2d>& boxes_B, const Pose& X_BA,
                                const geometry::CameraModel& camera_B,
                                const CrossMatchConfig& config = {});

}  // namespace secondlook::fusion

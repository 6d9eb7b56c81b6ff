#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/video/background_segm.hpp>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/world/observation.h"

namespace secondlook::perception {

/// How things are told from a background that was seen without them.
struct BackgroundConfig {
  double max_deviations{4.0};  ///< A pixel so many standard deviations from all Gaussians is new.
  double min_shadow{0.5};     ///< What has the background's hue and this share of its light or more
                              ///< is a shadow on it.
  int median_px{3};           ///< Side of the median filter against impulses; odd.
  double blur_sigma_px{1.0};  ///< Of the Gaussian filter against additive noise.
  int open_px{3};             ///< Diameter of what opening removes …
  int close_px{9};            ///< … and of the gaps that closing fills.
  int min_pixels{80};         ///< Smaller components are noise.
  double same_view_m{0.002};  ///< A camera that has moved farther …
  double same_view_deg{0.15};  ///< … or turned farther sees another background.

  template <class A>
  void Serialize(A* a) {
    a->Visit("max_deviations", &max_deviations);
    a->Visit("min_shadow", &min_shadow);
    a->Visit("median_px", &median_px);
    a->Visit("blur_sigma_px", &blur_sigma_px);
    a->Visit("open_px", &open_px);
    a->Visit("close_px", &close_px);
    a->Visit("min_pixels", &min_pixels);
    a->Visit("same_view_m", &same_view_m);
    a->Visit("same_view_deg", &same_view_deg);
  }

  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// What stands out from the background.
struct Foreground {
  /// As Segment() gives them, largest first; without depth they have no points and no centre.
  std::vector<world::Cluster> clusters;
  std::string reason;  ///< Why there are none, with values; empty when there are some.
};

/// Finds things by their colours against a background that a camera learns while it stands still,
/// before they are there (Hoseini 2018, Section 2): a mixture of Gaussians for each pixel, opening
/// and closing, connected components. Unlike Segment() it needs no depth; but once the camera has
/// moved, it knows nothing.
class BackgroundModel {
 public:
  /// Learns from `frames` (CV_8UC3, RGB, of one size) that a camera at X_WC took of the scene
  /// without things.
  /// @throws InvalidArgument for fewer than two frames or such as do not fit together; ConfigError
  /// when `config` is not valid.
  BackgroundModel(const std::vector<cv::Mat>& frames, const Pose& X_WC,
                  const BackgroundConfig& config = {});

  /// What stands out in `color`, taken from X_WC. Nothing, and the reason, where that is another
  /// pose than the background was learnt at, and where most of the picture is new: the light has
  /// changed. The same picture always gives the same.
  /// @param depth [height, width] CV_32FC1, z_C [m]; NaN = none. Empty: the camera has no depth,
  /// and `camera` is not used.
  /// @throws InvalidArgument for a picture of another size or type.
  Foreground Detect(const cv::Mat& color, const cv::Mat& depth, const geometry::CameraModel& camera,
                    const Pose& X_WC) const;

 private:
  cv::Mat Denoised(const cv::Mat& color) const;

  BackgroundConfig config_;
  Pose X_WC_{Pose::Identity()};
  cv::Size size_;
  cv::Ptr<cv::BackgroundSubtractorMOG2> mixture_;
};

}  // namespace secondlook::perception

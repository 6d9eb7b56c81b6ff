#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "lib/perception/recognise.h"
#include "lib/perception/segment.h"

namespace secondlook::perception {

/// What one frame shows, nothing told beforehand.
struct FrameRecognition {
  std::optional<world::SupportPlane> plane_C;  ///< Empty: no plane was found, and nothing else.
  std::vector<world::SupportPlane> further_C;  ///< Others that things may stand on.
  std::vector<world::Detection> detections;
  std::vector<Choice> choices;  ///< One for each detection.
  std::string reason;           ///< Why there is no plane, or no detection; else empty.
};

/// Recognises the things in one frame: cuts it into plane and clusters (Segment()), recognises each
/// cluster and chooses, joins and cuts clusters where recognition says so (RecogniseRegrouping()).
/// @param color CV_8UC3, RGB, registered to `depth`; may be empty.
/// @param depth CV_32FC1, z_C [m], NaN = none.
/// @throws InvalidArgument as MakeView() and Segment() do.
FrameRecognition RecogniseFrame(const cv::Mat& color, const cv::Mat& depth,
                                const geometry::CameraModel& camera, const Eigen::Vector3d& up_C,
                                const std::vector<RecognitionModel>& models,
                                const SegmentConfig& segment, const RecogniseConfig& config);

}  // namespace secondlook::perception

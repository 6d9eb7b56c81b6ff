#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

namespace secondlook::apps {

/// A depth image in metres: CV_32FC1, NaN where nothing was measured.
/// @param unit The metres of one unit of the file, e.g. 0.001. The file has 16 bits a pixel (0 =
/// none) or 32 bits floating (0 and not finite = none).
/// @throws ConfigError when it is missing, no such image, or no pixel has a depth; InvalidArgument
/// for a unit that is not positive, or when the median depth shows that it is another one.
cv::Mat ReadDepthImage(const std::filesystem::path& file, double unit);

/// The colour image registered to `depth`: CV_8UC3, RGB.
/// @throws ConfigError when it is missing or no image; InvalidArgument when it has another size.
cv::Mat ReadColorImage(const std::filesystem::path& file, const cv::Mat& depth);

}  // namespace secondlook::apps

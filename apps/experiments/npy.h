#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

namespace secondlook::apps {

/// The matrix of a NumPy file of little-endian 32-bit floats, row by row: CV_32FC1.
/// @throws ConfigError naming the file when it is missing, of another type or shape, or cut off.
cv::Mat ReadNpy(const std::filesystem::path& path);

}  // namespace secondlook::apps

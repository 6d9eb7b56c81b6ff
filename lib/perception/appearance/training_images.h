#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace secondlook::perception {

/// The colour image `path`: CV_8UC3, RGB.
/// @throws ConfigError naming the file when it is missing, no image, or a JPEG that ends too early.
cv::Mat ReadImage(const std::filesystem::path& path);

struct TrainingImage {
  std::filesystem::path path;
  int label{};    ///< Index of its class.
  cv::Mat image;  ///< CV_8UC3, RGB.
};

/// Images sorted by class and name.
struct TrainingSet {
  std::vector<std::string> classes;  ///< The names of the sub-folders, sorted.
  std::vector<TrainingImage> images;
  std::vector<std::string> left_out;  ///< Files that are no whole image, each with the reason.
  std::string hash;                   ///< Of all names and contents, e.g. "fnv1a 0123456789abcdef".
};

/// The images in the sub-folders of `folder`, one for each class.
/// @throws ConfigError naming the folder when it is missing, has fewer than two classes, or a class
/// has no image.
TrainingSet ReadTrainingSet(const std::filesystem::path& folder);

}  // namespace secondlook::perception

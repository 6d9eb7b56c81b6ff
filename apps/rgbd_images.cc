#include "apps/rgbd_images.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"

namespace secondlook::apps {
namespace {

cv::Mat ReadImage(const std::filesystem::path& file, int flags) {
  if (!std::filesystem::is_regular_file(file))
    Throw<ConfigError>("{}: no such file", file.string());
  cv::Mat image = cv::imread(file.string(), flags);
  if (image.empty()) Throw<ConfigError>("{}: is no image that can be read", file.string());
  return image;
}

}  // namespace

cv::Mat ReadDepthImage(const std::filesystem::path& file, double unit) {
  if (!(unit > 0.0) || !std::isfinite(unit)) {
    Throw<InvalidArgument>("--depth-unit {}: must be the metres of one unit of depth, e.g. 0.001",
                           unit);
  }
  const cv::Mat raw = ReadImage(file, cv::IMREAD_UNCHANGED);
  if (raw.type() != CV_16UC1 && raw.type() != CV_32FC1) {
    Throw<ConfigError>(
        "{}: has {} channels of {} bytes; a depth image has one of 16 bits (or 32 "
        "bits floating)",
        file.string(), raw.channels(), raw.elemSize1());
  }
  cv::Mat depth;
  raw.convertTo(depth, CV_32FC1, unit);
  std::vector<float> measured;
  for (int y = 0; y < depth.rows; ++y) {
    auto* row = depth.ptr<float>(y);
    for (int x = 0; x < depth.cols; ++x) {
      if (std::isfinite(row[x]) && row[x] > 0.0F) {
        measured.push_back(row[x]);
      } else {
        row[x] = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  if (measured.empty()) Throw<ConfigError>("{}: no pixel has a depth", file.string());
  const auto middle = measured.begin() + static_cast<std::ptrdiff_t>(measured.size() / 2);
  std::nth_element(measured.begin(), middle, measured.end());
  if (*middle < 0.05F || *middle > 20.0F) {
    Throw<InvalidArgument>(
        "{}: with --depth-unit {} the median depth is {:.4g} m, and no table is that {}: give the "
        "metres of one unit (0.001 for millimetres, 0.0001 for tenths of them)",
        file.string(), unit, *middle, *middle < 1.0F ? "near" : "far");
  }
  return depth;
}

cv::Mat ReadColorImage(const std::filesystem::path& file, const cv::Mat& depth) {
  cv::Mat color;
  cv::cvtColor(ReadImage(file, cv::IMREAD_COLOR), color, cv::COLOR_BGR2RGB);
  if (color.size() != depth.size()) {
    Throw<InvalidArgument>(
        "{}: is {} x {}, the depth image {} x {}: both must be registered to one camera",
        file.string(), color.cols, color.rows, depth.cols, depth.rows);
  }
  return color;
}

}  // namespace secondlook::apps

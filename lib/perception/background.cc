#include "lib/perception/background.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/geometry/point_image.h"

namespace secondlook::perception {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
/// Of the picture; more that is new is another light, not things.
constexpr double kMostNew = 0.7;

cv::Mat Disk(int diameter) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {diameter, diameter});
}

/// The pixels of each component of `mask`, largest first.
std::vector<world::Cluster> Components(const cv::Mat& mask, int min_pixels) {
  cv::Mat labels;
  cv::Mat statistics;
  cv::Mat centroids;
  const int count = cv::connectedComponentsWithStats(mask, labels, statistics, centroids, 8);
  std::vector<world::Cluster> clusters(count);
  for (int pixel = 0; pixel < static_cast<int>(labels.total()); ++pixel) {
    clusters[labels.at<int>(pixel / labels.cols, pixel % labels.cols)].pixels.push_back(pixel);
  }
  clusters.erase(clusters.begin());  // what is not in the mask
  std::erase_if(clusters, [&](const world::Cluster& cluster) {
    return static_cast<int>(cluster.pixels.size()) < min_pixels;
  });
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.pixels.size() > b.pixels.size(); });
  return clusters;
}

bool TouchesBorder(const world::Cluster& cluster, cv::Size size) {
  return std::any_of(cluster.pixels.begin(), cluster.pixels.end(), [&](int pixel) {
    const int u = pixel % size.width;
    const int v = pixel / size.width;
    return u == 0 || v == 0 || u == size.width - 1 || v == size.height - 1;
  });
}

/// Keeps the pixels that have depth, as every cluster that has points does.
void AddPoints(const geometry::PointImage& points_C, world::Cluster* cluster) {
  std::vector<int> measured;
  for (const int pixel : cluster->pixels) {
    const Eigen::Vector3f& p = points_C.points_C[pixel];
    if (!geometry::IsMeasured(p)) continue;
    measured.push_back(pixel);
    cluster->points_C.push_back(p.cast<double>());
    cluster->center_C += cluster->points_C.back();
  }
  cluster->pixels = std::move(measured);
  if (!cluster->points_C.empty()) {
    cluster->center_C /= static_cast<double>(cluster->points_C.size());
  }
}

}  // namespace

void BackgroundConfig::Validate() const {
  CheckRange(max_deviations, 0.1, 100.0, "max_deviations");
  CheckRange(min_shadow, 0.0, 1.0, "min_shadow");
  CheckRange(median_px, 1, 31, "median_px");
  if (median_px % 2 == 0) Throw<ConfigError>("median_px = {} must be odd", median_px);
  CheckRange(blur_sigma_px, 0.0, 20.0, "blur_sigma_px");
  CheckRange(open_px, 1, 100, "open_px");
  CheckRange(close_px, 1, 100, "close_px");
  CheckRange(min_pixels, 1, 1000000, "min_pixels");
  CheckRange(same_view_m, 0.0, 1.0, "same_view_m");
  CheckRange(same_view_deg, 0.0, 180.0, "same_view_deg");
}

BackgroundModel::BackgroundModel(const std::vector<cv::Mat>& frames, const Pose& X_WC,
                                 const BackgroundConfig& config)
    : config_(config), X_WC_(X_WC) {
  config_.Validate();
  if (frames.size() < 2) {
    Throw<InvalidArgument>("a background learnt from {} frames; it needs two or more",
                           frames.size());
  }
  size_ = frames.front().size();
  mixture_ = cv::createBackgroundSubtractorMOG2(
      static_cast<int>(frames.size()), config_.max_deviations * config_.max_deviations, true);
  mixture_->setShadowThreshold(config_.min_shadow);
  cv::Mat ignored;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    mixture_->apply(Denoised(frames[i]), ignored, 1.0 / static_cast<double>(i + 1));
  }
}

cv::Mat BackgroundModel::Denoised(const cv::Mat& color) const {
  if (color.type() != CV_8UC3 || color.size() != size_ || color.empty()) {
    Throw<InvalidArgument>(
        "a picture of {} x {} pixels of type {} for a background of {} x {} RGB pixels of 8 bits",
        color.cols, color.rows, color.type(), size_.width, size_.height);
  }
  cv::Mat denoised;
  cv::medianBlur(color, denoised, config_.median_px);
  if (config_.blur_sigma_px > 0.0) {
    cv::GaussianBlur(denoised, denoised, {}, config_.blur_sigma_px);
  }
  return denoised;
}

Foreground BackgroundModel::Detect(const cv::Mat& color, const cv::Mat& depth,
                                   const geometry::CameraModel& camera, const Pose& X_WC) const {
  const cv::Mat denoised = Denoised(color);
  const double moved = (X_WC.translation() - X_WC_.translation()).norm();
  const double turned = RotationDistance(X_WC.linear(), X_WC_.linear()) * kDegrees;
  if (moved > config_.same_view_m || turned > config_.same_view_deg) {
    return {{},
            fmt::format("the camera has moved by {:.3f} m and {:.2f} deg since the background was "
                        "learnt; learn it anew from here, or cut by depth",
                        moved, turned)};
  }
  cv::Mat mask;
  mixture_->apply(denoised, mask, 0.0);  // learns nothing
  mask = mask == 255;                    // shadows are not
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, Disk(config_.open_px));
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, Disk(config_.close_px));
  const double share = cv::countNonZero(mask) / static_cast<double>(mask.total());
  if (share > kMostNew) {
    return {{},
            fmt::format("{:.0f} % of the picture is new; the light has changed, or the background "
                        "is another",
                        100.0 * share)};
  }
  Foreground foreground{Components(mask, config_.min_pixels), ""};
  for (world::Cluster& cluster : foreground.clusters) {
    cluster.touches_border = TouchesBorder(cluster, size_);
  }
  if (!depth.empty()) {
    const geometry::PointImage points_C = geometry::Deproject(depth, camera);
    for (world::Cluster& cluster : foreground.clusters) AddPoints(points_C, &cluster);
    std::erase_if(foreground.clusters, [](const auto& cluster) { return cluster.pixels.empty(); });
  }
  if (foreground.clusters.empty()) {
    foreground.reason = fmt::format("{} of {} pixels are new, none of them {} together",
                                    cv::countNonZero(mask), mask.total(), config_.min_pixels);
  }
  return foreground;
}

}  // namespace secondlook::perception

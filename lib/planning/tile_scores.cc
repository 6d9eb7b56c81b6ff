#include "lib/planning/tile_scores.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

#include "lib/common/check_range.h"
#include "lib/common/error.h"

namespace secondlook::planning {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kLevels = 256;
constexpr int kSlopeRadius_px = 2;      // of the window that a slope is fitted to: sensor noise
constexpr int kMinSlopePoints = 8;      // in it
constexpr double kEnoughNormals = 4e4;  // of a larger crop not every pixel gets one

bool IsKnown(float z) { return std::isfinite(z) && z > 0.0F; }

cv::Rect CellRect(cv::Size size, int row, int column) {
  const int left = column * size.width / 3;
  const int top = row * size.height / 3;
  return {left, top, (column + 1) * size.width / 3 - left, (row + 1) * size.height / 3 - top};
}

/// The share of each intensity level.
std::array<double, kLevels> Histogram(const cv::Mat& gray) {
  std::array<double, kLevels> p{};
  for (int v = 0; v < gray.rows; ++v) {
    const auto* row = gray.ptr<std::uint8_t>(v);
    for (int u = 0; u < gray.cols; ++u) p[row[u]] += 1.0;
  }
  for (double& share : p) share /= static_cast<double>(gray.total());
  return p;
}

double Level(int i) { return i / (kLevels - 1.0); }

double CentralMoment(const std::array<double, kLevels>& p, int order) {
  double mean = 0.0;
  for (int i = 0; i < kLevels; ++i) mean += Level(i) * p[i];
  double moment = 0.0;
  for (int i = 0; i < kLevels; ++i) moment += std::pow(Level(i) - mean, order) * p[i];
  return moment;
}

template <class Values>
double Entropy(const Values& p) {
  double entropy = 0.0;
  for (const double share : p) {
    if (share > 0.0) entropy -= share * std::log2(share);
  }
  return entropy;
}

/// Depth with the farthest where there is none.
cv::Mat Filled(const cv::Mat& depth) {
  float farthest = 0.0F;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      if (IsKnown(z)) farthest = std::max(farthest, z);
    }
  }
  cv::Mat filled = depth.clone();
  filled.forEach<float>([&](float& z, const int*) {
    if (!IsKnown(z)) z = farthest;
  });
  return filled;
}

/// Eq. 6 to 8 as they stand, over the foreground in `tile`; at the image's border the derivative is
/// to the pixel itself. NaN without foreground.
double Parallelism(const cv::Mat& depth, const cv::Mat& foreground, const cv::Rect& tile) {
  double sum = 0.0;
  int count = 0;
  for (int v = tile.y; v < tile.y + tile.height; ++v) {
    for (int u = tile.x; u < tile.x + tile.width; ++u) {
      if (foreground.at<std::uint8_t>(v, u) == 0) continue;
      const double dx = depth.at<float>(v, std::min(u + 1, depth.cols - 1)) -
                        depth.at<float>(v, std::max(u - 1, 0));
      const double dy = depth.at<float>(std::min(v + 1, depth.rows - 1), u) -
                        depth.at<float>(std::max(v - 1, 0), u);
      sum += 1.0 / std::sqrt(dx * dx + dy * dy + 1.0);
      ++count;
    }
  }
  return count == 0 ? kNone : -sum / count;
}

/// The normal of the plane through the object's pixels around (u, v), towards the camera (x right,
/// y down, z = 1 for one that faces it); all NaN when they are too few.
Eigen::Vector3d NormalAt(const cv::Mat& depth, const cv::Mat& foreground, int u, int v,
                         double focal_length_px) {
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sums = Eigen::Vector3d::Zero();
  for (int y = std::max(v - kSlopeRadius_px, 0); y <= std::min(v + kSlopeRadius_px, depth.rows - 1);
       ++y) {
    for (int x = std::max(u - kSlopeRadius_px, 0);
         x <= std::min(u + kSlopeRadius_px, depth.cols - 1); ++x) {
      if (foreground.at<std::uint8_t>(y, x) == 0) continue;
      const Eigen::Vector3d position(x - u, y - v, 1.0);
      products += position * position.transpose();
      sums += position * depth.at<float>(y, x);
    }
  }
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNone);
  if (products(2, 2) < kMinSlopePoints || products.determinant() < 1e-6) return none;
  const Eigen::Vector3d plane = products.ldlt().solve(sums);
  const double px_m = plane.z() / focal_length_px;
  // As on the right of a ball, a surface whose depth grows to the right faces right.
  return Eigen::Vector3d(plane.x() / px_m, plane.y() / px_m, 1.0).normalized();
}

/// By pixel of the foreground, where it is known.
using Normals = cv::Mat_<cv::Vec3d>;  // NaN elsewhere

Normals AllNormals(const cv::Mat& depth, const cv::Mat& foreground, double focal_length_px) {
  Normals normals(depth.size(), cv::Vec3d(kNone, kNone, kNone));
  const int step = std::max(1, static_cast<int>(std::sqrt(depth.total() / kEnoughNormals)));
  for (int v = 0; v < depth.rows; v += step) {
    for (int u = 0; u < depth.cols; u += step) {
      if (foreground.at<std::uint8_t>(v, u) == 0) continue;
      const Eigen::Vector3d n = NormalAt(depth, foreground, u, v, focal_length_px);
      normals(v, u) = {n.x(), n.y(), n.z()};
    }
  }
  return normals;
}

double MetricParallelism(const Normals& normals, const cv::Rect& tile, double max_slant_deg) {
  double sum = 0.0;
  int count = 0;
  for (int v = tile.y; v < tile.y + tile.height; ++v) {
    for (int u = tile.x; u < tile.x + tile.width; ++u) {
      if (std::isnan(normals(v, u)[2])) continue;
      sum += normals(v, u)[2];
      ++count;
    }
  }
  if (count == 0) return kNone;
  return -std::max(sum / count, std::cos(max_slant_deg * std::numbers::pi / 180.0));
}

/// How the intensity [0, 1] grows with n_x and n_y, as on a matt surface under one light: the least
/// squares fit over the object, black and white pixels left out, as they say nothing of light.
/// Empty when the surface does not bend enough to tell.
std::optional<Eigen::Vector2d> Shading(const cv::Mat& gray, const Normals& normals) {
  constexpr int kBlack = 2;
  constexpr int kWhite = 253;
  constexpr int kMinPixels = 30;
  constexpr double kDamping = 0.02;  // variance of a normal's component by which a fit is held back
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sums = Eigen::Vector3d::Zero();
  for (int v = 0; v < gray.rows; ++v) {
    for (int u = 0; u < gray.cols; ++u) {
      const int level = gray.at<std::uint8_t>(v, u);
      const cv::Vec3d& n = normals(v, u);
      if (std::isnan(n[2]) || level < kBlack || level > kWhite) continue;
      const Eigen::Vector3d terms(n[0], n[1], 1.0);
      products += terms * terms.transpose();
      sums += terms * Level(level);
    }
  }
  const double count = products(2, 2);
  if (count < kMinPixels) return std::nullopt;
  products(0, 0) += kDamping * count;
  products(1, 1) += kDamping * count;
  return products.ldlt().solve(sums).head<2>();
}

void CheckProbabilities(const std::string& of, const std::vector<double>& probabilities) {
  for (std::size_t c = 0; c < probabilities.size(); ++c) {
    if (!(probabilities[c] >= 0.0)) {
      Throw<InvalidArgument>("{}: class {} has the probability {}; it must be >= 0", of, c + 1,
                             probabilities[c]);
    }
  }
}

void Check(const ObjectCrop& crop, const TileClassification* classification) {
  if (crop.color.empty() || crop.color.type() != CV_8UC3) {
    Throw<InvalidArgument>("a crop of {} x {} pixels of type {}: an RGB image of 8 bits is needed",
                           crop.color.cols, crop.color.rows, crop.color.type());
  }
  if (!crop.depth.empty() &&
      (crop.depth.type() != CV_32FC1 || crop.depth.size() != crop.color.size())) {
    Throw<InvalidArgument>("a crop of {} x {} pixels has a depth of {} x {}, type {}",
                           crop.color.cols, crop.color.rows, crop.depth.cols, crop.depth.rows,
                           crop.depth.type());
  }
  if (!(crop.focal_length_px > 0.0)) {
    Throw<InvalidArgument>("a focal length of {} px; it must be positive", crop.focal_length_px);
  }
  if (classification == nullptr) return;
  for (int t = 0; t < kTiles; ++t) {
    const std::size_t classes = classification->tiles[t].size();
    if (classes != 0 && classes != classification->object.size()) {
      Throw<InvalidArgument>("tile '{}' is classified by {} classes, the object by {}",
                             TileName(static_cast<Tile>(t)), classes,
                             classification->object.size());
    }
    CheckProbabilities(fmt::format("tile '{}'", TileName(static_cast<Tile>(t))),
                       classification->tiles[t]);
  }
  CheckProbabilities("the object", classification->object);
}

}  // namespace

void TileScoresConfig::Validate() const {
  CheckRange(min_foreground, 0.0, 1.0, "min_foreground");
  CheckRange(min_known_depth, 0.0, 1.0, "min_known_depth");
  CheckRange(max_slant_deg, 0.0, 90.0, "max_slant_deg");
}

const char* TileName(Tile tile) {
  constexpr std::array kNames{"upper left", "top",        "upper right", "left",
                              "right",      "lower left", "bottom",      "lower right"};
  return kNames[static_cast<std::size_t>(tile)];
}

cv::Rect TileRect(cv::Size size, Tile tile) {
  const int index = static_cast<int>(tile);
  const int cell = index < 4 ? index : index + 1;  // the middle one is no Tile
  return CellRect(size, cell / 3, cell % 3);
}

Eigen::Vector2d TileDirection(Tile tile) {
  const cv::Rect rect = TileRect({3, 3}, tile);
  return Eigen::Vector2d(rect.x - 1, rect.y - 1).normalized();
}

cv::Mat DepthForeground(const cv::Mat& depth) {
  const cv::Mat filled = Filled(depth);
  double nearest = 0.0;
  double farthest = 0.0;
  cv::minMaxLoc(filled, &nearest, &farthest);
  if (farthest == nearest) return cv::Mat::zeros(depth.size(), CV_8UC1);
  cv::Mat levels;
  const double scale = 255.0 / (farthest - nearest);
  filled.convertTo(levels, CV_8UC1, scale, -nearest * scale);
  cv::Mat foreground;
  cv::threshold(levels, foreground, 0.0, 255.0, cv::THRESH_BINARY_INV | cv::THRESH_OTSU);
  return foreground;
}

std::vector<ScoredTile> ScoreTiles(const ObjectCrop& crop, const TileClassification* classification,
                                   const TileScoresConfig& config) {
  config.Validate();
  Check(crop, classification);
  cv::Mat gray;
  cv::cvtColor(crop.color, gray, cv::COLOR_RGB2GRAY);
  const cv::Mat known = crop.depth.empty() ? cv::Mat() : cv::Mat(crop.depth > 0.0F);
  const bool has_depth = !known.empty() &&
                         cv::countNonZero(known) >= config.min_known_depth * crop.depth.total() &&
                         cv::countNonZero(known) > 0;
  const cv::Mat depth = has_depth ? Filled(crop.depth) : cv::Mat();
  const cv::Mat foreground = has_depth ? DepthForeground(crop.depth) : cv::Mat();
  const Normals normals =
      has_depth ? AllNormals(depth, foreground, crop.focal_length_px) : Normals();
  const std::optional<Eigen::Vector2d> shading = has_depth ? Shading(gray, normals) : std::nullopt;

  std::vector<ScoredTile> tiles;
  for (int t = 0; t < kTiles; ++t) {
    ScoredTile& scored = tiles.emplace_back();
    scored.tile = static_cast<Tile>(t);
    scored.scores.fill(kNone);
    const auto score = [&](Criterion criterion) -> double& {
      return scored.scores[static_cast<std::size_t>(criterion)];
    };
    const cv::Rect rect = TileRect(gray.size(), scored.tile);
    if (rect.empty()) {
      scored.refusal =
          fmt::format("a crop of {} x {} pixels has none in this tile", gray.cols, gray.rows);
      continue;
    }
    const std::array<double, kLevels> p = Histogram(gray(rect));
    score(Criterion::kVariance) = 1.0 - 1.0 / (1.0 + CentralMoment(p, 2));
    score(Criterion::kThirdMoment) = 1.0 / (1.0 + std::abs(CentralMoment(p, 3)));
    for (const double share : p) {
      double& uniformity = score(Criterion::kUniformity);
      uniformity = (std::isnan(uniformity) ? 0.0 : uniformity) + share * share;
    }
    score(Criterion::kEntropy) = Entropy(p);
    if (has_depth) {
      scored.foreground = cv::countNonZero(foreground(rect)) / static_cast<double>(rect.area());
      score(Criterion::kParallelism) = Parallelism(depth, foreground, rect);
      score(Criterion::kMetricParallelism) = MetricParallelism(normals, rect, config.max_slant_deg);
      if (shading) score(Criterion::kLight) = shading->dot(TileDirection(scored.tile));
      if (scored.foreground < config.min_foreground) {
        scored.refusal =
            fmt::format("shows none of the object: {:.0f} % of its pixels, {:.0f} % needed",
                        100.0 * scored.foreground, 100.0 * config.min_foreground);
      }
    }
    if (classification != nullptr && !classification->tiles[t].empty()) {
      const std::vector<double>& object = classification->object;
      const std::vector<double>& tile = classification->tiles[t];
      double difference = 0.0;
      for (std::size_t c = 0; c < object.size(); ++c) difference += std::abs(tile[c] - object[c]);
      score(Criterion::kDissimilarity) = difference;
      score(Criterion::kInformationGain) = Entropy(object) - Entropy(tile);
    }
  }
  return tiles;
}

}  // namespace secondlook::planning

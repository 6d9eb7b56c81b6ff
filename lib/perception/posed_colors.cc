#include "lib/perception/posed_colors.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/LU>

namespace secondlook::perception {
namespace {

using geometry::DepthRasteriser;
using geometry::PixelRect;

constexpr double kPairs = 1200.0;
/// Fine errors (a print a pixel aside) are alike over so many pixels, coarse ones (a shadow, a
/// worn label) over a block; and so large they may be anyhow, in tones.
constexpr double kFinePatch_px = 49.0;
constexpr int kBlock_px = 21;
constexpr double kFineFloor = 0.1;
constexpr double kCoarseFloor = 0.2;
/// Beyond this, the ratio is surer than its assumptions are.
constexpr double kMostRatio = 8.0;
constexpr double kMostDifference = 2.0;  // a highlight is no more than that
constexpr int kMostShift_px = 2;         // of a pose that is as good as depth makes it

DepthRasteriser Rendered(const RecognitionModel& model, const Pose& X_CM, const View& view) {
  DepthRasteriser rasteriser;
  rasteriser.Render(model.mesh, X_CM, view.camera,
                    geometry::ImageBounds(model.mesh, X_CM, view.camera, 1));
  return rasteriser;
}

PixelRect Common(const PixelRect& a, const PixelRect& b) {
  PixelRect both;
  both.x = std::max(a.x, b.x);
  both.y = std::max(a.y, b.y);
  both.width = std::min(a.x + a.width, b.x + b.width) - both.x;
  both.height = std::min(a.y + a.height, b.y + b.height) - both.y;
  return both;
}

/// What is left between the tones that were measured and those to expect, at pixels of a grid.
struct Residuals {
  std::vector<Eigen::Vector3d> coarse;  ///< Mean of the block that the pixel lies in.
  std::vector<Eigen::Vector3d> fine;    ///< What the pixel differs from that.
};

Residuals ResidualsOf(const std::vector<ColorPair>& pairs, const std::vector<int>& blocks,
                      int block_count) {
  const auto count = static_cast<std::size_t>(block_count);
  std::vector<Eigen::Vector3d> sums(count, Eigen::Vector3d::Zero());
  std::vector<double> counts(count, 0.0);
  Residuals residuals;
  residuals.fine = ToneDifferences(pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Eigen::Vector3d& e = residuals.fine[i];
    e = e.cwiseMax(-kMostDifference).cwiseMin(kMostDifference);
    sums[static_cast<std::size_t>(blocks[i])] += e;
    counts[static_cast<std::size_t>(blocks[i])] += 1.0;
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto block = static_cast<std::size_t>(blocks[i]);
    residuals.coarse.emplace_back(sums[block] / counts[block]);
    residuals.fine[i] -= residuals.coarse[i];
  }
  return residuals;
}

/// The logarithm of the generalised variance of `residuals`.
double LogVariance(const std::vector<Eigen::Vector3d>& residuals, double floor) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& e : residuals) sum += e * e.transpose();
  const Eigen::Matrix3d covariance =
      sum / static_cast<double>(residuals.size()) + floor * floor * Eigen::Matrix3d::Identity();
  return std::log(covariance.determinant());
}

/// The grid of pixels at which colours are compared, and the blocks that they lie in.
struct Grid {
  explicit Grid(const PixelRect& pixels)
      : window(pixels),
        step(std::max(1, static_cast<int>(std::sqrt(pixels.area() / kPairs)))),
        columns(pixels.width / kBlock_px + 1) {}

  int BlockOf(int u, int v) const {
    return (v - window.y) / kBlock_px * columns + (u - window.x) / kBlock_px;
  }
  int blocks() const { return columns * (window.height / kBlock_px + 1); }

  /// Calls `visit(u, v)` for each pixel.
  template <class Visit>
  void ForEach(const Visit& visit) const {
    for (int v = window.y; v < window.y + window.height; v += step) {
      for (int u = window.x; u < window.x + window.width; u += step) visit(u, v);
    }
  }

  PixelRect window;
  int step;
  int columns;
};

/// The mean square of what tones differ from the mean of their block.
double FineVariance(const std::vector<Eigen::Vector3d>& tones, const std::vector<int>& blocks,
                    int block_count) {
  const auto count = static_cast<std::size_t>(block_count);
  std::vector<Eigen::Vector3d> sums(count, Eigen::Vector3d::Zero());
  std::vector<double> counts(count, 0.0);
  double squares = 0.0;
  for (std::size_t i = 0; i < tones.size(); ++i) {
    sums[static_cast<std::size_t>(blocks[i])] += tones[i];
    counts[static_cast<std::size_t>(blocks[i])] += 1.0;
    squares += tones[i].squaredNorm();
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (counts[k] > 0.0) squares -= sums[k].squaredNorm() / counts[k];
  }
  return squares / static_cast<double>(tones.size());
}

}  // namespace

PosedColors::PosedColors(const RecognitionModel& model, const Pose& X_CM, const View& view)
    : model_(model),
      view_(view),
      rendered_(Rendered(model, X_CM, view)),
      colors_(model.mesh, rendered_) {
  shift_ = BestShift();
}

std::optional<ColorPair> PosedColors::PairAt(int u, int v) const {
  const PixelRect& window = rendered_.window();
  const auto& color = colors_.Mean(u - window.x, v - window.y);
  if (!color) return {};
  const int at = (v - window.y) * window.width + (u - window.x);
  const double z = rendered_.depth()[static_cast<std::size_t>(at)];
  const auto measured = static_cast<double>(view_.depth.at<float>(v, u));
  if (std::abs(measured - z) > DepthTolerance(z)) return {};  // NaN passes: dark or shiny
  const int x = std::clamp(u + shift_.x, 0, view_.color.cols - 1);
  const int y = std::clamp(v + shift_.y, 0, view_.color.rows - 1);
  return ColorPair{MeanColor(view_.color, x, y), *color, rendered_.Normal(model_.mesh, at)};
}

cv::Point PosedColors::BestShift() const {
  if (view_.color.empty()) return {};
  const Grid grid(rendered_.window());
  std::vector<cv::Point> pixels;
  std::vector<Eigen::Vector3d> modelled;
  std::vector<int> blocks;
  grid.ForEach([&](int u, int v) {
    const std::optional<ColorPair> pair = PairAt(u, v);
    if (!pair) return;
    pixels.emplace_back(u, v);
    modelled.push_back(ToneOf(pair->modelled));
    blocks.push_back(grid.BlockOf(u, v));
  });
  if (pixels.empty()) return {};
  const auto variance = [&](const cv::Point& shift) {
    std::vector<Eigen::Vector3d> tones(pixels.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const int x = std::clamp(pixels[i].x + shift.x, 0, view_.color.cols - 1);
      const int y = std::clamp(pixels[i].y + shift.y, 0, view_.color.rows - 1);
      tones[i] = ToneOf(MeanColor(view_.color, x, y)) - modelled[i];
    }
    return FineVariance(tones, blocks, grid.blocks());
  };
  // Downhill from where it was rendered, to the best of the eight neighbours each time.
  cv::Point best;
  double least = variance(best);
  for (int round = 0; round < kMostShift_px; ++round) {
    const cv::Point from = best;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0) continue;
        const cv::Point shift = from + cv::Point(dx, dy);
        const double there = variance(shift);
        if (there >= least) continue;
        least = there;
        best = shift;
      }
    }
    if (best == from) break;
  }
  return best;
}

std::optional<double> PosedColors::LogRatio(const PosedColors& other) const {
  if (view_.color.empty()) return {};
  const Grid grid(Common(rendered_.window(), other.rendered_.window()));
  std::vector<ColorPair> own_pairs;
  std::vector<ColorPair> other_pairs;
  std::vector<int> blocks;  // by pair
  grid.ForEach([&](int u, int v) {
    const std::optional<ColorPair> here = PairAt(u, v);
    const std::optional<ColorPair> there = here ? other.PairAt(u, v) : std::nullopt;
    if (!there) return;
    own_pairs.push_back(*here);
    other_pairs.push_back(*there);
    blocks.push_back(grid.BlockOf(u, v));
  });
  if (own_pairs.size() < 20) return {};
  const Residuals own = ResidualsOf(own_pairs, blocks, grid.blocks());
  const Residuals others = ResidualsOf(other_pairs, blocks, grid.blocks());
  const double pixels = static_cast<double>(own_pairs.size()) * grid.step * grid.step;
  const auto ratio = [&](const auto& ours, const auto& theirs, double patch, double floor) {
    return 0.5 * pixels / patch * (LogVariance(theirs, floor) - LogVariance(ours, floor));
  };
  const double sum = ratio(own.fine, others.fine, kFinePatch_px, kFineFloor) +
                     ratio(own.coarse, others.coarse, kBlock_px * kBlock_px, kCoarseFloor);
  return std::clamp(sum, -kMostRatio, kMostRatio);
}

}  // namespace secondlook::perception

#include "lib/perception/posed_colors.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/LU>

#include "lib/perception/color_match.h"

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

}  // namespace

PosedColors::PosedColors(const RecognitionModel& model, const Pose& X_CM, const View& view)
    : model_(model),
      view_(view),
      rendered_(Rendered(model, X_CM, view)),
      colors_(model.mesh, rendered_) {}

std::optional<double> PosedColors::LogRatio(const PosedColors& other) const {
  if (view_.color.empty()) return {};
  const PixelRect window = Common(rendered_.window(), other.rendered_.window());
  const int step = std::max(1, static_cast<int>(std::sqrt(window.area() / kPairs)));
  std::vector<ColorPair> own_pairs;
  std::vector<ColorPair> other_pairs;
  std::vector<int> blocks;  // by pair
  const int columns = window.width / kBlock_px + 1;
  for (int v = window.y; v < window.y + window.height; v += step) {
    for (int u = window.x; u < window.x + window.width; u += step) {
      const auto measured = static_cast<double>(view_.depth.at<float>(v, u));
      /// What `posed` has at the pixel; empty where that is not what was measured.
      const auto pair_of = [&](const PosedColors& posed) -> std::optional<ColorPair> {
        const PixelRect& own = posed.rendered_.window();
        const auto& color = posed.colors_.Mean(u - own.x, v - own.y);
        if (!color) return {};
        const int at = (v - own.y) * own.width + (u - own.x);
        const double z = posed.rendered_.depth()[static_cast<std::size_t>(at)];
        if (std::abs(measured - z) > DepthTolerance(z)) return {};  // NaN passes: dark or shiny
        return ColorPair{{}, *color, posed.rendered_.Normal(model_.mesh, at)};
      };
      std::optional<ColorPair> here = pair_of(*this);
      std::optional<ColorPair> there = here ? pair_of(other) : std::nullopt;
      if (!there) continue;
      here->measured = MeanColor(view_.color, u, v);
      there->measured = here->measured;
      own_pairs.push_back(*here);
      other_pairs.push_back(*there);
      blocks.push_back((v - window.y) / kBlock_px * columns + (u - window.x) / kBlock_px);
    }
  }
  if (own_pairs.size() < 20) return {};
  const int block_count = columns * (window.height / kBlock_px + 1);
  const Residuals own = ResidualsOf(own_pairs, blocks, block_count);
  const Residuals others = ResidualsOf(other_pairs, blocks, block_count);
  const double pixels = static_cast<double>(own_pairs.size()) * step * step;
  const auto ratio = [&](const auto& ours, const auto& theirs, double patch, double floor) {
    return 0.5 * pixels / patch * (LogVariance(theirs, floor) - LogVariance(ours, floor));
  };
  const double sum = ratio(own.fine, others.fine, kFinePatch_px, kFineFloor) +
                     ratio(own.coarse, others.coarse, kBlock_px * kBlock_px, kCoarseFloor);
  return std::clamp(sum, -kMostRatio, kMostRatio);
}

}  // namespace secondlook::perception

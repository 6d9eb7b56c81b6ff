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

constexpr double kPairs = 2500.0;
constexpr double kPatch_px = 49.0;       // neighbouring pixels err alike
constexpr double kToneFloor = 0.1;       // of the sensor's noise and of resampling, in tones
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

/// Of the tones that were measured less those to expect.
Eigen::Matrix3d Covariance(const std::vector<ColorPair>& pairs) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& difference : ToneDifferences(pairs)) {
    const Eigen::Vector3d e = difference.cwiseMax(-kMostDifference).cwiseMin(kMostDifference);
    sum += e * e.transpose();
  }
  return sum / static_cast<double>(pairs.size()) +
         kToneFloor * kToneFloor * Eigen::Matrix3d::Identity();
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
    }
  }
  if (own_pairs.size() < 20) return {};
  const double patches = static_cast<double>(own_pairs.size()) * step * step / kPatch_px;
  return 0.5 * patches *
         std::log(Covariance(other_pairs).determinant() / Covariance(own_pairs).determinant());
}

}  // namespace secondlook::perception

#include "lib/perception/verify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "lib/common/check_range.h"
#include "lib/perception/color_match.h"
#include "lib/perception/depth_bias.h"

namespace secondlook::perception {
namespace {

using geometry::DepthRasteriser;
using geometry::PixelRect;

/// Of what lies mostly beside the picture, the part within may be a part of anything.
constexpr double kLeastInPicture = 0.5;
constexpr std::size_t kPicturePoints = 200;
/// The error of pose and model [m], and that share of the model's width where it is more: a
/// specimen differs from its scan by its bulk. A thin thing is no less exact for being long.
constexpr double kModelError = 0.004;
constexpr double kWidthError = 0.03;

/// Of a pixel of the window.
enum class Seen : std::uint8_t {
  kNothing,     ///< No surface, or its rim.
  kUnmeasured,  ///< Surface, but no measurement.
  kHidden,      ///< Behind a nearer measurement.
  kMatching,
  kWrong,       ///< Measured at another depth.
  kSeeThrough,  ///< Measured well behind.
};

/// The rendered surface without the pixels next to its outline or to a step in depth.
std::vector<char> WithoutRim(const DepthRasteriser& rendered, double step) {
  const PixelRect& window = rendered.window();
  const std::vector<float>& depth = rendered.depth();
  std::vector<char> inner(depth.size(), 0);
  for (int y = 1; y + 1 < window.height; ++y) {
    for (int x = 1; x + 1 < window.width; ++x) {
      const int at = y * window.width + x;
      const float z = depth[static_cast<std::size_t>(at)];
      if (std::isnan(z)) continue;
      bool flat = true;
      for (int dy = -1; dy <= 1 && flat; ++dy) {
        for (int dx = -1; dx <= 1 && flat; ++dx) {
          // NaN fails the comparison as well.
          const float other = depth[static_cast<std::size_t>(at + dy * window.width + dx)];
          flat = std::abs(other - z) < step;
        }
      }
      inner[static_cast<std::size_t>(at)] = flat ? 1 : 0;
    }
  }
  return inner;
}

/// Measured minus rendered depth by pixel of the window; NaN where either is missing.
std::vector<float> Differences(const DepthRasteriser& rendered, const View& view) {
  const PixelRect& window = rendered.window();
  std::vector<float> difference(rendered.depth().size());
  for (int y = 0; y < window.height; ++y) {
    const float* measured = view.depth.ptr<float>(window.y + y) + window.x;
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(window.width);
    for (int x = 0; x < window.width; ++x) {
      const std::size_t at = row + static_cast<std::size_t>(x);
      difference[at] = measured[x] - rendered.depth()[at];
    }
  }
  return difference;
}

/// Takes what bends smoothly over the object out of `difference`.
void TakeOutBend(const std::vector<char>& inner, const PixelRect& window, double metres_per_pixel,
                 double gate, std::vector<float>* difference) {
  const DepthBias bias(*difference, inner, window, metres_per_pixel, gate);
  for (int y = 0; y < window.height; ++y) {
    for (int x = 0; x < window.width; ++x) {
      (*difference)[static_cast<std::size_t>(y * window.width + x)] -=
          static_cast<float>(bias.At(x, y));
    }
  }
}

/// The mean over 5 x 5 pixels of the differences that lie within `gate`.
std::vector<float> Smooth(const std::vector<float>& difference, const PixelRect& window,
                          float gate) {
  const auto width = static_cast<std::size_t>(window.width);
  const auto height = static_cast<std::size_t>(window.height);
  std::vector<float> sum(difference.size(), 0.0F);
  std::vector<float> count(difference.size(), 0.0F);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const float d = difference[y * width + x];
      if (!(std::abs(d) < gate)) continue;
      const std::size_t first = x < 2 ? 0 : x - 2;
      const std::size_t last = std::min(x + 2, width - 1);
      for (std::size_t k = first; k <= last; ++k) {
        sum[y * width + k] += d;
        count[y * width + k] += 1.0F;
      }
    }
  }
  std::vector<float> mean(difference.size());
  for (std::size_t y = 0; y < height; ++y) {
    const std::size_t first = y < 2 ? 0 : y - 2;
    const std::size_t last = std::min(y + 2, height - 1);
    for (std::size_t x = 0; x < width; ++x) {
      float s = 0.0F;
      float n = 0.0F;
      for (std::size_t k = first; k <= last; ++k) {
        s += sum[k * width + x];
        n += count[k * width + x];
      }
      mean[y * width + x] = n > 0.0F ? s / n : 0.0F;
    }
  }
  return mean;
}

/// Pairs for up to about 700 of the pixels that match or have no measurement (dark and shiny things
/// return no depth but have a colour), on a regular grid.
std::vector<ColorPair> PairColors(const RecognitionModel& model, const View& view,
                                  const std::vector<Seen>& seen, int pixels,
                                  const DepthRasteriser& rendered) {
  constexpr double kPairs = 700.0;
  const PixelRect& window = rendered.window();
  const int step = std::max(1, static_cast<int>(std::sqrt(pixels / kPairs)));
  std::vector<Eigen::Vector3f> modelled(seen.size());
  std::vector<char> known(seen.size(), 0);
  const auto color_at = [&](int at) -> const Eigen::Vector3f& {
    const auto index = static_cast<std::size_t>(at);
    if (known[index] == 0) {
      known[index] = 1;
      modelled[index] = geometry::ColorAt(model.mesh, rendered.triangle()[index],
                                          rendered.Weights(model.mesh, at));
    }
    return modelled[index];
  };
  std::vector<ColorPair> pairs;
  for (int y = 1; y + 1 < window.height; y += step) {
    for (int x = 1; x + 1 < window.width; x += step) {
      const int at = y * window.width + x;
      const Seen what = seen[static_cast<std::size_t>(at)];
      if (what != Seen::kMatching && what != Seen::kUnmeasured) continue;
      // They are off the rim, so all neighbours have a surface.
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) sum += color_at(at + dy * window.width + dx);
      }
      pairs.push_back({MeanColor(view.color, window.x + x, window.y + y), sum / 9.0F,
                       rendered.Normal(model.mesh, at)});
    }
  }
  return pairs;
}

/// The share of the model's points that lie within the picture, hidden or not.
double ShareInPicture(const RecognitionModel& model, const Pose& X_CM,
                      const geometry::CameraModel& camera) {
  const std::size_t count = std::min(kPicturePoints, model.points.size());
  std::size_t within = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (camera.Project(X_CM * model.points[i].point.cast<double>())) ++within;
  }
  return static_cast<double>(within) / static_cast<double>(std::max<std::size_t>(1, count));
}

std::string ReasonAgainst(const world::Verification& v, double in_picture, double inner,
                          double explained, double unmeasured, double lowest,
                          const VerifyConfig& config) {
  if (in_picture < kLeastInPicture) {
    return fmt::format("only {:.0f} % of it lies within the picture (at least {:.0f} %)",
                       100 * in_picture, 100 * kLeastInPicture);
  }
  if (inner < config.min_inner) {
    return fmt::format("only {:.0f} % of its silhouette is no rim (at least {:.0f} %): too thin",
                       100 * inner, 100 * config.min_inner);
  }
  if (v.visible < config.min_visible_px) {
    return fmt::format("only {} pixels of it are visible (at least {})", v.visible,
                       config.min_visible_px);
  }
  if (v.visible_fraction < config.min_visible_fraction) {
    return fmt::format("only {:.0f} % of it is visible (at least {:.0f} %)",
                       100 * v.visible_fraction, 100 * config.min_visible_fraction);
  }
  if (unmeasured > config.max_unmeasured) {
    return fmt::format("nothing is measured on {:.0f} % of it (at most {:.0f} %)", 100 * unmeasured,
                       100 * config.max_unmeasured);
  }
  if (v.see_through > config.max_see_through * v.visible) {
    return fmt::format("the camera sees through {:.0f} % of it (at most {:.0f} %)",
                       100.0 * v.see_through / v.visible, 100 * config.max_see_through);
  }
  if (v.matching < config.min_matching * v.visible) {
    return fmt::format("{:.0f} % of it has the right depth (at least {:.0f} %)",
                       100.0 * v.matching / v.visible, 100 * config.min_matching);
  }
  if (explained < config.min_explained) {
    return fmt::format("it explains {:.0f} % of the cluster (at least {:.0f} %)", 100 * explained,
                       100 * config.min_explained);
  }
  if (v.quality < config.min_quality) {
    return fmt::format("q_h = {:.2f} (at least {:.2f})", v.quality, config.min_quality);
  }
  if (lowest > config.max_gap_m || lowest < -config.max_sink_m) {
    return fmt::format("its lowest point is {:.0f} mm above the support plane ({:.0f} to {:.0f})",
                       1000 * lowest, -1000 * config.max_sink_m, 1000 * config.max_gap_m);
  }
  if (v.color_agreement < config.min_color_agreement) {
    return fmt::format("its colours agree by {:.2f} (at least {:.2f})", v.color_agreement,
                       config.min_color_agreement);
  }
  return {};
}

/// The middle one of the three sides of the model's box in M [m].
double Width(const RecognitionModel& model) {
  Eigen::AlignedBox3f box_M;
  for (const Eigen::Vector3f& p_M : model.hull) box_M.extend(p_M);
  Eigen::Vector3f sides = box_M.sizes();
  std::sort(sides.begin(), sides.end());
  return sides[1];
}

}  // namespace

void VerifyConfig::Validate() const {
  CheckRange(min_quality, 0.0, 1.0, "min_quality");
  CheckRange(min_visible_px, 1, 1e6, "min_visible_px");
  CheckRange(min_visible_fraction, 0.0, 1.0, "min_visible_fraction");
  CheckRange(min_inner, 0.0, 1.0, "min_inner");
  CheckRange(max_unmeasured, 0.0, 1.0, "max_unmeasured");
  CheckRange(min_matching, 0.0, 1.0, "min_matching");
  CheckRange(max_see_through, 0.0, 1.0, "max_see_through");
  CheckRange(min_explained, 0.0, 1.0, "min_explained");
  CheckRange(min_color_agreement, 0.0, 1.0, "min_color_agreement");
  CheckRange(max_gap_m, 0.0, 1.0, "max_gap_m");
  CheckRange(max_sink_m, 0.0, 1.0, "max_sink_m");
}

world::Verification Verify(const RecognitionModel& model, const Pose& X_CM, const View& view,
                           int label, int cluster_pixels, const VerifyConfig& config,
                           DepthRasteriser* rasteriser, double* score) {
  world::Verification result;
  result.cluster = cluster_pixels;
  result.color_agreement = std::numeric_limits<double>::quiet_NaN();
  rasteriser->Render(model.mesh, X_CM, view.camera,
                     geometry::ImageBounds(model.mesh, X_CM, view.camera, 2));
  const PixelRect& window = rasteriser->window();
  const double z = std::max(0.1, (X_CM * model.center_M).z());
  const double model_error = std::max(kModelError, kWidthError * Width(model));
  const double tolerance = DepthTolerance(z) + model_error - kModelError;
  const double mean_tolerance = model_error + geometry::DepthSigma(z);
  const std::vector<char> inner = WithoutRim(*rasteriser, 2.0 * tolerance);
  std::vector<float> difference = Differences(*rasteriser, view);
  TakeOutBend(inner, window, z / view.camera.fx, 2.0 * tolerance, &difference);
  const std::vector<float> mean = Smooth(difference, window, static_cast<float>(2.0 * tolerance));
  std::vector<Seen> seen(difference.size(), Seen::kNothing);
  int explained_pixels = 0;
  int unmeasured = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (inner[i] == 0) continue;
    ++result.rendered;
    const float d = difference[i];
    if (std::isnan(d)) {
      ++unmeasured;
      seen[i] = Seen::kUnmeasured;
      continue;
    }
    const int x = window.x + static_cast<int>(i) % window.width;
    const int y = window.y + static_cast<int>(i) / window.width;
    const bool own = view.labels.at<int>(y, x) == label;
    if (d < -tolerance && !own) {
      seen[i] = Seen::kHidden;
      continue;
    }
    ++result.visible;
    if (std::abs(d) <= tolerance && std::abs(mean[i]) <= mean_tolerance) {
      seen[i] = Seen::kMatching;
      ++result.matching;
      explained_pixels += own ? 1 : 0;
    } else if (d > tolerance + 0.004) {
      seen[i] = Seen::kSeeThrough;
      ++result.see_through;
    } else {
      seen[i] = Seen::kWrong;
    }
  }
  const double explained = std::min(1.0, explained_pixels / std::max(1.0, 1.0 * cluster_pixels));
  if (result.rendered > 0) result.visible_fraction = 1.0 * result.visible / result.rendered;
  if (result.visible > 0) {
    result.quality = 1.0 * result.matching / result.visible * explained * explained;
  }
  if (!view.color.empty() && result.matching > 0) {
    result.color_agreement =
        CompareColors(PairColors(model, view, seen, result.matching + unmeasured, *rasteriser));
  }
  const auto silhouette = static_cast<double>(
      std::count_if(rasteriser->triangle().begin(), rasteriser->triangle().end(),
                    [](int triangle) { return triangle >= 0; }));
  result.reason = ReasonAgainst(
      result, ShareInPicture(model, X_CM, view.camera), result.rendered / std::max(1.0, silhouette),
      explained, 1.0 * unmeasured / std::max(1, result.rendered),
      LowestHeight(model, X_CM, view.PlaneUnder(X_CM * model.center_M)), config);
  result.accepted = result.reason.empty();
  *score = ScoreOf(result, explained);
  return result;
}

int InnerPixels(const View& view, int label, const world::Cluster& cluster) {
  const int width = view.camera.width;
  int count = 0;
  for (const int pixel : cluster.pixels) {
    const int x = pixel % width;
    const int y = pixel / width;
    if (x == 0 || y == 0 || x + 1 == width || y + 1 == view.camera.height) continue;
    bool inner = true;
    for (int v = y - 1; v <= y + 1; ++v) {
      const int* row = view.labels.ptr<int>(v);
      inner = inner && row[x - 1] == label && row[x] == label && row[x + 1] == label;
    }
    count += inner ? 1 : 0;
  }
  return count;
}

double ScoreOf(const world::Verification& v, double explained) {
  if (v.visible == 0) return 0.0;
  const double matching = 1.0 * v.matching / v.visible;
  const double through = 1.0 * v.see_through / v.visible;
  double odds = 14.0 * (matching - 0.85) + 8.0 * (explained - 0.85) - 12.0 * through;
  if (!std::isnan(v.color_agreement)) {
    // Colour speaks by the patches it is seen in, of about 7 x 7 pixels.
    const double weight = std::clamp(v.matching / 50.0, 25.0, 45.0);
    odds += weight * (v.color_agreement - 0.45);
  }
  if (!v.accepted) odds -= 2.0;
  return 1.0 / (1.0 + std::exp(-odds));
}

double LogOdds(double score) {
  const double bounded = std::clamp(score, 1e-15, 1.0 - 1e-15);
  return std::log(bounded / (1.0 - bounded));
}

}  // namespace secondlook::perception

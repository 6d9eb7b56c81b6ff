#include "sim/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "lib/common/error.h"

namespace secondlook::sim {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kSteepest = 89.0 * kRadians;  // where the growth of Nguyen's formula is cut off
constexpr double kSteepestCosine = 0.0175;     // of the same angle
constexpr double kSmooth = 0.005;              // [m] a step that a smooth surface may have

/// The quantile of the standard normal distribution at p in (0, 1), by bisection of its integral.
double NormalQuantile(double p) {
  double low = -10.0;
  double high = 10.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::numbers::sqrt2) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Standard normal values by the million: quantiles at 4096 evenly spaced probabilities, scaled to
/// variance 1, picked by 12 random bits each.
class FastGaussian {
 public:
  explicit FastGaussian(Rng* rng) : rng_(rng) {}

  float Next() {
    if (left_ == 0) {
      bits_ = rng_->Bits();
      left_ = 5;
    }
    const float value = Table()[bits_ & (kSize - 1)];
    bits_ >>= 12;
    --left_;
    return value;
  }

 private:
  static constexpr std::size_t kSize = 4096;

  static std::array<float, kSize> MakeTable() {
    std::array<double, kSize> quantiles;
    double variance = 0.0;
    for (std::size_t i = 0; i < kSize; ++i) {
      quantiles[i] = NormalQuantile((static_cast<double>(i) + 0.5) / kSize);
      variance += quantiles[i] * quantiles[i] / kSize;
    }
    std::array<float, kSize> table;
    for (std::size_t i = 0; i < kSize; ++i) {
      table[i] = static_cast<float>(quantiles[i] / std::sqrt(variance));
    }
    return table;
  }

  static const std::array<float, kSize>& Table() {
    static const std::array<float, kSize> table = MakeTable();  // constant
    return table;
  }

  Rng* rng_;
  std::uint64_t bits_{};
  int left_{};
};

/// A standard normal random field: independent values on a grid of `spacing` pixels, linear in
/// between, scaled so that the variance is 1 everywhere.
class SmoothField {
 public:
  SmoothField(int width, int height, double spacing, FastGaussian* gaussian)
      : spacing_(std::max(spacing, 1.0)),
        columns_(static_cast<int>(width / spacing_) + 2),
        values_(static_cast<std::size_t>(columns_ * (static_cast<int>(height / spacing_) + 2))) {
    for (float& value : values_) value = gaussian->Next();
  }

  double At(int u, int v) const {
    const double x = u / spacing_;
    const double y = v / spacing_;
    const int column = static_cast<int>(x);
    const int row = static_cast<int>(y);
    const double fx = x - column;
    const double fy = y - row;
    const float* node = &values_[static_cast<std::size_t>(row * columns_ + column)];
    const double mean = (1 - fy) * ((1 - fx) * node[0] + fx * node[1]) +
                        fy * ((1 - fx) * node[columns_] + fx * node[columns_ + 1]);
    const double variance = ((1 - fx) * (1 - fx) + fx * fx) * ((1 - fy) * (1 - fy) + fy * fy);
    return mean / std::sqrt(variance);
  }

 private:
  double spacing_;
  int columns_;
  std::vector<float> values_;
};

int Rounded(double pixel) { return static_cast<int>(std::floor(pixel + 0.5)); }

/// True when pixels `a` and `b` may show one smooth surface: their depths
/// differ by no more than twice what the slope at `a` explains, or by less than kSmooth. False when
/// either sees nothing.
bool SameSurface(const Render& clean, const geometry::CameraModel& model, int a, int b) {
  if (a == b) return true;
  const double z = clean.depth.ptr<float>()[a];
  const double step = std::abs(z - clean.depth.ptr<float>()[b]);
  if (step <= kSmooth) return true;
  const double cosine = std::max<double>(clean.cos_incidence.ptr<float>()[a], kSteepestCosine);
  const double slope = std::sqrt(1.0 - std::min(cosine * cosine, 1.0)) / cosine;
  const int width = clean.depth.cols;
  const double shift = std::hypot(a % width - b % width, a / width - b / width);  // [px]
  return step <= 2.0 * slope * z / model.fx * (shift + 1.0);
}

/// For each pixel the index of the pixel whose surface it sees: itself, but near an outline perhaps
/// one of the other side.
std::vector<int> JitterOutlines(const Render& clean, const geometry::CameraModel& model,
                                const NoiseConfig& config, FastGaussian* gaussian) {
  const int width = clean.depth.cols;
  const int height = clean.depth.rows;
  std::vector<int> source(static_cast<std::size_t>(width) * height);
  const SmoothField du(width, height, config.lateral_correlation_px, gaussian);
  const SmoothField dv(width, height, config.lateral_correlation_px, gaussian);
  const double sigma = config.depth_lateral_sigma_px;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int here = v * width + u;
      const int u2 = std::clamp(Rounded(u + sigma * du.At(u, v)), 0, width - 1);
      const int v2 = std::clamp(Rounded(v + sigma * dv.At(u, v)), 0, height - 1);
      const int there = v2 * width + u2;
      source[here] = SameSurface(clean, model, here, there) ? here : there;
    }
  }
  return source;
}

/// The angle [rad] of `cosine`, or 0 below 60 degrees, where it does not matter.
double IncidenceBeyond60(double cosine) { return cosine < 0.5 ? std::acos(cosine) : 0.0; }

bool BesideAStep(const cv::Mat& depth, int u, int v, double edge_jump) {
  const float z = depth.at<float>(v, u);
  const auto jumps = [&](int du, int dv) {
    const int u2 = u + du;
    const int v2 = v + dv;
    if (u2 < 0 || v2 < 0 || u2 >= depth.cols || v2 >= depth.rows) return false;
    const float z2 = depth.at<float>(v2, u2);
    return !(std::abs(z2 - z) <= edge_jump * z);  // also when nothing is seen there
  };
  return jumps(-1, 0) || jumps(1, 0) || jumps(0, -1) || jumps(0, 1);
}

double Quantised(double z, const geometry::CameraModel& model, const NoiseConfig& config) {
  if (config.disparity_step_px == 0.0) return z;
  const double scale = model.fx * config.disparity_baseline / config.disparity_step_px;
  const double steps = std::round(scale / z);
  return steps > 0.0 ? scale / steps : std::numeric_limits<double>::infinity();
}

void Require(bool ok, const char* key, double value, const char* range) {
  if (!ok) Throw<ConfigError>("'{}' = {} must be {}", key, value, range);
}

}  // namespace

void NoiseConfig::Validate() const {
  const std::pair<const char*, double> not_negative[] = {
      {"depth_axial_scale", depth_axial_scale},
      {"depth_lateral_sigma_px", depth_lateral_sigma_px},
      {"disparity_step_px", disparity_step_px},
      {"edge_jump", edge_jump},
      {"exposure_sigma", exposure_sigma},
      {"white_balance_sigma", white_balance_sigma},
      {"color_sigma", color_sigma},
      {"localisation_sigma", localisation_sigma},
      {"localisation_sigma_deg", localisation_sigma_deg},
      {"odometry_drift", odometry_drift},
      {"pan_tilt_sigma_deg", pan_tilt_sigma_deg},
      {"extrinsics_sigma", extrinsics_sigma},
      {"extrinsics_sigma_deg", extrinsics_sigma_deg},
      {"arm_sigma", arm_sigma},
      {"arm_sigma_deg", arm_sigma_deg},
      {"hand_eye_sigma", hand_eye_sigma},
      {"hand_eye_sigma_deg", hand_eye_sigma_deg},
      {"striper_range_sigma", striper_range_sigma},
      {"stamp_sigma", stamp_sigma}};
  for (const auto& [key, value] : not_negative) Require(value >= 0.0, key, value, "0 or more");
  const std::pair<const char*, double> positive[] = {{"disparity_baseline", disparity_baseline},
                                                     {"dark_luminance", dark_luminance},
                                                     {"shiny_specular", shiny_specular}};
  for (const auto& [key, value] : positive) Require(value > 0.0, key, value, "more than 0");
  Require(lateral_correlation_px >= 1.0, "lateral_correlation_px", lateral_correlation_px,
          "1 or more");
  Require(max_incidence_deg > 0.0 && max_incidence_deg <= 90.0, "max_incidence_deg",
          max_incidence_deg, "in (0, 90]");
  Require(striper_max_incidence_deg > 0.0 && striper_max_incidence_deg <= 90.0,
          "striper_max_incidence_deg", striper_max_incidence_deg, "in (0, 90]");
  Require(dark_shiny_loss >= 0.0 && dark_shiny_loss <= 1.0, "dark_shiny_loss", dark_shiny_loss,
          "in [0, 1]");
}

NoiseConfig NoiseConfig::None() {
  NoiseConfig none;
  none.depth_axial_scale = 0.0;
  none.depth_lateral_sigma_px = 0.0;
  none.disparity_step_px = 0.0;
  none.edge_jump = 0.0;
  none.max_incidence_deg = 90.0;
  none.dark_shiny_loss = 0.0;
  none.exposure_sigma = 0.0;
  none.white_balance_sigma = 0.0;
  none.color_sigma = 0.0;
  none.localisation_sigma = 0.0;
  none.localisation_sigma_deg = 0.0;
  none.odometry_drift = 0.0;
  none.pan_tilt_sigma_deg = 0.0;
  none.extrinsics_sigma = 0.0;
  none.extrinsics_sigma_deg = 0.0;
  none.arm_sigma = 0.0;
  none.arm_sigma_deg = 0.0;
  none.hand_eye_sigma = 0.0;
  none.hand_eye_sigma_deg = 0.0;
  none.striper_range_sigma = 0.0;
  none.striper_max_incidence_deg = 90.0;
  none.stamp_sigma = 0.0;
  return none;
}

double AxialSigma(double z, double incidence) {
  const double sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
  if (incidence <= 60.0 * kRadians) return sigma;
  const double angle = std::min(incidence, kSteepest);
  const double ratio = angle / (std::numbers::pi / 2 - angle);
  return sigma + 0.0001 / std::sqrt(z) * ratio * ratio;
}

double DarkShinyLoss(double luminance, double specular, double cos_incidence,
                     const NoiseConfig& config) {
  const double dark = std::clamp(1.0 - luminance / config.dark_luminance, 0.0, 1.0);
  if (dark == 0.0 || specular <= 0.0) return 0.0;
  const double shiny = std::clamp(specular / config.shiny_specular, 0.0, 1.0);
  const double facing = std::pow(std::clamp(cos_incidence, 0.0, 1.0), 20.0);  // 1 within ~10 deg
  return config.dark_shiny_loss * dark * shiny * (1.0 - 0.5 * facing);
}

cv::Mat DepthNoise(const Render& clean, const geometry::CameraModel& model, const DepthRange& range,
                   const NoiseConfig& config, Rng* rng) {
  FastGaussian gaussian(rng);
  const int width = clean.depth.cols;
  const std::vector<int> source = JitterOutlines(clean, model, config, &gaussian);
  cv::Mat seen(clean.depth.size(), CV_32FC1);
  for (std::size_t i = 0; i < source.size(); ++i) {
    seen.ptr<float>()[i] = clean.depth.ptr<float>()[source[i]];
  }
  const double min_cosine = std::cos(config.max_incidence_deg * kRadians);
  cv::Mat measured(clean.depth.size(), CV_32FC1, cv::Scalar(kNone));
  for (int v = 0; v < seen.rows; ++v) {
    for (int u = 0; u < width; ++u) {
      // Each pixel draws the same number of times, so that one surface does not shift the noise of
      // another.
      const double error = gaussian.Next();
      const double luck = gaussian.Next();
      const double z = seen.at<float>(v, u);
      if (!(z > 0.0)) continue;
      const int from = source[static_cast<std::size_t>(v) * width + u];
      const float cosine = clean.cos_incidence.ptr<float>()[from];
      if (cosine < min_cosine) continue;
      const double loss = DarkShinyLoss(clean.luminance.ptr<float>()[from],
                                        clean.specular.ptr<float>()[from], cosine, config);
      if (loss > 0.0 && 0.5 * std::erfc(luck / std::numbers::sqrt2) < loss) continue;
      if (config.edge_jump > 0.0 && BesideAStep(seen, u, v, config.edge_jump)) continue;
      const double noisy =
          z + config.depth_axial_scale * AxialSigma(z, IncidenceBeyond60(cosine)) * error;
      if (!(noisy > 0.0)) continue;
      const double depth = Quantised(noisy, model, config);
      if (depth < range.min || depth > range.max) continue;
      measured.at<float>(v, u) = static_cast<float>(depth);
    }
  }
  return measured;
}

cv::Mat ColorNoise(const Render& clean, const NoiseConfig& config, Rng* rng) {
  const double exposure = std::exp(rng->Gaussian(config.exposure_sigma));
  const double red = std::exp(rng->Gaussian(config.white_balance_sigma));
  const double blue = std::exp(rng->Gaussian(config.white_balance_sigma));
  const float gains[3] = {static_cast<float>(exposure * red), static_cast<float>(exposure),
                          static_cast<float>(exposure * blue)};
  const float sigma = static_cast<float>(config.color_sigma);
  FastGaussian gaussian(rng);
  cv::Mat noisy(clean.color.size(), CV_8UC3);
  for (int v = 0; v < noisy.rows; ++v) {
    const std::uint8_t* in = clean.color.ptr<std::uint8_t>(v);
    std::uint8_t* out = noisy.ptr<std::uint8_t>(v);
    for (int i = 0; i < 3 * noisy.cols; ++i) {
      const float value = gains[i % 3] * in[i] + sigma * gaussian.Next();
      out[i] = static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F) + 0.5F);
    }
  }
  return noisy;
}

}  // namespace secondlook::sim

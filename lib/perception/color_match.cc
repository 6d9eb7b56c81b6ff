#include "lib/perception/color_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace secondlook::perception {
namespace {

constexpr float kDark = 0.08F;  // below this, lightness is mostly noise
constexpr double kLightness = 0.30;
constexpr double kShare = 0.085;
constexpr double kMostExposure = 1.1;
constexpr double kMostShading = 0.8;
constexpr double kLeastContrast = 0.7;
constexpr double kMostContrast = 1.6;
constexpr double kMostBalance = 0.06;
constexpr double kLeastSaturation = 0.8;
constexpr double kMostSaturation = 1.4;
constexpr float kClipped = 0.98F;  // from here on, a value says only that it is at least so bright

/// Offset, slope along the normal (three) and contrast.
using Lighting = Eigen::Matrix<double, 5, 1>;

/// A colour as lightness and two shares of it. The shares of dark colours shrink towards grey.
struct Tone {
  double lightness;
  double red;
  double blue;
};

Tone SharesOf(const Eigen::Vector3f& rgb) {
  const Eigen::Vector3f v = rgb.cwiseMax(0.0F);
  const float sum = v.sum() + 3.0F * kDark;
  return {std::log(0.3F * v[0] + 0.59F * v[1] + 0.11F * v[2] + kDark), (v[0] + kDark) / sum,
          (v[2] + kDark) / sum};
}

/// Takes out of `difference` (measured less expected) what a clipped picture cannot say: of a value
/// at its limit only the lower bound is known. What is clipped in all three is white as it stands.
Eigen::Vector3d WithoutClipping(Eigen::Vector3d difference, const Eigen::Vector3f& measured) {
  const bool red = measured[0] >= kClipped;
  const bool green = measured[1] >= kClipped;
  const bool blue = measured[2] >= kClipped;
  if (red && green && blue) return difference;
  if (red || green || blue) difference[0] = std::max(0.0, difference[0]);
  const auto bound = [](double share, bool own, bool other) {
    if (own && other) return 0.0;
    if (own) return std::max(0.0, share);    // its true share is larger
    if (other) return std::min(0.0, share);  // its true share is smaller
    return share;
  };
  difference[1] = bound(difference[1], red, green || blue);
  difference[2] = bound(difference[2], blue, red || green);
  return difference;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double Expected(const ColorPair& pair, double lightness, const Lighting& light) {
  return light[0] + light[1] * pair.normal_C[0] + light[2] * pair.normal_C[1] +
         light[3] * pair.normal_C[2] + light[4] * lightness;
}

/// Measured lightness as a linear function of the normal and of the modelled one, by iteratively
/// reweighted least squares with a prior (no shading, contrast 1); bounded.
Lighting FitLighting(const std::vector<Tone>& measured, const std::vector<Tone>& modelled,
                     const std::vector<ColorPair>& pairs) {
  std::vector<double> difference;
  difference.reserve(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    difference.push_back(measured[i].lightness - modelled[i].lightness);
  }
  Lighting light;
  light << Median(difference), 0.0, 0.0, 0.0, 1.0;
  const double prior = 0.02 * static_cast<double>(pairs.size());
  for (int round = 0; round < 3; ++round) {
    // The triangle of the normal matrix, with the right side as a sixth column.
    std::array<double, 20> sums{};
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double e =
          (measured[i].lightness - Expected(pairs[i], modelled[i].lightness, light)) / kLightness;
      const double weight = 1.0 / ((1.0 + e * e) * (1.0 + e * e));
      const Eigen::Vector3f& n = pairs[i].normal_C;
      const std::array<double, 6> row{
          1.0, n[0], n[1], n[2], modelled[i].lightness, measured[i].lightness};
      std::size_t k = 0;
      for (std::size_t a = 0; a < 5; ++a) {
        for (std::size_t b = a; b < 6; ++b) sums[k++] += weight * row[a] * row[b];
      }
    }
    Eigen::Matrix<double, 5, 5> normal_matrix;
    Lighting right_side;
    std::size_t k = 0;
    for (int a = 0; a < 5; ++a) {
      for (int b = a; b < 5; ++b) normal_matrix(a, b) = normal_matrix(b, a) = sums[k++];
      right_side[a] = sums[k++];
    }
    Lighting trust;
    trust << 0.1, 1.0, 1.0, 1.0, 2.0;
    normal_matrix.diagonal() += trust * prior;
    right_side[4] += trust[4] * prior;
    light = normal_matrix.ldlt().solve(right_side);
  }
  const double shading = light.segment<3>(1).norm();
  if (shading > kMostShading) light.segment<3>(1) *= kMostShading / shading;
  light[4] = std::clamp(light[4], kLeastContrast, kMostContrast);
  // The offset that goes with the bounded rest, itself bounded where the surface faces the camera
  // and has the model's median lightness.
  std::vector<double> rest;
  std::vector<double> lightness;
  rest.reserve(pairs.size());
  lightness.reserve(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    rest.push_back(measured[i].lightness - Expected(pairs[i], modelled[i].lightness, light) +
                   light[0]);
    lightness.push_back(modelled[i].lightness);
  }
  const double shift = (light[4] - 1.0) * Median(lightness);
  light[0] = std::clamp(Median(rest), -kMostExposure - shift, kMostExposure - shift);
  return light;
}

/// By how much the camera strengthens colours: the slope of the measured shares over the modelled
/// ones about grey, by iteratively reweighted least squares with a prior of 1; bounded.
double FitSaturation(const std::vector<Tone>& measured, const std::vector<Tone>& modelled,
                     double red_offset, double blue_offset) {
  constexpr double kGrey = 1.0 / 3.0;
  constexpr double kPrior = 0.1;  // of the pairs, each as colourful as a shade of usual noise
  const double prior = kPrior * static_cast<double>(measured.size()) * kShare * kShare;
  double slope = 1.0;
  for (int round = 0; round < 3; ++round) {
    double up = prior;
    double down = prior;
    const auto add = [&](double share, double expected) {
      const double e = (share - slope * expected) / kShare;
      const double weight = 1.0 / ((1.0 + e * e) * (1.0 + e * e));
      up += weight * share * expected;
      down += weight * expected * expected;
    };
    for (std::size_t i = 0; i < measured.size(); ++i) {
      add(measured[i].red - red_offset - kGrey, modelled[i].red - kGrey);
      add(measured[i].blue - blue_offset - kGrey, modelled[i].blue - kGrey);
    }
    slope = std::clamp(up / down, kLeastSaturation, kMostSaturation);
  }
  return slope;
}

}  // namespace

Eigen::Vector3f MeanColor(const cv::Mat& color, int x, int y) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float count = 0.0F;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, color.rows - 1); ++v) {
    const auto* row = color.ptr<cv::Vec3b>(v);
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, color.cols - 1); ++u) {
      sum += Eigen::Vector3f(row[u][0], row[u][1], row[u][2]);
      count += 255.0F;
    }
  }
  return sum / count;
}

Eigen::Vector3d ToneOf(const Eigen::Vector3f& rgb) {
  const Tone tone = SharesOf(rgb);
  return {tone.lightness / kLightness, tone.red / kShare, tone.blue / kShare};
}

std::vector<Eigen::Vector3d> ToneDifferences(const std::vector<ColorPair>& pairs) {
  if (pairs.empty()) return {};
  std::vector<Tone> measured;
  std::vector<Tone> modelled;
  std::vector<double> red;
  std::vector<double> blue;
  measured.reserve(pairs.size());
  modelled.reserve(pairs.size());
  red.reserve(pairs.size());
  blue.reserve(pairs.size());
  for (const ColorPair& pair : pairs) {
    measured.push_back(SharesOf(pair.measured));
    modelled.push_back(SharesOf(pair.modelled));
    red.push_back(measured.back().red - modelled.back().red);
    blue.push_back(measured.back().blue - modelled.back().blue);
  }
  const Lighting light = FitLighting(measured, modelled, pairs);
  const auto balance = [](const std::vector<double>& off) {
    return std::clamp(Median(off), -kMostBalance, kMostBalance);
  };
  const double saturation = FitSaturation(measured, modelled, balance(red), balance(blue));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    red[i] -= (saturation - 1.0) * (modelled[i].red - 1.0 / 3.0);
    blue[i] -= (saturation - 1.0) * (modelled[i].blue - 1.0 / 3.0);
  }
  const double red_offset = balance(red);
  const double blue_offset = balance(blue);
  std::vector<Eigen::Vector3d> differences;
  differences.reserve(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d difference(
        (measured[i].lightness - Expected(pairs[i], modelled[i].lightness, light)) / kLightness,
        (red[i] - red_offset) / kShare, (blue[i] - blue_offset) / kShare);
    differences.push_back(WithoutClipping(difference, pairs[i].measured));
  }
  return differences;
}

double CompareColors(const std::vector<ColorPair>& pairs) {
  if (pairs.size() < 20) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (const Eigen::Vector3d& difference : ToneDifferences(pairs)) {
    sum += std::exp(-0.5 * difference.squaredNorm());
  }
  return sum / static_cast<double>(pairs.size());
}

}  // namespace secondlook::perception

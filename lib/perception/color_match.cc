#include "lib/perception/color_match.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace secondlook::perception {
namespace {

constexpr float kDark = 0.06F;  // below this, colour is mostly noise
constexpr double kLightness = 0.30;
constexpr double kChroma = 0.16;
constexpr double kMostExposure = 1.1;
constexpr double kMostShading = 0.8;
constexpr double kMostBalance = 0.30;

struct LogColor {
  double lightness;
  double red;   // log R/G
  double blue;  // log B/G
};

LogColor ToLog(const Eigen::Vector3f& rgb) {
  const Eigen::Vector3f v = rgb.cwiseMax(0.0F).array() + kDark;
  return {std::log(0.3F * v[0] + 0.59F * v[1] + 0.11F * v[2]), std::log(v[0] / v[1]),
          std::log(v[2] / v[1])};
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Lightness differences as offset + slope . normal, by iteratively reweighted least squares with a
/// prior that both are small; bounded.
Eigen::Vector4d FitLighting(const std::vector<double>& difference,
                            const std::vector<ColorPair>& pairs) {
  Eigen::Vector4d light(Median(difference), 0.0, 0.0, 0.0);
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix4d normal_matrix = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right_side = Eigen::Vector4d::Zero();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Eigen::Vector4d row(1.0, pairs[i].normal_C.x(), pairs[i].normal_C.y(),
                                pairs[i].normal_C.z());
      const double e = (difference[i] - row.dot(light)) / kLightness;
      const double weight = 1.0 / ((1.0 + e * e) * (1.0 + e * e));
      normal_matrix += weight * row * row.transpose();
      right_side += weight * difference[i] * row;
    }
    const double prior = 0.02 * static_cast<double>(pairs.size());
    normal_matrix.diagonal() += Eigen::Vector4d(0.1, 1.0, 1.0, 1.0) * prior;
    light = normal_matrix.ldlt().solve(right_side);
  }
  Eigen::Vector3d slope = light.tail<3>();
  if (slope.norm() > kMostShading) slope *= kMostShading / slope.norm();
  Eigen::Vector4d bounded;
  bounded << std::clamp(light[0], -kMostExposure - slope.norm(), kMostExposure + slope.norm()),
      slope;
  return bounded;
}

}  // namespace

double CompareColors(const std::vector<ColorPair>& pairs) {
  if (pairs.size() < 20) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> lightness;
  std::vector<double> red;
  std::vector<double> blue;
  for (const ColorPair& pair : pairs) {
    const LogColor measured = ToLog(pair.measured);
    const LogColor modelled = ToLog(pair.modelled);
    lightness.push_back(measured.lightness - modelled.lightness);
    red.push_back(measured.red - modelled.red);
    blue.push_back(measured.blue - modelled.blue);
  }
  const Eigen::Vector4d light = FitLighting(lightness, pairs);
  const double red_gain = std::clamp(Median(red), -kMostBalance, kMostBalance);
  const double blue_gain = std::clamp(Median(blue), -kMostBalance, kMostBalance);
  double sum = 0.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector4d row(1.0, pairs[i].normal_C.x(), pairs[i].normal_C.y(),
                              pairs[i].normal_C.z());
    const double l = (lightness[i] - row.dot(light)) / kLightness;
    const double r = (red[i] - red_gain) / kChroma;
    const double b = (blue[i] - blue_gain) / kChroma;
    sum += std::exp(-0.5 * (l * l + 0.5 * (r * r + b * b)));
  }
  return sum / static_cast<double>(pairs.size());
}

}  // namespace secondlook::perception

#include "lib/perception/depth_bias.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace secondlook::perception {
namespace {

// What is usual (standard deviations), as seen over 0.1 m of an object: 3 mm of offset, 3 mm of
// tilt, 4 mm of bending.
constexpr double kOffset = 0.003;  // [m]
constexpr double kTilt = 0.03;     // [m/m]
constexpr double kBend = 0.4;      // [m/m^2]
constexpr double kNoise = 0.003;   // of a difference [m]
/// So many pixels speak, however many there are: neighbours share their error.
constexpr double kIndependent = 60.0;
constexpr double kPixels = 1000.0;
constexpr int kRounds = 3;

}  // namespace

DepthBias::DepthBias(const std::vector<float>& difference, const std::vector<char>& inner,
                     const geometry::PixelRect& window, double metres_per_pixel, double gate)
    : scale_(metres_per_pixel) {
  const int step = std::max(1, static_cast<int>(std::sqrt(window.area() / kPixels)));
  std::vector<Eigen::Vector3d> samples;  // x and y [px], difference [m]
  for (int y = 0; y < window.height; y += step) {
    for (int x = 0; x < window.width; x += step) {
      const auto at = static_cast<std::size_t>(y * window.width + x);
      if (inner[at] == 0 || !(std::abs(difference[at]) < gate)) continue;
      samples.emplace_back(x, y, difference[at]);
    }
  }
  if (samples.size() < 20) return;
  for (const Eigen::Vector3d& sample : samples) center_ += sample.head<2>();
  center_ /= static_cast<double>(samples.size());

  Vector6 usual;
  usual << kOffset, kTilt, kTilt, kBend, kBend, kBend;
  const double share = std::min(1.0, kIndependent / static_cast<double>(samples.size()));
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 6, 6> normal_matrix = usual.cwiseAbs2().cwiseInverse().asDiagonal();
    Vector6 right_side = Vector6::Zero();
    for (const Eigen::Vector3d& sample : samples) {
      const Vector6 terms = Terms(static_cast<int>(sample.x()), static_cast<int>(sample.y()));
      const double e = (sample.z() - terms.dot(coefficients_)) / gate;
      const double weight = share / (kNoise * kNoise) / ((1.0 + 4.0 * e * e) * (1.0 + 4.0 * e * e));
      normal_matrix += weight * terms * terms.transpose();
      right_side += weight * sample.z() * terms;
    }
    coefficients_ = normal_matrix.ldlt().solve(right_side);
  }
  // Only the bending is forgiven: offset and tilt are errors of the pose.
  Vector6 mean = Vector6::Zero();
  for (const Eigen::Vector3d& sample : samples) {
    mean += Terms(static_cast<int>(sample.x()), static_cast<int>(sample.y()));
  }
  coefficients_.head<3>().setZero();
  coefficients_[0] = -coefficients_.dot(mean) / static_cast<double>(samples.size());
}

DepthBias::Vector6 DepthBias::Terms(int x, int y) const {
  const double u = scale_ * (x - center_.x());
  const double v = scale_ * (y - center_.y());
  Vector6 terms;
  terms << 1.0, u, v, u * u, u * v, v * v;
  return terms;
}

}  // namespace secondlook::perception

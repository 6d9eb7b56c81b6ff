#include "lib/geometry/normals.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "lib/geometry/point_image.h"

namespace secondlook::geometry {
namespace {

/// 1/z = c[0] + c[1] dx + c[2] dy around a pixel: a plane of space is linear in the image.
struct InversePlane {
  Eigen::Vector3d c{Eigen::Vector3d::Zero()};
  int count{};
  bool valid{};
};

struct Window {
  int left, right, top, bottom, x, y;
};

template <class Keep>
InversePlane Fit(const cv::Mat& depth, const Window& window, const Keep& keep) {
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  InversePlane plane;
  for (int y = window.top; y <= window.bottom; ++y) {
    const auto* row = depth.ptr<float>(y);
    for (int x = window.left; x <= window.right; ++x) {
      if (!keep(x, y, row[x])) continue;
      const double dx = x - window.x;
      const double dy = y - window.y;
      const double value = 1.0 / row[x];
      normal_matrix(0, 0) += 1.0;
      normal_matrix(0, 1) += dx;
      normal_matrix(0, 2) += dy;
      normal_matrix(1, 1) += dx * dx;
      normal_matrix(1, 2) += dx * dy;
      normal_matrix(2, 2) += dy * dy;
      right_side += value * Eigen::Vector3d(1.0, dx, dy);
      ++plane.count;
    }
  }
  if (plane.count < 3) return plane;
  normal_matrix(1, 0) = normal_matrix(0, 1);
  normal_matrix(2, 0) = normal_matrix(0, 2);
  normal_matrix(2, 1) = normal_matrix(1, 2);
  if (!(normal_matrix.determinant() > 1e-6)) return plane;
  plane.c = normal_matrix.ldlt().solve(right_side);
  plane.valid = plane.c.allFinite() && plane.c[0] > 0.0;
  return plane;
}

}  // namespace

std::optional<OrientedPoint> FitLocalPlane(const cv::Mat& depth, const cv::Mat& labels,
                                           const CameraModel& camera, int pixel,
                                           const NormalOptions& options) {
  const int x = pixel % depth.cols;
  const int y = pixel / depth.cols;
  const double z = depth.at<float>(y, x);
  if (!(z > 0.0)) return std::nullopt;
  const double sigma = DepthSigma(z);
  const double radius = options.radius + options.per_sigma * sigma;
  const double gate = radius + options.gate_sigma * sigma;
  const int reach = std::clamp(static_cast<int>(std::lround(radius * camera.fx / z)), 1, 24);
  const Window window{std::max(x - reach, 0),
                      std::min(x + reach, depth.cols - 1),
                      std::max(y - reach, 0),
                      std::min(y + reach, depth.rows - 1),
                      x,
                      y};
  const int label = labels.empty() ? 0 : labels.at<int>(y, x);
  const auto near = [&](int column, int row, double value) {
    return std::abs(value - z) < gate && (labels.empty() || labels.at<int>(row, column) == label);
  };
  InversePlane plane = Fit(depth, window, near);
  if (!plane.valid || plane.count < options.min_points) return std::nullopt;
  const InversePlane first = plane;
  plane = Fit(depth, window, [&](int column, int row, double value) {
    if (!near(column, row, value)) return false;
    const double expected = first.c[0] + first.c[1] * (column - x) + first.c[2] * (row - y);
    return std::abs(value * expected - 1.0) * value < 3.0 * sigma;
  });
  if (!plane.valid || plane.count < options.min_points) return std::nullopt;

  // 1/z = n . ray / d, so n is proportional to the coefficients seen as a function of the ray.
  const double nx = plane.c[1] * camera.fx;
  const double ny = plane.c[2] * camera.fy;
  const Eigen::Vector3d ray = camera.Ray(x, y);
  const Eigen::Vector3d normal(nx, ny, plane.c[0] - nx * ray.x() - ny * ray.y());
  OrientedPoint point;
  point.point = (ray / plane.c[0]).cast<float>();
  point.normal = -normal.normalized().cast<float>();
  return point;
}

}  // namespace secondlook::geometry

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
  // The moments of the kept pixels; locals, as these loops are much of the time of a frame.
  int n = 0;
  int sum_x = 0;
  int sum_y = 0;
  int sum_xx = 0;
  int sum_xy = 0;
  int sum_yy = 0;
  double sum_v = 0.0;
  double sum_xv = 0.0;
  double sum_yv = 0.0;
  for (int y = window.top; y <= window.bottom; ++y) {
    const auto* row = depth.ptr<float>(y);
    for (int x = window.left; x <= window.right; ++x) {
      if (!keep(x, y, row[x])) continue;
      const int dx = x - window.x;
      const int dy = y - window.y;
      const double value = 1.0 / row[x];
      ++n;
      sum_x += dx;
      sum_y += dy;
      sum_xx += dx * dx;
      sum_xy += dx * dy;
      sum_yy += dy * dy;
      sum_v += value;
      sum_xv += value * dx;
      sum_yv += value * dy;
    }
  }
  InversePlane plane;
  plane.count = n;
  if (n < 3) return plane;
  Eigen::Matrix3d normal_matrix;
  normal_matrix << n, sum_x, sum_y,  //
      sum_x, sum_xx, sum_xy,         //
      sum_y, sum_xy, sum_yy;
  if (!(normal_matrix.determinant() > 1e-6)) return plane;
  plane.c = normal_matrix.ldlt().solve(Eigen::Vector3d(sum_v, sum_xv, sum_yv));
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

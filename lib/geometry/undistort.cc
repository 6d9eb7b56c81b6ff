#include "lib/geometry/undistort.h"

#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"

namespace secondlook::geometry {

Eigen::Vector2d LensDistortion::Distort(const Eigen::Vector2d& xy) const {
  const double x = xy.x();
  const double y = xy.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

cv::Mat Undistort(const cv::Mat& image, const CameraModel& camera, const LensDistortion& lens) {
  const bool depth = image.type() == CV_32FC1;
  if ((!depth && image.type() != CV_8UC3) || image.cols != camera.width ||
      image.rows != camera.height) {
    Throw<InvalidArgument>("cannot undistort a {} x {} image of type {} with a camera of {} x {}",
                           image.cols, image.rows, image.type(), camera.width, camera.height);
  }
  if (lens.none()) return image;
  cv::Mat map(image.size(), CV_32FC2);
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      const Eigen::Vector2d at = lens.Distort(camera.Ray(u, v).head<2>());
      map.at<cv::Vec2f>(v, u) = {static_cast<float>(at.x() * camera.fx + camera.cx),
                                 static_cast<float>(at.y() * camera.fy + camera.cy)};
    }
  }
  cv::Mat result;
  if (depth) {
    cv::remap(image, result, map, cv::Mat(), cv::INTER_NEAREST, cv::BORDER_CONSTANT,
              cv::Scalar::all(std::numeric_limits<double>::quiet_NaN()));
  } else {
    cv::remap(image, result, map, cv::Mat(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  }
  return result;
}

}  // namespace secondlook::geometry

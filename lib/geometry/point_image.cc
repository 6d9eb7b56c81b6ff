#include "lib/geometry/point_image.h"

#include "lib/common/error.h"

namespace secondlook::geometry {

PointImage Deproject(const cv::Mat& depth, const CameraModel& camera) {
  if (depth.type() != CV_32FC1 || depth.cols != camera.width || depth.rows != camera.height) {
    Throw<InvalidArgument>(
        "a depth image of {} x {} px, type {}; the camera needs {} x {} px of 32-bit floats",
        depth.cols, depth.rows, depth.type(), camera.width, camera.height);
  }
  PointImage image{depth.cols, depth.rows, {}};
  image.points_C.reserve(static_cast<std::size_t>(depth.cols) * depth.rows);
  for (int v = 0; v < depth.rows; ++v) {
    const float* row = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) {
      // NaN times anything is NaN; a depth of 0 or less is no measurement either.
      const float z = row[u] > 0.0F ? row[u] : std::numeric_limits<float>::quiet_NaN();
      image.points_C.push_back(camera.Ray(u, v).cast<float>() * z);
    }
  }
  return image;
}

}  // namespace secondlook::geometry

#include "lib/perception/view.h"

#include <limits>

#include "lib/common/error.h"

namespace secondlook::perception {
namespace {

void CheckImage(const cv::Mat& image, int type, const char* name, const char* type_name,
                const geometry::CameraModel& camera) {
  if (image.cols != camera.width || image.rows != camera.height || image.type() != type) {
    Throw<InvalidArgument>("the {} image is {} x {} of type {}; the camera needs {} x {} of {}",
                           name, image.cols, image.rows, image.type(), camera.width, camera.height,
                           type_name);
  }
}

}  // namespace

const world::SupportPlane& View::PlaneUnder(const Eigen::Vector3d& p_CQ) const {
  const world::SupportPlane* highest = nullptr;
  double least_height = std::numeric_limits<double>::infinity();
  const auto consider = [&](const world::SupportPlane& plane) {
    const double height = plane.HeightOf(p_CQ);
    if (height < 0.0 || height >= least_height || !plane.Covers(p_CQ, 0.0)) return;
    least_height = height;
    highest = &plane;
  };
  for (const world::SupportPlane& plane : further_C) consider(plane);
  consider(plane_C);
  return highest == nullptr ? plane_C : *highest;
}

View MakeView(const cv::Mat& color, const cv::Mat& depth, const geometry::CameraModel& camera,
              const world::SupportPlane& plane_C, const std::vector<world::Cluster>& clusters,
              const std::vector<world::SupportPlane>& further_C) {
  if (!color.empty()) CheckImage(color, CV_8UC3, "colour", "CV_8UC3", camera);
  CheckImage(depth, CV_32FC1, "depth", "CV_32FC1", camera);
  View view{color,  depth,   cv::Mat(depth.size(), CV_32SC1, cv::Scalar(-1)),
            camera, plane_C, further_C};
  const int pixels = camera.width * camera.height;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    for (const int pixel : clusters[i].pixels) {
      if (pixel < 0 || pixel >= pixels) {
        Throw<InvalidArgument>("cluster {} has pixel {}; the image has {}", i, pixel, pixels);
      }
      view.labels.at<int>(pixel / camera.width, pixel % camera.width) = static_cast<int>(i);
    }
  }
  return view;
}

}  // namespace secondlook::perception

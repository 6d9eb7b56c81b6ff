#include "apps/model_picture.h"

#include <cmath>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/files.h"
#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/geometry/depth_rasteriser.h"

namespace secondlook::apps {
namespace {

constexpr int kSize = 480;         ///< Of a picture that is saved [px].
constexpr double kFar = 3.0;       ///< From the camera to the model's middle, in diameters.
constexpr float kAmbient = 0.35F;  ///< Of the light.

}  // namespace

cv::Mat DrawModel(const geometry::Mesh& mesh, int size) {
  const Eigen::Vector3d middle_M = geometry::Bounds(mesh).center();
  const double diameter = geometry::Diameter(mesh);
  const Eigen::Vector3d towards = Eigen::Vector3d(-0.8, -0.5, 0.55).normalized();
  const Pose X_MC = LookAt(middle_M + kFar * diameter * towards, middle_M);
  geometry::CameraModel camera;
  camera.width = camera.height = size;
  camera.fx = camera.fy = 0.95 * kFar * size;
  camera.cx = camera.cy = 0.5 * (size - 1);
  geometry::DepthRasteriser rasteriser;
  rasteriser.Render(mesh, X_MC.inverse(), camera, {0, 0, size, size});
  cv::Mat picture(size, size, CV_8UC3, cv::Scalar::all(255));
  for (int i = 0; i < size * size; ++i) {
    const int triangle = rasteriser.triangle()[i];
    if (triangle < 0) continue;
    const Eigen::Vector3f color = geometry::ColorAt(mesh, triangle, rasteriser.Weights(mesh, i));
    const float facing = std::abs(rasteriser.Normal(mesh, i).z());
    const Eigen::Vector3f lit =
        255.0F * (kAmbient + (1.0F - kAmbient) * facing) * color.cwiseMin(1.0F).cwiseMax(0.0F);
    for (int k = 0; k < 3; ++k) {
      picture.at<cv::Vec3b>(i / size, i % size)[k] = static_cast<unsigned char>(lit[k]);
    }
  }
  return picture;
}

void SaveModelPicture(const geometry::Mesh& mesh, const std::filesystem::path& file) {
  cv::Mat bgr;
  cv::cvtColor(DrawModel(mesh, kSize), bgr, cv::COLOR_RGB2BGR);
  std::vector<unsigned char> png;
  cv::imencode(".png", bgr, png);
  WriteFile(file, {reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace secondlook::apps

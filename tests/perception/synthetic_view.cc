#include "tests/perception/synthetic_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/geometry/depth_rasteriser.h"

namespace secondlook::perception {
namespace {

/// Appends `part`, moved by `offset`, with a material of `color`.
void Append(const geometry::Mesh& part, const Eigen::Vector3f& offset, geometry::Mesh* mesh) {
  const auto first = static_cast<int>(mesh->vertices.size());
  const auto material = static_cast<std::uint16_t>(mesh->materials.size());
  for (const Eigen::Vector3f& v : part.vertices) mesh->vertices.push_back(v + offset);
  for (const Eigen::Vector3i& t : part.triangles) {
    mesh->triangles.emplace_back(t.array() + first);
    mesh->triangle_material.push_back(material);
  }
  mesh->materials.push_back(part.materials.front());
}

Eigen::Vector3f ShadedColor(const geometry::Mesh& mesh, const geometry::DepthRasteriser& drawn,
                            int at) {
  const Eigen::Vector3f color = geometry::ColorAt(
      mesh, drawn.triangle()[static_cast<std::size_t>(at)], drawn.Weights(mesh, at));
  const float light = 0.6F + 0.4F * std::max(0.0F, -drawn.Normal(mesh, at).z());
  return light * color;
}

}  // namespace

world::ObjectModel MakeEll(const std::string& name, const Eigen::Vector3f& upright,
                           const Eigen::Vector3f& foot) {
  world::ObjectModel object;
  object.name = name;
  Append(geometry::MakeBox({0.05, 0.06, 0.18}, upright), {0.0F, 0.0F, 0.09F}, &object.mesh);
  Append(geometry::MakeBox({0.08, 0.06, 0.05}, foot), {0.065F, 0.0F, 0.025F}, &object.mesh);
  return object;
}

world::ObjectModel MakeBoxModel(const std::string& name, const Eigen::Vector3d& size,
                                const Eigen::Vector3f& sides, const Eigen::Vector3f& front) {
  world::ObjectModel object;
  object.name = name;
  const auto up = static_cast<float>(0.5 * size.z());
  Append(geometry::MakeBox(size, sides), {0.0F, 0.0F, up}, &object.mesh);
  // A label: a plate that covers the middle of the front side (-y).
  Append(geometry::MakeBox({0.7 * size.x(), 0.001, 0.7 * size.z()}, front),
         {0.0F, static_cast<float>(-0.5 * size.y()), up}, &object.mesh);
  return object;
}

Pose Upright(double x, double y, double yaw) {
  Pose X_WM = Pose::Identity();
  X_WM.linear() = RotationFromRollPitchYaw(0.0, 0.0, yaw);
  X_WM.translation() << x, y, 0.0;
  return X_WM;
}

SyntheticView DrawView(const std::vector<Placed>& things, double azimuth, bool noise, Rng* rng) {
  const geometry::CameraModel camera{640, 480, 577.0, 577.0, 319.5, 239.5};
  constexpr double kElevation = 0.7;
  SyntheticView result;
  const Eigen::Vector3d eye(std::cos(kElevation) * std::cos(azimuth),
                            std::cos(kElevation) * std::sin(azimuth), std::sin(kElevation));
  const Eigen::Vector3d forward = (Eigen::Vector3d(0, 0, 0.06) - eye).normalized();
  result.X_WC.linear().col(0) = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  result.X_WC.linear().col(1) = forward.cross(result.X_WC.linear().col(0));
  result.X_WC.linear().col(2) = forward;
  result.X_WC.translation() = eye;
  result.X_WC.makeAffine();

  const world::SupportPlane plane_W;
  const world::SupportPlane plane_C = Transform(result.X_WC.inverse(), plane_W);
  cv::Mat depth(camera.height, camera.width, CV_32FC1);
  cv::Mat color(camera.height, camera.width, CV_8UC3, cv::Scalar(160, 120, 80));
  cv::Mat owner(camera.height, camera.width, CV_32SC1, cv::Scalar(-1));
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double z = plane_C.offset / plane_C.normal_A.dot(camera.Ray(x, y));
      depth.at<float>(y, x) = static_cast<float>(z > 0 ? z : NAN);
    }
  }
  geometry::DepthRasteriser rasteriser;
  for (std::size_t i = 0; i < things.size(); ++i) {
    const geometry::Mesh& mesh = things[i].model->mesh;
    rasteriser.Render(mesh, result.X_WC.inverse() * things[i].X_WM, camera,
                      {0, 0, camera.width, camera.height});
    for (int at = 0; at < camera.width * camera.height; ++at) {
      const float z = rasteriser.depth()[static_cast<std::size_t>(at)];
      float& nearest = depth.at<float>(at / camera.width, at % camera.width);
      if (!(z < nearest)) continue;
      nearest = z;
      owner.at<int>(at / camera.width, at % camera.width) = static_cast<int>(i);
      const Eigen::Vector3f rgb = 255.0F * ShadedColor(mesh, rasteriser, at);
      color.at<cv::Vec3b>(at / camera.width, at % camera.width) = {
          cv::saturate_cast<uchar>(rgb[0]), cv::saturate_cast<uchar>(rgb[1]),
          cv::saturate_cast<uchar>(rgb[2])};
    }
  }
  for (int at = 0; noise && at < camera.width * camera.height; ++at) {
    float& z = depth.at<float>(at / camera.width, at % camera.width);
    z += static_cast<float>(rng->Gaussian(geometry::DepthSigma(z)));
    auto& rgb = color.at<cv::Vec3b>(at / camera.width, at % camera.width);
    for (int k = 0; k < 3; ++k) rgb[k] = cv::saturate_cast<uchar>(rgb[k] + rng->Gaussian(4.0));
  }
  for (std::size_t i = 0; i < things.size(); ++i) {
    world::Cluster cluster;
    for (int at = 0; at < camera.width * camera.height; ++at) {
      const int x = at % camera.width;
      const int y = at / camera.width;
      if (owner.at<int>(y, x) != static_cast<int>(i)) continue;
      const Eigen::Vector3d p_C = camera.Ray(x, y) * depth.at<float>(y, x);
      if (plane_C.HeightOf(p_C) < 0.01) continue;
      cluster.pixels.push_back(at);
      cluster.points_C.push_back(p_C);
      cluster.center_C += p_C;
    }
    if (cluster.pixels.empty()) continue;
    cluster.center_C /= static_cast<double>(cluster.pixels.size());
    result.clusters.push_back(std::move(cluster));
  }
  result.view = MakeView(color, depth, camera, plane_C, result.clusters);
  return result;
}

}  // namespace secondlook::perception

#include "lib/geometry/depth_rasteriser.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace secondlook::geometry {
namespace {

constexpr float kNear = 0.01F;  // [m]

}  // namespace

PixelRect Clip(const PixelRect& rect, int image_width, int image_height) {
  const int left = std::max(rect.x, 0);
  const int top = std::max(rect.y, 0);
  const int right = std::min(rect.x + rect.width, image_width);
  const int bottom = std::min(rect.y + rect.height, image_height);
  return {left, top, std::max(right - left, 0), std::max(bottom - top, 0)};
}

PixelRect ImageBounds(const Mesh& mesh, const Pose& X_CM, const CameraModel& camera, int margin) {
  const Eigen::AlignedBox3d box = Bounds(mesh);
  double left = 1e9;
  double top = 1e9;
  double right = -1e9;
  double bottom = -1e9;
  int in_front = 0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d p_C = X_CM * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    if (!(p_C.z() > kNear)) continue;
    ++in_front;
    const double u = camera.fx * p_C.x() / p_C.z() + camera.cx;
    const double v = camera.fy * p_C.y() / p_C.z() + camera.cy;
    left = std::min(left, u);
    right = std::max(right, u);
    top = std::min(top, v);
    bottom = std::max(bottom, v);
  }
  if (in_front == 0) return {};
  if (in_front < 8) return {0, 0, camera.width, camera.height};
  const auto whole = [](double value) {
    return static_cast<int>(std::clamp(std::floor(value), -1e6, 1e6));
  };
  const PixelRect rect{whole(left) - margin, whole(top) - margin,
                       whole(right) - whole(left) + 2 + 2 * margin,
                       whole(bottom) - whole(top) + 2 + 2 * margin};
  return Clip(rect, camera.width, camera.height);
}

void DepthRasteriser::Render(const Mesh& mesh, const Pose& X_CM, const CameraModel& camera,
                             const PixelRect& window) {
  window_ = window;
  camera_ = camera;
  const auto area = static_cast<std::size_t>(window.area());
  inverse_z_.assign(area, 0.0F);
  triangle_.assign(area, -1);
  depth_.resize(area);
  const Eigen::Matrix3f R_CM = X_CM.linear().cast<float>();
  const Eigen::Vector3f p_CM = X_CM.translation().cast<float>();
  points_C_.resize(mesh.vertices.size());
  screen_.resize(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    points_C_[i].noalias() = R_CM * mesh.vertices[i] + p_CM;
    screen_[i] = Project(points_C_[i]);
  }
  if (area == 0) return;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    const Eigen::Vector3f& a = points_C_[t[0]];
    const Eigen::Vector3f& b = points_C_[t[1]];
    const Eigen::Vector3f& c = points_C_[t[2]];
    const bool clipped = !(a.z() >= kNear && b.z() >= kNear && c.z() >= kNear);
    if (clipped) {
      DrawClipped(a, b, c, static_cast<int>(i));
    } else {
      DrawTriangle(screen_[t[0]], screen_[t[1]], screen_[t[2]], static_cast<int>(i));
    }
  }
  for (std::size_t i = 0; i < area; ++i) {
    depth_[i] = triangle_[i] < 0 ? std::numeric_limits<float>::quiet_NaN() : 1.0F / inverse_z_[i];
  }
}

DepthRasteriser::ScreenVertex DepthRasteriser::Project(const Eigen::Vector3f& p_C) const {
  const float inverse_z = 1.0F / p_C.z();
  return {static_cast<float>(camera_.fx) * p_C.x() * inverse_z +
              static_cast<float>(camera_.cx - window_.x),
          static_cast<float>(camera_.fy) * p_C.y() * inverse_z +
              static_cast<float>(camera_.cy - window_.y),
          inverse_z};
}

void DepthRasteriser::DrawTriangle(const ScreenVertex& a, const ScreenVertex& b,
                                   const ScreenVertex& c, int index) {
  // Pixels whose centre lies inside; a centre exactly on an edge belongs to both sides, as a hole
  // in a surface is worse than a pixel drawn twice.
  const float low_x = std::min({a.x, b.x, c.x});
  const float high_x = std::max({a.x, b.x, c.x});
  const float low_y = std::min({a.y, b.y, c.y});
  const float high_y = std::max({a.y, b.y, c.y});
  if (!(high_x >= 0.0F && high_y >= 0.0F)) return;
  if (!(low_x <= static_cast<float>(window_.width) && low_y <= static_cast<float>(window_.height)))
    return;
  const int first_x = std::max(0, static_cast<int>(std::ceil(low_x)));
  const int first_y = std::max(0, static_cast<int>(std::ceil(low_y)));
  const int last_x = static_cast<int>(std::min(static_cast<float>(window_.width - 1), high_x));
  const int last_y = static_cast<int>(std::min(static_cast<float>(window_.height - 1), high_y));
  if (first_x > last_x || first_y > last_y) return;

  const float abx = b.x - a.x;
  const float aby = b.y - a.y;
  const float acx = c.x - a.x;
  const float acy = c.y - a.y;
  const float area = abx * acy - aby * acx;
  if (std::abs(area) < 1e-9F) return;
  const float scale = 1.0F / area;
  // Weights of b and c, and 1/z, are linear in the image.
  const float wb_dx = acy * scale;
  const float wb_dy = -acx * scale;
  const float wc_dx = -aby * scale;
  const float wc_dy = abx * scale;
  const float zb = b.inverse_z - a.inverse_z;
  const float zc = c.inverse_z - a.inverse_z;
  constexpr float kEdge = -1e-5F;
  for (int y = first_y; y <= last_y; ++y) {
    const float dy = static_cast<float>(y) - a.y;
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(window_.width);
    for (int x = first_x; x <= last_x; ++x) {
      const float dx = static_cast<float>(x) - a.x;
      const float wb = wb_dx * dx + wb_dy * dy;
      const float wc = wc_dx * dx + wc_dy * dy;
      if (wb < kEdge || wc < kEdge || wb + wc > 1.0F - kEdge) continue;
      const float inverse_z = a.inverse_z + wb * zb + wc * zc;
      const std::size_t pixel = row + static_cast<std::size_t>(x);
      if (inverse_z > inverse_z_[pixel]) {
        inverse_z_[pixel] = inverse_z;
        triangle_[pixel] = index;
      }
    }
  }
}

void DepthRasteriser::DrawClipped(const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                  const Eigen::Vector3f& c, int index) {
  // Sutherland and Hodgman against z = kNear: 0, 3 or 4 corners remain.
  const std::array<Eigen::Vector3f, 3> corners{a, b, c};
  std::array<ScreenVertex, 4> kept;
  std::size_t count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3f& from = corners[i];
    const Eigen::Vector3f& to = corners[(i + 1) % 3];
    const bool from_in = from.z() >= kNear;
    if (from_in) kept[count++] = Project(from);
    if (from_in != (to.z() >= kNear)) {
      const float s = (kNear - from.z()) / (to.z() - from.z());
      Eigen::Vector3f cut = from + s * (to - from);
      cut.z() = kNear;
      kept[count++] = Project(cut);
    }
  }
  if (count >= 3) DrawTriangle(kept[0], kept[1], kept[2], index);
  if (count == 4) DrawTriangle(kept[0], kept[2], kept[3], index);
}

Eigen::Vector3f DepthRasteriser::Weights(const Mesh& mesh, int index) const {
  const auto pixel = static_cast<std::size_t>(index);
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(triangle_[pixel])];
  const Eigen::Vector3f& a = points_C_[t[0]];
  const Eigen::Vector3f ab = points_C_[t[1]] - a;
  const Eigen::Vector3f ac = points_C_[t[2]] - a;
  const Eigen::Vector3f ray =
      camera_.Ray(window_.x + index % window_.width, window_.y + index / window_.width)
          .cast<float>();
  const Eigen::Vector3f aq = depth_[pixel] * ray - a;
  const Eigen::Vector3f normal = ab.cross(ac);
  const float square = normal.squaredNorm();
  if (!(square > 0.0F)) return {1.0F, 0.0F, 0.0F};
  const float wb = std::clamp(aq.cross(ac).dot(normal) / square, 0.0F, 1.0F);
  const float wc = std::clamp(ab.cross(aq).dot(normal) / square, 0.0F, 1.0F - wb);
  return {1.0F - wb - wc, wb, wc};
}

Eigen::Vector3f DepthRasteriser::Normal(const Mesh& mesh, int index) const {
  const Eigen::Vector3i& t =
      mesh.triangles[static_cast<std::size_t>(triangle_[static_cast<std::size_t>(index)])];
  const Eigen::Vector3f& a = points_C_[t[0]];
  const Eigen::Vector3f normal = (points_C_[t[1]] - a).cross(points_C_[t[2]] - a).normalized();
  return normal.dot(a) > 0.0F ? Eigen::Vector3f(-normal) : normal;
}

}  // namespace secondlook::geometry

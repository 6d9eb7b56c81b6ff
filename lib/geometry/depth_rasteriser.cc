#include "lib/geometry/depth_rasteriser.h"

#include <algorithm>
#include <array>
#include <bit>
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
  R_CM_ = X_CM.linear().cast<float>();
  p_CM_ = X_CM.translation().cast<float>();
  const auto area = static_cast<std::size_t>(window.area());
  nearest_.assign(area, 0);
  triangle_.resize(area);
  depth_.resize(area);
  if (area == 0) return;
  if (PlaceVertices(mesh)) {
    DrawMesh(mesh);
  } else {
    DrawClipped(mesh);
  }
  for (std::size_t i = 0; i < area; ++i) {
    const bool none = nearest_[i] == 0;
    const auto inverse_z = std::bit_cast<float>(static_cast<std::uint32_t>(nearest_[i] >> 32U));
    triangle_[i] = none ? -1 : static_cast<int>(nearest_[i] & 0xffffffffU);
    depth_[i] = none ? std::numeric_limits<float>::quiet_NaN() : 1.0F / inverse_z;
  }
}

DepthRasteriser::ScreenVertex DepthRasteriser::Project(const Eigen::Vector3f& p_C) const {
  const float inverse_z = 1.0F / p_C.z();
  const float x = static_cast<float>(camera_.fx) * p_C.x() * inverse_z +
                  static_cast<float>(camera_.cx - window_.x + 1);
  const float y = static_cast<float>(camera_.fy) * p_C.y() * inverse_z +
                  static_cast<float>(camera_.cy - window_.y + 1);
  // A NaN falls to the left of the window, or above it.
  const auto cell = [](float value, int last) {
    return value > 0.0F ? static_cast<std::uint32_t>(std::min(value, static_cast<float>(last)))
                        : 0U;
  };
  return {x, y, inverse_z, cell(x, window_.width) << 16U | cell(y, window_.height)};
}

/// Fills screen_; false when a vertex is too near or not finite.
bool DepthRasteriser::PlaceVertices(const Mesh& mesh) {
  const auto count = static_cast<Eigen::Index>(mesh.vertices.size());
  const Eigen::Map<const Eigen::Array3Xf> p_M(mesh.vertices.data()->data(), 3, count);
  const Eigen::ArrayXf x = p_M.row(0);
  const Eigen::ArrayXf y = p_M.row(1);
  const Eigen::ArrayXf z = p_M.row(2);
  const auto along = [&](int axis) {
    return R_CM_(axis, 0) * x + R_CM_(axis, 1) * y + R_CM_(axis, 2) * z + p_CM_[axis];
  };
  screen_.inverse_z = along(2);
  if (!(screen_.inverse_z >= kNear).all()) return false;
  screen_.inverse_z = screen_.inverse_z.inverse();
  screen_.x = static_cast<float>(camera_.fx) * along(0) * screen_.inverse_z +
              static_cast<float>(camera_.cx - window_.x + 1);
  screen_.y = static_cast<float>(camera_.fy) * along(1) * screen_.inverse_z +
              static_cast<float>(camera_.cy - window_.y + 1);
  const auto column = screen_.x.max(0.0F).min(static_cast<float>(window_.width));
  const auto row = screen_.y.max(0.0F).min(static_cast<float>(window_.height));
  screen_.cell = column.cast<int>().shiftLeft<16>() + row.cast<int>();
  return true;
}

/// Draws a mesh all of which is in front of the camera.
void DepthRasteriser::DrawMesh(const Mesh& mesh) {
  // Most triangles of a fine mesh lie between the pixel centres of two columns or of two rows. They
  // are sorted out first, without a branch that could not be foretold.
  crossing_.resize(mesh.triangles.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    const int a = screen_.cell[t[0]];
    const int differ = (a ^ screen_.cell[t[1]]) | (a ^ screen_.cell[t[2]]);
    crossing_[count] = static_cast<int>(i);
    count += static_cast<std::size_t>((differ & 0xffff) != 0) &
             static_cast<std::size_t>(differ > 0xffff);
  }
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(crossing_[k])];
    DrawTriangle(screen_[t[0]], screen_[t[1]], screen_[t[2]], crossing_[k]);
  }
}

/// Draws what lies in front of the camera (Sutherland and Hodgman against z = kNear).
void DepthRasteriser::DrawClipped(const Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    std::array<ScreenVertex, 4> kept;
    std::size_t count = 0;  // 0, 3 or 4 corners remain
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3f from = ToCamera(mesh.vertices[t[k]]);
      const Eigen::Vector3f to = ToCamera(mesh.vertices[t[(k + 1) % 3]]);
      const bool from_in = from.z() >= kNear;
      if (from_in) kept[count++] = Project(from);
      if (from_in != (to.z() >= kNear)) {
        const float s = (kNear - from.z()) / (to.z() - from.z());
        Eigen::Vector3f cut = from + s * (to - from);
        cut.z() = kNear;
        kept[count++] = Project(cut);
      }
    }
    if (count >= 3) DrawTriangle(kept[0], kept[1], kept[2], static_cast<int>(i));
    if (count == 4) DrawTriangle(kept[0], kept[2], kept[3], static_cast<int>(i));
  }
}

void DepthRasteriser::DrawTriangle(const ScreenVertex& a, const ScreenVertex& b,
                                   const ScreenVertex& c, int index) {
  const auto [left, right] = std::minmax({a.cell >> 16U, b.cell >> 16U, c.cell >> 16U});
  const auto [top, bottom] = std::minmax({a.cell & 0xffffU, b.cell & 0xffffU, c.cell & 0xffffU});
  const float abx = b.x - a.x;
  const float aby = b.y - a.y;
  const float acx = c.x - a.x;
  const float acy = c.y - a.y;
  const float area = abx * acy - aby * acx;
  if (!(std::abs(area) >= 1e-9F)) return;
  // The weights of b and c, and 1/z, are linear in the image.
  const float scale = 1.0F / area;
  const float zb = b.inverse_z - a.inverse_z;
  const float zc = c.inverse_z - a.inverse_z;
  constexpr float kEdge = -1e-5F;
  for (std::uint32_t row = top; row < bottom; ++row) {
    const float dy = static_cast<float>(row + 1) - a.y;
    std::uint64_t* nearest = &nearest_[std::size_t{row} * static_cast<std::size_t>(window_.width)];
    for (std::uint32_t column = left; column < right; ++column) {
      const float dx = static_cast<float>(column + 1) - a.x;
      const float wb = (acy * dx - acx * dy) * scale;
      const float wc = (abx * dy - aby * dx) * scale;
      // A centre exactly on an edge belongs to both sides, as a hole in a surface is worse than a
      // pixel drawn twice.
      const float least = std::min(std::min(wb, wc), 1.0F - wb - wc);
      const std::uint64_t inside = -static_cast<std::uint64_t>(least >= kEdge);  // all ones, or 0
      const float inverse_z = a.inverse_z + wb * zb + wc * zc;
      const std::uint64_t key = std::uint64_t{std::bit_cast<std::uint32_t>(inverse_z)} << 32U |
                                static_cast<std::uint32_t>(index);
      nearest[column] = std::max(nearest[column], key & inside);
    }
  }
}

Eigen::Vector3f DepthRasteriser::Weights(const Mesh& mesh, int index) const {
  const auto pixel = static_cast<std::size_t>(index);
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(triangle_[pixel])];
  const Eigen::Vector3f a = ToCamera(mesh.vertices[t[0]]);
  const Eigen::Vector3f ab = ToCamera(mesh.vertices[t[1]]) - a;
  const Eigen::Vector3f ac = ToCamera(mesh.vertices[t[2]]) - a;
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
  const Eigen::Vector3f a = ToCamera(mesh.vertices[t[0]]);
  const Eigen::Vector3f ab = ToCamera(mesh.vertices[t[1]]) - a;
  const Eigen::Vector3f ac = ToCamera(mesh.vertices[t[2]]) - a;
  const Eigen::Vector3f normal = ab.cross(ac).normalized();
  return normal.dot(a) > 0.0F ? Eigen::Vector3f(-normal) : normal;
}

}  // namespace secondlook::geometry

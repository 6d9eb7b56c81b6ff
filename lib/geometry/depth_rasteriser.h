#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/geometry/mesh.h"

namespace secondlook::geometry {

/// A rectangle of whole pixels: columns [x, x + width), rows [y, y + height).
struct PixelRect {
  int x{};
  int y{};
  int width{};
  int height{};

  bool empty() const { return width <= 0 || height <= 0; }
  int area() const { return empty() ? 0 : width * height; }
};

/// The part of `rect` inside an image of the given size.
PixelRect Clip(const PixelRect& rect, int image_width, int image_height);

/// The pixels of `camera`'s image that the box around `mesh` at X_CM can cover, grown by `margin`
/// [px] and clipped to the image. Empty when it lies behind the camera or beside the image; the
/// whole image when the box reaches behind the camera.
PixelRect ImageBounds(const Mesh& mesh, const Pose& X_CM, const CameraModel& camera, int margin);

/// A z-buffer for one mesh at a time, restricted to a rectangle of the image. Triangles count from
/// both sides, so the mesh need not be closed; what lies nearer than 1 cm is clipped away. A pixel
/// shows what the ray through its centre meets; a vertex that is no number hides its triangles.
/// Buffers are kept between calls: hold one for each thread. The result depends on the arguments
/// alone.
class DepthRasteriser {
 public:
  /// Draws `mesh` at X_CM as `camera` sees it into `window`, which need not lie in the image.
  /// An empty window gives empty buffers. @pre it has at most 32767 columns and rows.
  void Render(const Mesh& mesh, const Pose& X_CM, const CameraModel& camera,
              const PixelRect& window);

  /// The window of the last Render().
  const PixelRect& window() const { return window_; }

  /// z_C [m] by pixel of the window, row-major; NaN where there is no surface.
  const std::vector<float>& depth() const { return depth_; }

  /// The index of the visible triangle by pixel of the window, row-major; -1 = none.
  const std::vector<int>& triangle() const { return triangle_; }

  /// Barycentric weights, on the surface (so perspective is right), of what the pixel `index` of
  /// the window shows. `mesh` is the one drawn last. @pre triangle()[index] >= 0.
  Eigen::Vector3f Weights(const Mesh& mesh, int index) const;

  /// The unit normal of the triangle that the pixel `index` of the window shows, in C, facing the
  /// camera. `mesh` is the one drawn last. @pre triangle()[index] >= 0.
  Eigen::Vector3f Normal(const Mesh& mesh, int index) const;

 private:
  /// Where a vertex falls. Columns and rows count from one pixel left of and above the window, so
  /// that the pixel (0, 0) has its centre at (1, 1).
  struct ScreenVertex {
    float x;             ///< [px]
    float y;             ///< [px]
    float inverse_z;     ///< [1/m]
    std::uint32_t cell;  ///< Of the grid between pixel centres: column << 16 | row.
  };

  /// Where the vertices of the mesh fall, one array a member.
  struct ScreenVertices {
    Eigen::ArrayXf x;
    Eigen::ArrayXf y;
    Eigen::ArrayXf inverse_z;
    Eigen::ArrayXi cell;

    ScreenVertex operator[](int i) const {
      return {x[i], y[i], inverse_z[i], static_cast<std::uint32_t>(cell[i])};
    }
  };

  Eigen::Vector3f ToCamera(const Eigen::Vector3f& p_M) const { return R_CM_ * p_M + p_CM_; }
  ScreenVertex Project(const Eigen::Vector3f& p_C) const;
  bool PlaceVertices(const Mesh& mesh);
  void DrawMesh(const Mesh& mesh);
  void DrawClipped(const Mesh& mesh);
  void DrawTriangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, int index);

  PixelRect window_;
  CameraModel camera_;
  Eigen::Matrix3f R_CM_;
  Eigen::Vector3f p_CM_;
  ScreenVertices screen_;
  std::vector<int> crossing_;           ///< Triangles that may hold a pixel's centre.
  std::vector<std::uint64_t> nearest_;  ///< By pixel: bits of 1/z, then the triangle; 0: none.
  std::vector<float> depth_;
  std::vector<int> triangle_;
};

}  // namespace secondlook::geometry

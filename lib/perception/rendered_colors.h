#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "lib/geometry/depth_rasteriser.h"
#include "lib/geometry/mesh.h"

namespace secondlook::perception {

/// The colours of a rendered mesh, averaged over 3 x 3 pixels like the measured ones (MeanColor()).
class RenderedColors {
 public:
  /// @param rendered has drawn `mesh` last.
  RenderedColors(const geometry::Mesh& mesh, const geometry::DepthRasteriser& rendered);

  /// Of the pixel (x, y) of the window, RGB in [0, 1], unlit; empty where the mesh does not fill
  /// the 3 x 3 pixels.
  const std::optional<Eigen::Vector3f>& Mean(int x, int y) const { return means_[At(x, y)]; }

 private:
  std::size_t At(int x, int y) const { return static_cast<std::size_t>(y * width_ + x); }

  int width_;
  std::vector<std::optional<Eigen::Vector3f>> means_;
};

}  // namespace secondlook::perception

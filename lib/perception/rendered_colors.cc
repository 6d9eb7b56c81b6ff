#include "lib/perception/rendered_colors.h"

namespace secondlook::perception {

RenderedColors::RenderedColors(const geometry::Mesh& mesh,
                               const geometry::DepthRasteriser& rendered)
    : width_(rendered.window().width), means_(rendered.depth().size()) {
  const int height = rendered.window().height;
  std::vector<Eigen::Vector3f> colors(means_.size());
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const int triangle = rendered.triangle()[i];
    if (triangle < 0) continue;
    colors[i] = geometry::ColorAt(mesh, triangle, rendered.Weights(mesh, static_cast<int>(i)));
  }
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width_; ++x) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      bool whole = true;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const std::size_t at = At(x + dx, y + dy);
          whole = whole && rendered.triangle()[at] >= 0;
          if (whole) sum += colors[at];
        }
      }
      if (whole) means_[At(x, y)] = sum / 9.0F;
    }
  }
}

}  // namespace secondlook::perception

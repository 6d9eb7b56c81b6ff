#include "lib/planning/hidden_space.h"

#include <algorithm>
#include <cmath>

#include "lib/common/check_range.h"

namespace secondlook::planning {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

/// The grid over the rectangle of a support plane, by its own two edges.
class PlaneGrid {
 public:
  PlaneGrid(const world::SupportPlane& plane_W, double cell)
      : plane_(plane_W),
        rows_(Cells(plane_W.corners_A[3], plane_W.corners_A[0], cell)),
        columns_(Cells(plane_W.corners_A[1], plane_W.corners_A[0], cell)) {}

  int rows() const { return rows_; }
  int columns() const { return columns_; }

  /// The point `height` above the plane at a row and column; whole numbers are centres of cells.
  Vector3d At(double row, double column, double height) const {
    const auto& c = plane_.corners_A;
    return c[0] + (c[3] - c[0]) * ((row + 0.5) / rows_) +
           (c[1] - c[0]) * ((column + 0.5) / columns_) + height * plane_.normal_A;
  }

  double CellArea() const {
    const auto& c = plane_.corners_A;
    return (c[1] - c[0]).norm() * (c[3] - c[0]).norm() / (rows_ * columns_);
  }

 private:
  static int Cells(const Vector3d& a, const Vector3d& b, double cell) {
    return std::max(1, static_cast<int>(std::ceil((a - b).norm() / cell)));
  }
  world::SupportPlane plane_;
  int rows_;
  int columns_;
};

bool NearKnown(const Vector3d& p_WQ, const std::vector<AlignedBox3d>& known_W, double clearance) {
  return std::any_of(known_W.begin(), known_W.end(), [&](const AlignedBox3d& box) {
    return p_WQ.x() > box.min().x() - clearance && p_WQ.x() < box.max().x() + clearance &&
           p_WQ.y() > box.min().y() - clearance && p_WQ.y() < box.max().y() + clearance;
  });
}

}  // namespace

void HiddenSpaceConfig::Validate() const {
  CheckRange(cell_m, 0.005, 0.5, "cell_m");
  CheckRange(height_m, 0.0, 1.0, "height_m");
  CheckRange(clearance_m, 0.0, 1.0, "clearance_m");
  CheckRange(min_area_m2, 0.0, 10.0, "min_area_m2");
  CheckRange(box_height_m, 0.001, 2.0, "box_height_m");
}

std::vector<AlignedBox3d> HiddenRegions(const world::VoxelSpace& space,
                                        const world::SupportPlane& plane_W,
                                        const std::vector<AlignedBox3d>& known_W,
                                        const HiddenSpaceConfig& config) {
  const PlaneGrid grid(plane_W, config.cell_m);
  const auto index = [&](int row, int column) { return row * grid.columns() + column; };
  std::vector<char> hidden(static_cast<std::size_t>(grid.rows()) * grid.columns(), 0);
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const Vector3d p_WQ = grid.At(row, column, config.height_m);
      hidden[index(row, column)] = space.At(p_WQ) == world::Occupancy::kUnknown &&
                                   !NearKnown(p_WQ, known_W, config.clearance_m);
    }
  }

  struct Region {
    int cells{};
    AlignedBox3d box_W;
  };
  std::vector<Region> regions;
  std::vector<std::pair<int, int>> stack;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      if (!hidden[index(row, column)]) continue;
      regions.emplace_back();
      hidden[index(row, column)] = 0;
      stack.emplace_back(row, column);
      while (!stack.empty()) {
        const auto [r, c] = stack.back();
        stack.pop_back();
        ++regions.back().cells;
        for (const double height : {0.0, config.box_height_m}) {
          for (const auto& [row_edge, column_edge] :
               {std::pair{-0.5, -0.5}, {-0.5, 0.5}, {0.5, -0.5}, {0.5, 0.5}}) {
            regions.back().box_W.extend(grid.At(r + row_edge, c + column_edge, height));
          }
        }
        for (const auto& [dr, dc] : {std::pair{0, 1}, {0, -1}, {1, 0}, {-1, 0}}) {
          const int nr = r + dr;
          const int nc = c + dc;
          if (nr < 0 || nc < 0 || nr >= grid.rows() || nc >= grid.columns()) continue;
          if (!hidden[index(nr, nc)]) continue;
          hidden[index(nr, nc)] = 0;
          stack.emplace_back(nr, nc);
        }
      }
    }
  }
  std::erase_if(regions, [&](const Region& region) {
    return region.cells * grid.CellArea() < config.min_area_m2;
  });
  std::stable_sort(regions.begin(), regions.end(),
                   [](const Region& a, const Region& b) { return a.cells > b.cells; });
  std::vector<AlignedBox3d> boxes;
  for (const Region& region : regions) boxes.push_back(region.box_W);
  return boxes;
}

}  // namespace secondlook::planning

#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lib/hal/base.h"
#include "lib/world/support_plane.h"
#include "lib/world/voxel_space.h"

namespace secondlook::planning {

struct CostMapConfig {
  double cell_m{0.05};                 ///< Edge of a cell.
  double reach_m{3.0};                 ///< The map covers the square so far from its centre.
  double min_height_m{0.05};           ///< What is lower is the floor.
  double support_margin_m{0.03};       ///< Support surfaces are grown by so much.
  double clearance_m{0.05};            ///< Kept between the footprint and what is occupied.
  double localisation_sigma_m{0.015};  ///< Of the base's stops; two of them are kept as well.
  double unknown_cost{2.0};            ///< A metre where nothing was seen counts as so many, >= 1.

  template <class A>
  void Serialize(A* a) {
    a->Visit("cell_m", &cell_m);
    a->Visit("reach_m", &reach_m);
    a->Visit("min_height_m", &min_height_m);
    a->Visit("support_margin_m", &support_margin_m);
    a->Visit("clearance_m", &clearance_m);
    a->Visit("localisation_sigma_m", &localisation_sigma_m);
    a->Visit("unknown_cost", &unknown_cost);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// How far the base's centre has to keep from what is occupied [m]: its radius, the clearance, and
/// two sigma of where it really stands.
double SafeRadius(const hal::BaseInfo& base, const CostMapConfig& config);

/// Where the base's centre may go: a grid on the floor (z = 0 of W). Occupied is what the voxel
/// space holds between the floor and the base's height, and all that lies below a support surface,
/// because nobody sees its underside. What was never seen is passable but dearer: the base has a
/// safety stop of its own, and Block() enters where it had to use it.
class CostMap {
 public:
  using Cell = Eigen::Vector2i;

  /// The map around `center_W` (x, y).
  /// @throws ConfigError when `config` is not valid, InvalidArgument for a centre, a support or a
  /// base size that is not finite.
  CostMap(const world::VoxelSpace& space, const std::vector<world::SupportPlane>& supports_W,
          const hal::BaseInfo& base, const Eigen::Vector2d& center_W,
          const CostMapConfig& config = {});

  /// Marks the disc around the point as occupied. What lies outside of the map is ignored.
  /// @throws InvalidArgument when a value is not finite.
  void Block(const Eigen::Vector2d& p_W, double radius);

  int size() const { return size_; }  ///< Cells along each edge.
  double cell() const { return config_.cell_m; }

  /// The cell around the point; it may lie outside.
  Cell CellOf(const Eigen::Vector2d& p_W) const;
  Eigen::Vector2d CenterOf(const Cell& cell) const;
  bool Contains(const Cell& cell) const { return cell.minCoeff() >= 0 && cell.maxCoeff() < size_; }

  /// @pre Contains(cell), here and below.
  bool Occupied(const Cell& cell) const { return occupied_[Index(cell)] != 0; }
  /// From the cell's centre to the nearest occupied cell's edge [m], 0 in an occupied cell.
  double Clearance(const Cell& cell) const { return clearance_[Index(cell)]; }
  /// The base's centre may be there. Half a cell, by which a grid may be wrong, is taken from the
  /// clearance; where the base is to stand, the CollisionChecker decides exactly.
  bool Passable(const Cell& cell) const {
    return Clearance(cell) >= safe_radius_ - 0.5 * config_.cell_m;
  }
  /// What a metre there counts: 1, or the config's unknown_cost.
  double Cost(const Cell& cell) const {
    return seen_[Index(cell)] != 0 ? 1.0 : config_.unknown_cost;
  }

  double safe_radius() const { return safe_radius_; }  ///< [m]

 private:
  std::size_t Index(const Cell& cell) const {
    return static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(size_) +
           static_cast<std::size_t>(cell.x());
  }
  void MarkColumn(const Eigen::Vector2d& p_W, double edge, bool blocked);
  void ComputeClearance();

  CostMapConfig config_;
  double safe_radius_{};
  Eigen::Vector2d origin_W_;  ///< Corner of cell (0, 0).
  int size_{};
  std::vector<std::uint8_t> occupied_;
  std::vector<std::uint8_t> seen_;
  std::vector<double> clearance_;
};

}  // namespace secondlook::planning

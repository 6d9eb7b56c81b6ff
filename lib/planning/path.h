#pragma once

#include <string>
#include <vector>

#include "lib/common/pose.h"
#include "lib/hal/base.h"
#include "lib/planning/cost_map.h"

namespace secondlook::planning {

/// A way for the base, or why there is none.
struct PlannedPath {
  bool found{};
  std::vector<Pose2> waypoints_W;  ///< Without the start; the last is the goal. Headings between
                                   ///< are those the base has when it arrives.
  double metres{};                 ///< Its length.
  double seconds{};                ///< Turning on the spot and driving straight.
  std::string reason;              ///< Why there is none, with values; empty when found.
};

/// The best ways from one place to everywhere on a cost map. One search serves all goals (38 for
/// each object), so this is Dijkstra's algorithm from the start rather than A* to each goal. Ways
/// go over the 8 neighbours and are then pulled straight where the line of sight is clear and no
/// dearer. A start that is itself blocked, because the base stands nearer to something than it
/// should, may be left, as long as each step leads further away from what blocks it.
/// Deterministic: of equally good ways that one whose cells come first, row by row.
class Routes {
 public:
  /// @param map Must outlive this.
  /// @throws InvalidArgument for a start that is not finite or a base without speed.
  Routes(const CostMap& map, const Pose2& start_W, const hal::BaseInfo& base);

  /// The way to `goal_W`. @throws InvalidArgument for a goal that is not finite.
  PlannedPath To(const Pose2& goal_W) const;

  /// Cost of the best way over the grid to the centre of `cell` [m, dearer where unknown]; infinity
  /// when there is none. @pre the map contains it.
  double CostTo(const CostMap::Cell& cell) const;

 private:
  int Index(const CostMap::Cell& cell) const { return cell.y() * map_.size() + cell.x(); }
  CostMap::Cell CellAt(int index) const { return {index % map_.size(), index / map_.size()}; }
  void Search();
  double LineCost(const Eigen::Vector2d& from_W, const Eigen::Vector2d& to_W) const;
  std::vector<Eigen::Vector2d> Straighten(const std::vector<Eigen::Vector2d>& points_W) const;

  const CostMap& map_;
  Pose2 start_W_;
  hal::BaseInfo base_;
  std::vector<double> cost_;
  std::vector<int> previous_;  ///< Index of the cell before, -1 at the start or where no way leads.
};

/// Seconds the base takes from `start_W` along `waypoints_W` (turn, drive, …, turn to the last
/// heading).
double DriveSeconds(const Pose2& start_W, const std::vector<Pose2>& waypoints_W,
                    const hal::BaseInfo& base);

}  // namespace secondlook::planning

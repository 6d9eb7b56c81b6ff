#include "lib/planning/path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "lib/common/error.h"

namespace secondlook::planning {
namespace {

constexpr double kNoWay = std::numeric_limits<double>::infinity();
/// Less is standing still [m].
constexpr double kHere = 1e-6;

bool IsFinite(const Pose2& X) {
  return std::isfinite(X.x) && std::isfinite(X.y) && std::isfinite(X.yaw);
}

}  // namespace

double DriveSeconds(const Pose2& start_W, const std::vector<Pose2>& waypoints_W,
                    const hal::BaseInfo& base) {
  double seconds = 0.0;
  Pose2 at = start_W;
  for (const Pose2& next : waypoints_W) {
    const double length = std::hypot(next.x - at.x, next.y - at.y);
    if (length > kHere) {
      const double heading = std::atan2(next.y - at.y, next.x - at.x);
      seconds += std::abs(WrapAngle(heading - at.yaw)) / base.turn_rate + length / base.speed;
      at.yaw = heading;
    }
    at.x = next.x;
    at.y = next.y;
  }
  if (waypoints_W.empty()) return seconds;
  return seconds + std::abs(WrapAngle(waypoints_W.back().yaw - at.yaw)) / base.turn_rate;
}

Routes::Routes(const CostMap& map, const Pose2& start_W, const hal::BaseInfo& base)
    : map_(map), start_W_(start_W), base_(base) {
  if (!IsFinite(start_W)) {
    Throw<InvalidArgument>("routes: the start ({}, {}) m, {} rad is not finite", start_W.x,
                           start_W.y, start_W.yaw);
  }
  if (!(base.speed > 0.0) || !(base.turn_rate > 0.0)) {
    Throw<InvalidArgument>(
        "routes: base '{}' with a speed of {} m/s and {} rad/s; both must be positive", base.name,
        base.speed, base.turn_rate);
  }
  const auto cells = static_cast<std::size_t>(map.size()) * static_cast<std::size_t>(map.size());
  cost_.assign(cells, kNoWay);
  previous_.assign(cells, -1);
  Search();
}

void Routes::Search() {
  const CostMap::Cell start = map_.CellOf({start_W_.x, start_W_.y});
  if (!map_.Contains(start)) return;
  static constexpr std::array<std::pair<int, int>, 8> kNeighbours = {
      {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};
  using Entry = std::pair<double, int>;  // equal costs come in the order of the cells
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  cost_[Index(start)] = 0.0;
  open.emplace(0.0, Index(start));
  while (!open.empty()) {
    const auto [cost, index] = open.top();
    open.pop();
    if (cost > cost_[index]) continue;
    const CostMap::Cell cell = CellAt(index);
    for (const auto& [dx, dy] : kNeighbours) {
      const CostMap::Cell next = cell + CostMap::Cell(dx, dy);
      if (!map_.Contains(next)) continue;
      // Out of a blocked start, and only uphill.
      const bool escapes = !map_.Passable(cell) && map_.Clearance(next) > map_.Clearance(cell);
      if (!map_.Passable(next) && !escapes) continue;
      if (dx != 0 && dy != 0 && !escapes &&
          !(map_.Passable({cell.x(), next.y()}) && map_.Passable({next.x(), cell.y()}))) {
        continue;  // cuts a blocked corner
      }
      const double length = (dx != 0 && dy != 0 ? std::sqrt(2.0) : 1.0) * map_.cell();
      const double total = cost + length * 0.5 * (map_.Cost(cell) + map_.Cost(next));
      if (!(total < cost_[Index(next)])) continue;
      cost_[Index(next)] = total;
      previous_[Index(next)] = index;
      open.emplace(total, Index(next));
    }
  }
}

double Routes::CostTo(const CostMap::Cell& cell) const { return cost_[Index(cell)]; }

double Routes::LineCost(const Eigen::Vector2d& from_W, const Eigen::Vector2d& to_W) const {
  const double length = (to_W - from_W).norm();
  const int steps = std::max(1, static_cast<int>(std::ceil(length / (0.25 * map_.cell()))));
  const Eigen::Vector2d step = (to_W - from_W) / steps;
  double cost = 0.0;
  for (int i = 0; i <= steps; ++i) {
    const CostMap::Cell cell = map_.CellOf(from_W + i * step);
    if (!map_.Contains(cell) || !map_.Passable(cell)) return kNoWay;
    // The ends count half (trapezoidal rule).
    cost += map_.Cost(cell) * (i == 0 || i == steps ? 0.5 : 1.0);
  }
  return cost * length / steps;
}

std::vector<Eigen::Vector2d> Routes::Straighten(
    const std::vector<Eigen::Vector2d>& points_W) const {
  std::vector<Eigen::Vector2d> straight;
  std::size_t at = 0;
  while (at + 1 < points_W.size()) {
    std::size_t next = at + 1;
    double along = LineCost(points_W[at], points_W[next]);
    for (std::size_t i = at + 2; i < points_W.size(); ++i) {
      along += LineCost(points_W[i - 1], points_W[i]);
      if (std::isinf(along)) break;  // still on the way out of a blocked start
      if (LineCost(points_W[at], points_W[i]) <= along + kHere) next = i;
    }
    straight.push_back(points_W[next]);
    at = next;
  }
  return straight;
}

PlannedPath Routes::To(const Pose2& goal_W) const {
  if (!IsFinite(goal_W)) {
    Throw<InvalidArgument>("routes: the goal ({}, {}) m, {} rad is not finite", goal_W.x, goal_W.y,
                           goal_W.yaw);
  }
  const Eigen::Vector2d from_W(start_W_.x, start_W_.y);
  const Eigen::Vector2d to_W(goal_W.x, goal_W.y);
  const CostMap::Cell start = map_.CellOf(from_W);
  const CostMap::Cell goal = map_.CellOf(to_W);
  const auto refuse = [&](std::string reason) {
    return PlannedPath{false, {}, 0.0, 0.0, std::move(reason)};
  };
  if (!map_.Contains(start)) {
    return refuse(fmt::format("the start ({:.2f}, {:.2f}) m lies outside of the map", start_W_.x,
                              start_W_.y));
  }
  if (!map_.Contains(goal)) {
    return refuse(
        fmt::format("the goal ({:.2f}, {:.2f}) m lies outside of the map", goal_W.x, goal_W.y));
  }
  if (!map_.Passable(goal) && goal != start) {
    return refuse(
        fmt::format("the goal ({:.2f}, {:.2f}) m is {:.3f} m from what is occupied; the "
                    "base needs {:.3f} m",
                    goal_W.x, goal_W.y, map_.Clearance(goal), map_.safe_radius()));
  }
  if (std::isinf(cost_[Index(goal)])) {
    if (!map_.Passable(start)) {
      return refuse(
          fmt::format("no way out of the start ({:.2f}, {:.2f}) m, {:.2f} m from what is "
                      "occupied",
                      start_W_.x, start_W_.y, map_.Clearance(start)));
    }
    return refuse(fmt::format("no way from ({:.2f}, {:.2f}) to ({:.2f}, {:.2f}) m", start_W_.x,
                              start_W_.y, goal_W.x, goal_W.y));
  }

  std::vector<Eigen::Vector2d> points_W = {to_W};
  for (int index = previous_[Index(goal)]; index >= 0 && previous_[index] >= 0;
       index = previous_[index]) {
    points_W.push_back(map_.CenterOf(CellAt(index)));
  }
  points_W.push_back(from_W);
  std::reverse(points_W.begin(), points_W.end());

  PlannedPath path{true, {}, 0.0, 0.0, ""};
  Eigen::Vector2d at = from_W;
  for (const Eigen::Vector2d& next : Straighten(points_W)) {
    path.metres += (next - at).norm();
    path.waypoints_W.push_back(
        {next.x(), next.y(), std::atan2(next.y() - at.y(), next.x() - at.x())});
    at = next;
  }
  path.waypoints_W.back().yaw = goal_W.yaw;
  path.seconds = DriveSeconds(start_W_, path.waypoints_W, base_);
  return path;
}

}  // namespace secondlook::planning

#include "lib/fusion/match.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace secondlook::fusion {
namespace {

constexpr std::int64_t kRow = std::int64_t{1} << 32;

}  // namespace

Footprint::Footprint(const std::vector<Eigen::Vector3d>& points_W, double cell) {
  for (const Eigen::Vector3d& p : points_W) {
    cells_.push_back(static_cast<std::int64_t>(std::floor(p.y() / cell)) * kRow +
                     static_cast<std::int64_t>(std::floor(p.x() / cell)));
  }
  std::sort(cells_.begin(), cells_.end());
  cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
}

double Footprint::OverlapWith(const Footprint& other) const {
  const Footprint& small = cells_.size() <= other.cells_.size() ? *this : other;
  const Footprint& large = &small == this ? other : *this;
  if (small.empty()) return 0.0;
  int covered = 0;
  for (const std::int64_t cell : small.cells_) {
    for (const std::int64_t row : {-kRow, std::int64_t{0}, kRow}) {
      const auto found = std::lower_bound(large.cells_.begin(), large.cells_.end(), cell + row - 1);
      if (found != large.cells_.end() && *found <= cell + row + 1) {
        ++covered;
        break;
      }
    }
  }
  return static_cast<double>(covered) / static_cast<double>(small.cells_.size());
}

std::vector<Match> MatchByFootprint(const std::vector<Footprint>& detections,
                                    const std::vector<Footprint>& objects, double min_overlap) {
  // Connected components of the graph detection - object; detections are nodes 0 … n - 1.
  const int n = static_cast<int>(detections.size());
  const int total = n + static_cast<int>(objects.size());
  std::vector<int> parent(total);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (int d = 0; d < n; ++d) {
    for (int o = n; o < total; ++o) {
      if (detections[d].OverlapWith(objects[o - n]) < min_overlap) continue;
      const int a = root(d);
      const int b = root(o);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<Match> matches;
  std::vector<int> match_of(total, -1);
  for (int i = 0; i < total; ++i) {
    int& match = match_of[root(i)];
    if (match < 0) {
      match = static_cast<int>(matches.size());
      matches.emplace_back();
    }
    (i < n ? matches[match].detections : matches[match].objects).push_back(i < n ? i : i - n);
  }
  return matches;
}

}  // namespace secondlook::fusion

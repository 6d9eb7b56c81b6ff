#include "lib/fusion/match.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Dense>

namespace secondlook::fusion {
namespace {

constexpr std::int64_t kRow = std::int64_t{1} << 32;

}  // namespace

Footprint::Footprint(const std::vector<Eigen::Vector3d>& points_W, double cell) : cell_(cell) {
  for (const Eigen::Vector3d& p : points_W) {
    cells_.push_back(static_cast<std::int64_t>(std::floor(p.y() / cell)) * kRow +
                     static_cast<std::int64_t>(std::floor(p.x() / cell)));
  }
  std::sort(cells_.begin(), cells_.end());
  cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
}

double Footprint::OverlapWith(const Footprint& other, int reach) const {
  const Footprint& small = cells_.size() <= other.cells_.size() ? *this : other;
  const Footprint& large = &small == this ? other : *this;
  if (small.empty()) return 0.0;
  int covered = 0;
  for (const std::int64_t cell : small.cells_) {
    for (int k = -reach; k <= reach; ++k) {
      const std::int64_t middle = cell + k * kRow;
      const auto found = std::lower_bound(large.cells_.begin(), large.cells_.end(), middle - reach);
      if (found != large.cells_.end() && *found <= middle + reach) {
        ++covered;
        break;
      }
    }
  }
  return static_cast<double>(covered) / static_cast<double>(small.cells_.size());
}

Location Locate(const std::vector<Eigen::Vector3d>& points_W) {
  Location location;
  for (const Eigen::Vector3d& p : points_W) location.mean_W += p;
  location.mean_W /= static_cast<double>(points_W.size());
  for (const Eigen::Vector3d& p : points_W) {
    const Eigen::Vector3d d = p - location.mean_W;
    location.spread_W += d * d.transpose() / static_cast<double>(points_W.size());
  }
  return location;
}

Eigen::Matrix3d PointCovariance(const Eigen::Matrix<double, 6, 6>& covariance,
                                const Eigen::Vector3d& p_CQ_W) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << 0.0, p_CQ_W.z(), -p_CQ_W.y(), 1.0, 0.0, 0.0,  //
      -p_CQ_W.z(), 0.0, p_CQ_W.x(), 0.0, 1.0, 0.0,          //
      p_CQ_W.y(), -p_CQ_W.x(), 0.0, 0.0, 0.0, 1.0;
  return jacobian * covariance * jacobian.transpose();
}

double Sigmas(const Location& a, const Location& b, const Eigen::Matrix3d& error_W) {
  // What is flat and perfectly measured is no thinner than this.
  constexpr double kLeast = 0.002;  // [m]
  const Eigen::Matrix3d covariance =
      a.spread_W + b.spread_W + error_W + kLeast * kLeast * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d d = a.mean_W - b.mean_W;
  return std::sqrt(d.dot(covariance.ldlt().solve(d)));
}

Seen::Seen(const std::vector<Eigen::Vector3d>& points_W, double cell)
    : footprint(points_W, cell), location(Locate(points_W)) {}

std::vector<Match> MatchSeen(const std::vector<Seen>& detections, const std::vector<Seen>& objects,
                             const MatchGate& gate) {
  const double shift =
      2.0 * std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(
                          gate.error_W.topLeftCorner<2, 2>(), Eigen::EigenvaluesOnly)
                          .eigenvalues()
                          .maxCoeff());
  const auto are_one = [&](const Seen& detection, const Seen& object) {
    const int reach = 1 + static_cast<int>(std::max(0.0, shift) / detection.footprint.cell());
    return detection.footprint.OverlapWith(object.footprint, reach) >= gate.min_overlap &&
           Sigmas(detection.location, object.location, gate.error_W) <= gate.max_sigmas;
  };
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
      if (!are_one(detections[d], objects[o - n])) continue;
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

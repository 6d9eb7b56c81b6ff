#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace secondlook::fusion {

/// The cells of a grid on the support plane over which a thing's seen surface lies. A camera above
/// the table sees the top of a thing from every side, so its footprints of different views overlap
/// even where the sides it saw do not.
class Footprint {
 public:
  /// Of points in W [m], which is z up; cells are `cell` > 0 [m] wide.
  Footprint(const std::vector<Eigen::Vector3d>& points_W, double cell);

  bool empty() const { return cells_.empty(); }

  /// Share of the smaller footprint's cells that lie on or beside a cell of the other, in [0, 1];
  /// 0 when either is empty. @pre both have the same cell width.
  double OverlapWith(const Footprint& other) const;

 private:
  std::vector<std::int64_t> cells_;  // sorted, unique
};

/// Detections and objects that are one thing. Each detection and each object is in exactly one.
struct Match {
  std::vector<int> detections;  ///< Ascending. Several: an occluder cuts the thing in two.
  std::vector<int> objects;     ///< Ascending. Several: they were one thing all along.
};

/// Which of a view's detections are which of the known objects: those whose footprints overlap by
/// at least `min_overlap` belong together. A detection by itself is a new object; an object by
/// itself was not seen. Ordered by the first detection, objects not seen last.
std::vector<Match> MatchByFootprint(const std::vector<Footprint>& detections,
                                    const std::vector<Footprint>& objects, double min_overlap);

}  // namespace secondlook::fusion

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

  /// Share of the smaller footprint's cells that lie on a cell of the other, or at most `reach`
  /// cells beside one, in [0, 1]; 0 when either is empty. @pre both have the same cell width.
  double OverlapWith(const Footprint& other, int reach = 1) const;

  double cell() const { return cell_; }

 private:
  double cell_;
  std::vector<std::int64_t> cells_;  // sorted, unique
};

/// Where the points that were seen of a thing lie.
struct Location {
  Eigen::Vector3d mean_W{Eigen::Vector3d::Zero()};    ///< [m]
  Eigen::Matrix3d spread_W{Eigen::Matrix3d::Zero()};  ///< Their covariance [m^2].
};

/// @pre there are points.
Location Locate(const std::vector<Eigen::Vector3d>& points_W);

/// The covariance [m^2] of a point that lies `p_CQ_W` from a camera whose pose has `covariance`
/// (rotation vector about the camera [rad], translation [m]).
Eigen::Matrix3d PointCovariance(const Eigen::Matrix<double, 6, 6>& covariance,
                                const Eigen::Vector3d& p_CQ_W);

/// Mahalanobis distance of what was seen of two things. As a view shows any part of a thing, the
/// middle of what is seen errs by the spread of its points; beside that by `error_W` [m^2].
double Sigmas(const Location& a, const Location& b, const Eigen::Matrix3d& error_W);

/// What a view shows of a thing, or what is known of it.
struct Seen {
  /// @pre there are points; `cell` as Footprint has it.
  Seen(const std::vector<Eigen::Vector3d>& points_W, double cell);

  Footprint footprint;
  Location location;
};

/// When two are one thing.
struct MatchGate {
  double min_overlap = 0.3;  ///< Of their footprints.
  double max_sigmas = 3.37;  ///< Of their places: 99 % in three dimensions.
  /// Of the places of a view's points against those that are known, by its registration [m^2].
  Eigen::Matrix3d error_W{Eigen::Matrix3d::Zero()};
};

/// Detections and objects that are one thing. Each detection and each object is in exactly one.
struct Match {
  std::vector<int> detections;  ///< Ascending. Several: an occluder cuts the thing in two.
  std::vector<int> objects;     ///< Ascending. Several: they were one thing all along.
};

/// Which of a view's detections are which of the known objects: those belong together whose places
/// agree within the gate, and whose footprints overlap, as far as two sigma of the error may shift
/// them. A detection by itself is a new object; an object by itself was not seen. Ordered by the
/// first detection, objects not seen last.
std::vector<Match> MatchSeen(const std::vector<Seen>& detections, const std::vector<Seen>& objects,
                             const MatchGate& gate);

}  // namespace secondlook::fusion

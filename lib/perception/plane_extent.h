#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace secondlook::perception {

// What points that lie on a plane cover of it. Points are in any one frame [m]; a plane's normal is
// a unit vector, and its offset is normal . p for p on the plane.

/// Two unit axes that span the plane: at right angles to each other, the first x the second =
/// normal.
std::array<Eigen::Vector3d, 2> PlaneAxes(const Eigen::Vector3d& normal);

/// The point in the plane's axes [m].
cv::Point2f OnPlane(const std::array<Eigen::Vector3d, 2>& axes, const Eigen::Vector3d& p);

/// The convex extent of the points, in the plane's axes; empty when there are none.
std::vector<cv::Point2f> ConvexExtent(const std::vector<Eigen::Vector3d>& points,
                                      const std::array<Eigen::Vector3d, 2>& axes);

/// Fits the smallest-area rectangle around the points: its corners, counter-clockwise seen against
/// the normal. Without points all four are the plane's point nearest to the origin.
std::array<Eigen::Vector3d, 4> FitRectangle(const std::vector<Eigen::Vector3d>& points,
                                            const Eigen::Vector3d& normal, double offset);

/// The largest connected patch of the points: those more than 4 cm apart do not connect.
/// `points` must not be empty.
std::vector<Eigen::Vector3d> LargestPatch(const std::vector<Eigen::Vector3d>& points,
                                          const Eigen::Vector3d& normal);

/// The first of the points in each square `cell` [m] of the plane.
std::vector<Eigen::Vector3d> ThinnedOnPlane(const std::vector<Eigen::Vector3d>& points,
                                            const Eigen::Vector3d& normal, double cell);

}  // namespace secondlook::perception

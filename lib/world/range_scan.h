#pragma once

#include <vector>

#include <Eigen/Core>

namespace secondlook::world {

/// A line of a RangeScan: what the sensor measured from one place.
struct RangeLine {
  Eigen::Vector3d p_WS;  ///< The sensor's origin at the line's own time [m].
  int end{};             ///< One past its last point; it begins where the line before ends.
};

/// One scan of a range sensor, in W by the poses that the robot had: a striper's sweep with a line
/// for each stripe, or a depth image, which is one line.
struct RangeScan {
  std::vector<Eigen::Vector3d> points_W;  ///< What was measured, line by line [m].
  std::vector<float> sigmas;              ///< Of each point, along its ray [m], > 0.
  std::vector<Eigen::Vector3f> colors;    ///< Of each point, RGB in [0, 1]; or empty.
  std::vector<RangeLine> lines;           ///< Their ends do not decrease; the last is the number
                                          ///< of points.
  double position_sigma{};                ///< Of the sensor's poses, common to all lines [m], >= 0.
  double rotation_sigma{};                ///< … and about each axis [rad], >= 0.

  bool empty() const { return points_W.empty(); }
};

/// @throws InvalidArgument naming the value when `scan` is not as described above.
void Check(const RangeScan& scan);

}  // namespace secondlook::world

#pragma once

#include <string>

#include <Eigen/Core>

namespace secondlook::apps {

/// Parses the value of `--up`, "x,y,z", to a unit vector in the camera frame.
/// @throws InvalidArgument naming the text when it is not three numbers that make a direction.
Eigen::Vector3d ParseUp(const std::string& text);

/// What stands in for a missing `--up`: image-up, to be taken within this angle.
inline const Eigen::Vector3d kImageUp_C{0.0, -1.0, 0.0};
inline constexpr double kImageUpTolerance_deg = 60.0;

}  // namespace secondlook::apps

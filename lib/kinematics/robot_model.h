#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/shape.h"

namespace secondlook::kinematics {

/// What joins a link L to its parent P.
struct Joint {
  std::string name;
  Pose X_PL{Pose::Identity()};            ///< With the joint at 0.
  bool turns{};                           ///< A revolute joint; false: a fixed one.
  Eigen::Vector3d axis_L{0.0, 0.0, 1.0};  ///< Unit; the rest is of a revolute joint alone.
  double lower{}, upper{};                ///< Limits [rad], lower < upper.
  double speed{};                         ///< Limit [rad/s], > 0.
};

/// A rigid part of a robot.
struct Link {
  std::string name;
  int parent{-1};  ///< Index of its parent, which comes before it; -1: the root.
  Joint joint;     ///< To the parent; of the root nothing.
  std::vector<geometry::PlacedShape> body;  ///< The solids it is made of, in L.
};

/// A tree of links, as a URDF file describes it.
struct RobotModel {
  std::string name;
  std::string urdf;         ///< The text that it was read from.
  std::vector<Link> links;  ///< Parents before their children; the first is the root.

  /// The index of the link called `link`. @throws ConfigError naming those that there are.
  int IndexOf(const std::string& link) const;
};

/// The pose X_RL of every link in the root link R, by index. `angles` has one for each link: that
/// of its joint [rad], which a fixed one ignores.
std::vector<Pose> LinkPoses(const RobotModel& model, const std::vector<double>& angles);

/// Reads URDF. Bodies are the collision geometry: boxes, cylinders and spheres. Joints are revolute
/// or fixed; a revolute one has limits of position and velocity.
/// @param source What messages call the text, e.g. its file.
/// @throws ConfigError naming source, link or joint for anything else: XML that is none, a parent
/// or child link that is missing, a loop, limits that are missing, contradictory or not finite, an
/// axis of length zero, a mesh for a body.
RobotModel ParseUrdf(const std::string& text, const std::string& source);

/// The same from a file. @throws ConfigError also when it cannot be read.
RobotModel LoadUrdf(const std::filesystem::path& file);

}  // namespace secondlook::kinematics

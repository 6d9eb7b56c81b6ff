#pragma once

#include <string>
#include <vector>

#include "lib/common/pose.h"
#include "lib/hal/joint_trajectory.h"
#include "lib/hal/pan_tilt.h"

namespace secondlook::world {

/// A test that a candidate look passed or failed.
struct LookCheck {
  std::string name;  ///< "collision", "pan-tilt limits", "path", "visible", …
  bool passed{};
  std::string detail;  ///< With values.
};

/// Which of the robot's cameras a look is taken with, and so how it is reached.
enum class LookWay {
  kHead,  ///< The head's: the base drives, the head turns.
  kArm,   ///< The hand's: the arm moves, and the base stays.
};

/// "head" or "arm".
std::string ToString(LookWay way);
/// The reverse. @throws ProtocolError for another text.
LookWay ParseLookWay(const std::string& text);

/// One candidate for the next view: where the camera would be, how it gets there, every check it
/// passed or failed and every term of its score. Nothing is thrown away silently.
struct Look {
  std::string kind;             ///< The strategy that proposed it, e.g. "aspect_graph".
  int target{-1};               ///< Id of the object it is for; -1: the scene.
  LookWay way{LookWay::kHead};  ///< How it is reached.
  Pose2 X_WB;                   ///< Goal of the base, or where it stays.
  hal::PanTiltAngles head;      ///< Goal of the head, or where it stays.
  Pose X_WC{Pose::Identity()};  ///< Nominal pose of the camera there.
  /// Of the arm, which comes first: to the look, or to where it is folded before the base drives.
  hal::JointTrajectory arm_motion;
  std::vector<Pose2> path_W;      ///< Waypoints to the goal, the goal last; empty when refused.
  std::vector<LookCheck> checks;  ///< In the order they were made.
  bool feasible{};                ///< Passed them all.
  double visibility{};            ///< Share of the rays toward the target that hit its model.
  double gain{};                  ///< What the look is expected to bring; unit of the strategy.
  double seconds{};               ///< Estimated time to get there.
  double metres{};                ///< Length of the path.
  double score{};                 ///< What the choice was made by.
  bool chosen{};
  std::string reason;  ///< Why it was chosen, or which check refused it.
};

}  // namespace secondlook::world

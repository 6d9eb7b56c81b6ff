#pragma once

#include <functional>
#include <string>

#include "apps/capture.h"
#include "lib/hal/robot.h"
#include "lib/world/look.h"

namespace secondlook::apps {

/// How moving to a look ended.
struct DriveOutcome {
  enum class Kind { kReached, kFailed, kStopped };
  Kind kind{Kind::kReached};
  std::string reason;  ///< Why it failed or stopped, with values; empty when reached.
  double metres{};     ///< Driven, by localisation.
  bool base_failed{};  ///< It was the base that failed, not arm or head.
};

/// Asked often while the robot moves: true when it is to stop.
using StopRequest = std::function<bool()>;

/// Told often while the robot moves: the metres driven so far.
using MotionListener = std::function<void(double metres)>;

/// Moves the arm along `look.arm_motion`, then, unless the look is the arm's, the base along
/// `look.path_W` and the head to `look.head`, and waits until all stand still. What is empty does
/// not move. A base that is not where it says it has got to has failed. When `stop` says so, or a
/// motion takes three times as long as planned plus 15 s, everything is stopped.
/// @throws DeviceError when a device is lost. Whatever is thrown, everything that can be is stopped
/// before.
DriveOutcome MoveTo(const world::Look& look, const StopRequest& stop, const MotionListener& moving,
                    hal::Robot* robot, Capturer* capturer);

}  // namespace secondlook::apps

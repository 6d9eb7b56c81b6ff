#pragma once

#include "lib/common/check_range.h"
#include "lib/hal/guard.h"

namespace secondlook::apps {

/// What keeps a running mission safe, beside the devices' own limits (docs/safety.md).
struct SafetyConfig {
  hal::GuardConfig limits;
  /// Whoever commands the robot says at least this often that it is there (SECONDLOOK_COMMAND
  /// ALIVE), or the robot stops [s of wall time]; 0: nobody has to.
  double heartbeat_seconds{};
  /// Before each look the robot waits for SECONDLOOK_COMMAND CONFIRM.
  bool confirm{};
  /// A command to stop does not end the mission: it goes on after SECONDLOOK_COMMAND CLEAR.
  bool wait_after_stop{};

  template <class A>
  void Serialize(A* a) {
    a->Visit("limits", &limits);
    a->Visit("heartbeat_seconds", &heartbeat_seconds);
    a->Visit("confirm", &confirm);
    a->Visit("wait_after_stop", &wait_after_stop);
  }
  /// @throws ConfigError naming the value.
  void Validate() const {
    limits.Validate();
    if (heartbeat_seconds != 0.0) {
      CheckRange(heartbeat_seconds, 0.1, 60.0, "heartbeat_seconds (0: none)");
    }
  }
  /// True when it rests on what others say over LCM.
  bool NeedsCommander() const { return heartbeat_seconds > 0.0 || confirm || wait_after_stop; }
};

}  // namespace secondlook::apps

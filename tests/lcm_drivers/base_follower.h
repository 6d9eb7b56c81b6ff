#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "lib/common/clock.h"
#include "lib/hal/base.h"
#include "lib/hal/drivers/lcm_link.h"

#include "second_look/base_goal_t.hpp"

namespace secondlook::hal {

/// What goes wrong at a follower.
enum class FollowerFault {
  kNone,
  kSilent,      ///< It says nothing of what it does, and hears nothing; its pose still comes.
  kNoPose,      ///< No pose comes.
  kStopsShort,  ///< It stops after half a second and says that it has arrived.
  kGivesUp,     ///< It stops after half a second and says so.
};

/// A stand-in for a navigation stack: drives `base` where it is told to over LCM, and tells where
/// that is and how far.
class BaseFollower {
 public:
  /// @param link, base, clock Not null; outlive this, and nothing comes from the link afterwards.
  /// @param ahead By how much the stamps that it sends are ahead of that clock.
  BaseFollower(LcmLink* link, Base* base, const Clock* clock, Duration ahead = Duration::zero());

  void Set(FollowerFault fault) { fault_ = fault; }

  /// Does what was heard since the last step, and tells. By the thread that steps the base.
  void Step();

  /// How often it was told of a goal, renewals included.
  int goals_heard() const;

 private:
  struct Goal {
    std::int64_t id{};
    Time heard_at{};
    Time begun_at{};
    Duration valid{};
  };

  void Hear(const second_look::base_goal_t& message);
  void Obey();
  void Tell();

  LcmLink* link_;
  Base* base_;
  const Clock* clock_;
  const Duration ahead_;
  FollowerFault fault_{FollowerFault::kNone};
  Goal goal_;
  bool cut_short_{};

  mutable std::mutex mutex_;  // of what follows
  std::optional<second_look::base_goal_t> heard_goal_;
  std::optional<std::int64_t> heard_cancel_;
  int goals_heard_{};
};

}  // namespace secondlook::hal

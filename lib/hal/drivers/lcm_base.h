#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "lib/common/clock.h"
#include "lib/hal/base.h"
#include "lib/hal/drivers/lcm_link.h"

namespace secondlook::hal {

struct LcmBaseConfig {
  static constexpr const char* kTag = "Lcm";

  std::string name{"base"};
  double radius{0.3};            ///< Of the upright cylinder that holds the robot [m] …
  double height{1.4};            ///< … and its height [m].
  double speed{0.4};             ///< At which it cruises [m/s].
  double turn_rate_deg{60.0};    ///< At which it turns on the spot [deg/s].
  double patience_seconds{1.0};  ///< Without its pose, or an answer, for so long it is lost.
  double renew_seconds{0.25};    ///< Between two messages with the goal that it drives to.
  double valid_seconds{2.0};     ///< A goal that was not renewed for so long has lapsed.
  /// Poses are stamped by the clock of this machine, or one kept equal to it (NTP, PTP). False: by
  /// a clock of its own, and the quickest message tells how the two stand.
  bool synchronised{true};

  template <class A>
  void Serialize(A* a) {
    a->Visit("name", &name);
    a->Visit("radius", &radius);
    a->Visit("height", &height);
    a->Visit("speed", &speed);
    a->Visit("turn_rate_deg", &turn_rate_deg);
    a->Visit("patience_seconds", &patience_seconds);
    a->Visit("renew_seconds", &renew_seconds);
    a->Visit("valid_seconds", &valid_seconds);
    a->Visit("synchronised", &synchronised);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A base behind a navigation stack of its own, to which it is told over LCM where to drive, and
/// which says where it is and how far (docs/real_robot.md). A goal is renewed by those who ask how
/// far it is: nobody who asks, no motion. A stop is repeated until the base says that it stands.
class LcmBase : public Base {
 public:
  /// Waits for the first pose.
  /// @param link, clock Not null; the clock outlives both this and the link.
  /// @throws ConfigError; DeviceError naming the base when no pose came, or none that is right.
  LcmBase(const LcmBaseConfig& config, std::shared_ptr<LcmLink> link, const Clock* clock);
  /// Cancels what it drives to.
  ~LcmBase() override;

  const BaseInfo& info() const override { return info_; }
  BaseState State() override;
  void Start(const BasePath& path) override;
  MotionStatus Status() override;
  void Stop() noexcept override;

 private:
  class Inbox;
  struct Goal {
    std::int64_t id{};
    BasePath path;
    Time sent_at{};   ///< When it was, or its stop, last.
    Time heard_at{};  ///< When the base last said anything of it, or it began.
    bool stopped{};   ///< Stop() has ended it.
  };

  void Send(Goal* goal);
  void Renew(Goal* goal);
  MotionStatus Judge();
  std::string NoPose() const;

  const LcmBaseConfig config_;
  const std::shared_ptr<LcmLink> link_;
  const Clock* clock_;
  BaseInfo info_;
  std::shared_ptr<Inbox> inbox_;  ///< The link keeps it, too.

  std::mutex mutex_;  // of what follows
  Goal goal_;
  MotionStatus status_;
};

}  // namespace secondlook::hal

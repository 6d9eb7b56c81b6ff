#pragma once

#include <string>

#include "lib/common/clock.h"
#include "lib/hal/base.h"

namespace secondlook::hal {

struct FixedBaseConfig {
  static constexpr const char* kTag = "Fixed";

  double x{};  ///< Where it stands in W [m] …
  double y{};
  double yaw_deg{};
  double radius{0.3};  ///< Of the upright cylinder that holds the robot [m] …
  double height{1.4};  ///< … and its height [m].

  template <class A>
  void Serialize(A* a) {
    a->Visit("x", &x);
    a->Visit("y", &y);
    a->Visit("yaw_deg", &yaw_deg);
    a->Visit("radius", &radius);
    a->Visit("height", &height);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The base of a robot that has none: a stand that is known to be where it was put. Whatever goal
/// is not there has failed at once.
class FixedBase : public Base {
 public:
  /// @param clock Not null; outlives this. @throws ConfigError.
  FixedBase(const FixedBaseConfig& config, const Clock* clock);

  const BaseInfo& info() const override { return info_; }
  BaseState State() override;
  void Start(const BasePath& path) override;
  MotionStatus Status() override { return status_; }
  void Stop() noexcept override {}

 private:
  const Clock* clock_;
  BaseInfo info_;
  Pose2 X_WB_;
  MotionStatus status_;
};

}  // namespace secondlook::hal

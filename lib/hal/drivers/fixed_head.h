#pragma once

#include "lib/common/clock.h"
#include "lib/hal/pan_tilt.h"

namespace secondlook::hal {

struct FixedHeadConfig {
  static constexpr const char* kTag = "None";

  double pan_deg{};   ///< Where the camera looks: positive to the left …
  double tilt_deg{};  ///< … and positive down.

  template <class A>
  void Serialize(A* a) {
    a->Visit("pan_deg", &pan_deg);
    a->Visit("tilt_deg", &tilt_deg);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The head of a robot that has no pan-tilt unit: it looks where it was fixed.
class FixedHead : public PanTilt {
 public:
  /// @param clock Not null; outlives this. @throws ConfigError.
  FixedHead(const FixedHeadConfig& config, const Clock* clock);

  const PanTiltInfo& info() const override { return info_; }
  PanTiltState State() override { return {clock_->Now(), info_.lower}; }
  void Start(const PanTiltAngles& target) override;
  MotionStatus Status() override { return status_; }
  void Stop() noexcept override {}

 private:
  const Clock* clock_;
  PanTiltInfo info_;
  MotionStatus status_;
};

}  // namespace secondlook::hal

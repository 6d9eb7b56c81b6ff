#pragma once

#include "lib/common/clock.h"
#include "sim/world.h"

namespace secondlook::sim {

/// The clock of the simulated world: whoever sleeps or thinks moves the world on. Robot time begins
/// at 0 with the world and advances in whole steps of it.
class SimClock : public Clock {
 public:
  /// `world` must outlive this.
  explicit SimClock(World* world) : world_(world) {}

  Time Now() const override { return world_->Now(); }
  void SleepUntil(Time time) override;
  void ChargeThinking(Duration cost) override;

 private:
  World* world_;
  Duration owed_{};  ///< Thinking not yet stepped, less than a step.
};

}  // namespace secondlook::sim

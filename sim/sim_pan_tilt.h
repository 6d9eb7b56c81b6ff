#pragma once

#include "lib/hal/pan_tilt.h"
#include "sim/world.h"

namespace secondlook::sim {

/// The pan-tilt head of the simulated robot. See HeadDrive for how it turns.
class SimPanTilt : public hal::PanTilt {
 public:
  /// `world` must outlive this.
  explicit SimPanTilt(World* world) : world_(world) {}
  ~SimPanTilt() override { world_->head().RequestStop(); }

  const hal::PanTiltInfo& info() const override { return HeadDrive::Info(); }
  hal::PanTiltState State() override { return {world_->Now(), world_->head().encoders()}; }
  void Start(const hal::PanTiltAngles& target) override { world_->head().Start(target); }
  hal::MotionStatus Status() override { return world_->head().Status(); }
  void Stop() noexcept override { world_->head().RequestStop(); }

 private:
  World* world_;
};

}  // namespace secondlook::sim

#pragma once

#include "lib/hal/arm.h"
#include "sim/world.h"

namespace secondlook::sim {

/// The arm of the simulated robot. See ArmDrive for how it moves.
class SimArm : public hal::Arm {
 public:
  /// `world`, which has an arm, must outlive this.
  explicit SimArm(World* world) : world_(world) {}
  ~SimArm() override { world_->arm()->RequestStop(); }

  const hal::ArmInfo& info() const override { return world_->arm()->info(); }
  hal::ArmState State() override { return {world_->Now(), world_->arm()->encoders()}; }
  void Start(const hal::JointTrajectory& trajectory) override { world_->arm()->Start(trajectory); }
  hal::MotionStatus Status() override { return world_->arm()->Status(); }
  void Stop() noexcept override { world_->arm()->RequestStop(); }

 private:
  World* world_;
};

}  // namespace secondlook::sim

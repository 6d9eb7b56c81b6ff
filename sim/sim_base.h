#pragma once

#include "lib/hal/base.h"
#include "sim/world.h"

namespace secondlook::sim {

/// The base of the simulated robot. See BaseDrive for how it drives.
class SimBase : public hal::Base {
 public:
  /// `world` must outlive this.
  explicit SimBase(World* world) : world_(world) {}
  ~SimBase() override { world_->base().RequestStop(); }

  const hal::BaseInfo& info() const override { return BaseDrive::Info(); }
  hal::BaseState State() override { return world_->base().Estimate(world_->Now()); }
  void Start(const hal::BasePath& path) override { world_->base().Start(path); }
  hal::MotionStatus Status() override { return world_->base().Status(); }
  void Stop() noexcept override { world_->base().RequestStop(); }

 private:
  World* world_;
};

}  // namespace secondlook::sim

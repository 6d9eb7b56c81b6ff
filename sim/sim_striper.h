#pragma once

#include <cstdint>
#include <memory>

#include "lib/hal/laser_striper.h"
#include "sim/line_scanner.h"
#include "sim/world.h"

namespace secondlook::sim {

/// The laser striper on the arm of the simulated robot, as SimulatedStriper() says. It sees what
/// stands in the scene, not what moves in it. See StriperDrive for when it draws a line, and
/// LineScanner for what it measures.
class SimStriper : public hal::LaserStriper {
 public:
  /// `world`, which has a striper, must outlive this.
  SimStriper(World* world, std::uint64_t seed);
  ~SimStriper() override;

  const hal::StriperInfo& info() const override { return info_; }
  void On() override;
  void Off() noexcept override { world_->striper()->RequestOff(); }
  std::vector<hal::ScanLine> Take() override;
  std::uint64_t lost() const override { return world_->striper()->lost(); }

  /// The device is gone from now on.
  void Lose() { gone_ = true; }

 private:
  void RequireThere() const;

  World* world_;
  std::uint64_t seed_;
  hal::StriperInfo info_;
  std::unique_ptr<LineScanner> scanner_;  ///< Made for the first line.
  Time earliest_{};                       ///< No stamp before it.
  bool gone_{};
};

}  // namespace secondlook::sim

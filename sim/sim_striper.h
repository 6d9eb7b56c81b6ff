#pragma once

#include <cstdint>
#include <memory>

#include "lib/hal/laser_striper.h"
#include "sim/world.h"

namespace secondlook::sim {

/// The laser striper on the arm of the simulated robot: 640 points over 14.25 degrees, from 0.3 to
/// 0.6 m, 50 lines a second (the ScanControl 2700 of Kriegel et al. 2013, Table I). It sees what
/// stands in the scene, not what moves in it. Its noise depends on the seed and the sequence number
/// of a line alone. See StriperDrive for when it draws one.
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
  class Surroundings;

  void RequireThere() const;
  hal::ScanLine Measure(const Shot& shot);

  World* world_;
  std::uint64_t seed_;
  hal::StriperInfo info_;
  std::unique_ptr<Surroundings> surroundings_;  ///< Made for the first line.
  Time last_time_{};                            ///< Stamps are later.
  bool gone_{};
};

}  // namespace secondlook::sim

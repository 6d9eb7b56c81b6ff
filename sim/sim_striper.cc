#include "sim/sim_striper.h"

#include <algorithm>

#include "lib/common/error.h"

namespace secondlook::sim {

SimStriper::SimStriper(World* world, std::uint64_t seed)
    : world_(world), seed_(seed), info_(SimulatedStriper(world->noise())) {}

SimStriper::~SimStriper() { world_->striper()->RequestOff(); }

void SimStriper::RequireThere() const {
  if (!gone_) return;
  Throw<DeviceError>("striper '{}': the device is lost; check its cable and restart (simulated)",
                     info_.name);
}

void SimStriper::On() {
  RequireThere();
  earliest_ = std::max(earliest_, world_->Now());
  world_->striper()->Light(world_->Now() + kAttended);
}

std::vector<hal::ScanLine> SimStriper::Take() {
  RequireThere();
  world_->striper()->Attend(world_->Now() + kAttended);
  std::vector<hal::ScanLine> lines;
  for (const Shot& shot : world_->striper()->Take()) {
    if (!scanner_) {
      scanner_ = std::make_unique<LineScanner>(world_->fixtures(), world_->noise(), seed_);
    }
    lines.push_back(scanner_->Measure(shot));
    lines.back().time = std::max(lines.back().time, earliest_);
    earliest_ = lines.back().time + Duration(1);
  }
  return lines;
}

}  // namespace secondlook::sim

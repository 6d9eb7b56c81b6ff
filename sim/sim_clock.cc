#include "sim/sim_clock.h"

namespace secondlook::sim {

void SimClock::SleepUntil(Time time) {
  while (world_->Now() < time) world_->Step();
}

void SimClock::ChargeThinking(Duration cost) {
  for (owed_ += cost; owed_ >= World::kStep; owed_ -= World::kStep) world_->Step();
}

}  // namespace secondlook::sim

#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "lib/hal/drivers/lcm_link.h"
#include "lib/hal/drivers/live_clock.h"

#include "second_look/striper_line_t.hpp"

namespace secondlook::hal {

/// A line scanner on the network, 50 lines a second: each ray measures 0.4 m, the first has no
/// return, the second is too near. It goes off when it does not hear that it is to be on.
class StriperEmulator {
 public:
  /// @param link Not null; outlives this.
  StriperEmulator(LcmLink* link, int points);
  ~StriperEmulator();

  bool lit() const;

  /// It sends nothing from now on, or again.
  void SetSilent(bool silent) { silent_ = silent; }
  /// It says from now on that it cannot measure, and why.
  void SetFault(const std::string& fault);
  /// So many of its next lines are lost on their way.
  void Lose(int lines) { losing_ = lines; }
  /// Every line goes through `spoil` from now on; empty: none does.
  void Spoil(std::function<void(second_look::striper_line_t*)> spoil);

 private:
  void Run();
  void SendLine();

  LcmLink* link_;
  const int points_;
  LiveClock clock_;
  mutable std::mutex mutex_;  // of what follows
  Time lit_until_{};
  std::string fault_;
  std::function<void(second_look::striper_line_t*)> spoil_;
  std::int64_t sequence_{};
  std::atomic<int> losing_{0};
  std::atomic<bool> silent_{false};
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace secondlook::hal

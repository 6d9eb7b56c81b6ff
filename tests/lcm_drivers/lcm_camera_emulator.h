#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "lib/hal/camera.h"
#include "lib/hal/drivers/lcm_link.h"

#include "bot_core/images_t.hpp"

namespace secondlook::hal {

/// `frame` as colour in JPEG and, unless it has none, depth in a zlib stream.
bot_core::images_t WriteImages(const RgbdFrame& frame);

/// `frame` without anything compressed.
bot_core::images_t WriteRawImages(const RgbdFrame& frame);

/// A camera that sends what `see` returns, about 30 times a second, from a thread of its own.
class LcmCameraEmulator {
 public:
  /// @param link Not null; outlives this.
  LcmCameraEmulator(LcmLink* link, std::string channel, std::function<RgbdFrame()> see);
  ~LcmCameraEmulator();

  /// It sends nothing from now on, or again.
  void SetSilent(bool silent) { silent_ = silent; }

  /// Every message goes through `spoil` from now on; empty: none does.
  void Spoil(std::function<void(bot_core::images_t*)> spoil) {
    const std::scoped_lock lock(mutex_);
    spoil_ = std::move(spoil);
  }

 private:
  void Run();

  LcmLink* link_;
  const std::string channel_;
  const std::function<RgbdFrame()> see_;
  std::mutex mutex_;  // of what follows
  std::function<void(bot_core::images_t*)> spoil_;
  std::atomic<bool> silent_{false};
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace secondlook::hal

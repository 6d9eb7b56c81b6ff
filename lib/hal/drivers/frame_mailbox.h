#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "lib/common/error.h"
#include "lib/hal/camera.h"

namespace secondlook::hal {

/// Hands the newest frame from a capture thread to the caller of Camera::Grab(); unread older ones
/// are lost. Threading: any.
class FrameMailbox {
 public:
  /// Puts a frame in place of the one that is there. One that is not newer than the last that was
  /// put is left out: a frame's time never runs backwards. The camera is there (again).
  void Put(RgbdFrame frame) {
    const std::scoped_lock lock(mutex_);
    lost_.clear();
    if (frame.time <= last_) return;
    last_ = frame.time;
    frame_ = std::move(frame);
    there_.notify_all();
  }

  /// Take() throws from now on, until a frame is put.
  void Lose(const std::string& why) {
    const std::scoped_lock lock(mutex_);
    lost_ = why;
    frame_.reset();
    there_.notify_all();
  }

  /// The frame, waiting up to `timeout` (of the machine) for one; empty when none came.
  /// @throws DeviceError with what Lose() was told.
  std::optional<RgbdFrame> Take(Duration timeout) {
    std::unique_lock lock(mutex_);
    there_.wait_for(lock, timeout, [&] { return frame_.has_value() || !lost_.empty(); });
    if (!lost_.empty()) throw DeviceError(lost_);
    return std::exchange(frame_, std::nullopt);
  }

 private:
  std::mutex mutex_;
  std::condition_variable there_;
  std::optional<RgbdFrame> frame_;
  Time last_{};
  std::string lost_;
};

}  // namespace secondlook::hal

#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include <lcm/lcm-cpp.hpp>

#include "apps/story.h"
#include "lib/common/stopwatch.h"

namespace secondlook::apps {

/// What a listener has heard so far.
struct Heard {
  std::int64_t messages{};
  std::int64_t rejected{};  ///< Of these: of another type, cut off, over-long.
  std::string last_rejected;
  std::optional<double> status_age;  ///< Since the last STATUS [s of wall time].
};

/// Hears a mission from outside, by LCM alone, and keeps its story. Every message is checked before
/// it is used.
/// Threading: heard() from any thread.
class Listener {
 public:
  /// Hears what `lcm` handles from now on. Both must outlive this.
  Listener(lcm::LCM* lcm, Story* story);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  Heard heard() const;

 private:
  void Receive(const lcm::ReceiveBuffer* buffer, const std::string& channel);

  lcm::LCM* lcm_;
  lcm::Subscription* subscription_;
  Story* story_;
  mutable std::mutex mutex_;  // of all that follows
  Heard heard_;
  std::optional<Stopwatch> since_status_;
};

}  // namespace secondlook::apps

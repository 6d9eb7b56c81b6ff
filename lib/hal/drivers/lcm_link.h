#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "lib/transport/lcm_bus.h"

namespace secondlook::hal {

/// The LCM network that devices are on, and a thread that hands on what comes in from it as soon as
/// it does, so that nothing grows old in a queue while the robot thinks.
/// Threading: any, but no handler may call Listen().
class LcmLink {
 public:
  /// @throws ConfigError for a URL that LCM does not take; DeviceError for a network that cannot be
  /// reached, with what to do about it.
  explicit LcmLink(const std::string& url);
  ~LcmLink();
  LcmLink(const LcmLink&) = delete;
  LcmLink& operator=(const LcmLink&) = delete;

  const std::string& url() const { return url_; }

  /// As LcmBus has it. A handler is called for as long as the link lives, by its thread.
  void Listen(const std::string& channel, transport::Intake intake,
              transport::LcmBus::Handler handler);

  /// False when it could not be sent.
  bool Publish(const transport::Message& message) { return bus_.Publish(message); }

 private:
  void RequireReachable() const;
  void Run();

  const std::string url_;
  transport::LcmBus bus_;
  std::mutex handling_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace secondlook::hal

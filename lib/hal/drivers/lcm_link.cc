#include "lib/hal/drivers/lcm_link.h"

#include <utility>

#include <poll.h>

#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

constexpr int kWakeMs = 20;  // to see whether there is more to do

}  // namespace

LcmLink::LcmLink(const std::string& url) : url_(url), bus_(url) {
  RequireReachable();
  thread_ = std::thread([this] { Run(); });
}

LcmLink::~LcmLink() {
  quit_ = true;
  thread_.join();
}

void LcmLink::Listen(const std::string& channel, transport::Intake intake,
                     transport::LcmBus::Handler handler) {
  const std::scoped_lock lock(handling_);
  bus_.Listen(channel, std::move(intake), std::move(handler));
  RequireReachable();
}

void LcmLink::RequireReachable() const {
  if (bus_.unreachable().empty()) return;
  Throw<DeviceError>("LCM network {}: {}", url_, bus_.unreachable());
}

void LcmLink::Run() {
  pollfd arrival{bus_.fileno(), POLLIN, 0};
  while (!quit_) {
    if (poll(&arrival, 1, kWakeMs) <= 0) continue;
    const std::scoped_lock lock(handling_);
    bus_.Handle();
  }
}

}  // namespace secondlook::hal

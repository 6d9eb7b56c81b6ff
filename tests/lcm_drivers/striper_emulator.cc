#include "tests/lcm_drivers/striper_emulator.h"

#include <chrono>
#include <utility>

#include "lib/hal/drivers/sender_time.h"
#include "lib/transport/channels.h"

#include "second_look/striper_command_t.hpp"
#include "second_look/striper_status_t.hpp"

namespace secondlook::hal {

using second_look::striper_command_t;
using second_look::striper_line_t;
using second_look::striper_status_t;
namespace channel = transport::channel;

StriperEmulator::StriperEmulator(LcmLink* link, int points) : link_(link), points_(points) {
  link_->Listen(channel::kStriperCommand, {"second_look.striper_command_t", {}},
                [this](const auto& message) {
                  const auto command = transport::Decode<striper_command_t>(message);
                  const std::scoped_lock lock(mutex_);
                  lit_until_ = command.on ? clock_.Now() + Seconds(command.valid_seconds) : Time{};
                });
  thread_ = std::thread([this] { Run(); });
}

StriperEmulator::~StriperEmulator() {
  quit_ = true;
  thread_.join();
}

bool StriperEmulator::lit() const {
  const std::scoped_lock lock(mutex_);
  return clock_.Now() < lit_until_;
}

void StriperEmulator::SetFault(const std::string& fault) {
  const std::scoped_lock lock(mutex_);
  fault_ = fault;
}

void StriperEmulator::Spoil(std::function<void(striper_line_t*)> spoil) {
  const std::scoped_lock lock(mutex_);
  spoil_ = std::move(spoil);
}

void StriperEmulator::SendLine() {
  striper_line_t line{};
  line.utime = Microseconds(clock_.Now());
  line.ranges.assign(static_cast<std::size_t>(points_), 0.4F);
  line.ranges[0] = 0.0F;
  line.ranges[1] = 0.1F;
  line.num_ranges = points_;
  {
    const std::scoped_lock lock(mutex_);
    line.sequence = ++sequence_;
    if (spoil_) spoil_(&line);
  }
  if (losing_ > 0) {
    --losing_;
    return;
  }
  link_->Publish(transport::Pack(channel::kStriperLine, line));
}

void StriperEmulator::Run() {
  while (!quit_) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (silent_) continue;
    if (lit()) SendLine();
    striper_status_t status{};
    status.utime = Microseconds(clock_.Now());
    status.on = lit() ? 1 : 0;
    {
      const std::scoped_lock lock(mutex_);
      status.fault = fault_;
    }
    link_->Publish(transport::Pack(channel::kStriperStatus, status));
  }
}

}  // namespace secondlook::hal

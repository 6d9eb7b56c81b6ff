#include "lib/hal/drivers/lcm_striper.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <numbers>
#include <optional>
#include <utility>

#include <spdlog/spdlog.h>

#include "lib/common/bounded_queue.h"
#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/hal/drivers/sender_time.h"
#include "lib/transport/channels.h"

#include "second_look/striper_command_t.hpp"
#include "second_look/striper_line_t.hpp"
#include "second_look/striper_status_t.hpp"

namespace secondlook::hal {
namespace {

using second_look::striper_command_t;
using second_look::striper_line_t;
using second_look::striper_status_t;
namespace channel = transport::channel;

constexpr Duration kRenew = Seconds(0.1);  // of the command that it is to be on
constexpr int kQueue = 64;

}  // namespace

/// Takes what comes in. Threading: any.
class LcmStriper::Inbox {
 public:
  Inbox(const LcmStriperConfig& config, const Clock* clock)
      : config_(config),
        clock_(clock),
        sender_time_(config.synchronised, Seconds(config.patience_seconds),
                     Seconds(config.latency_seconds)),
        lines_(config.held) {}

  void ReceiveStatus(const transport::Message& message) {
    auto status = transport::Decode<striper_status_t>(message);
    const std::scoped_lock lock(mutex_);
    device_fault_ = std::move(status.fault);
    status_at_ = clock_->Now();
    heard_ = true;
    came_.notify_all();
  }

  /// @throws ProtocolError for a line that is none.
  void ReceiveLine(const transport::Message& message) {
    const Time arrival = clock_->Now();
    const auto line = transport::Decode<striper_line_t>(message);
    if (line.num_ranges != config_.points) {
      Throw<ProtocolError>("a line has {} ranges, and 'points' says {}: make the two equal",
                           line.num_ranges, config_.points);
    }
    const Time time = sender_time_.Of(StampOf(line.utime), arrival);
    const std::scoped_lock lock(mutex_);
    if (!wanted_ || time < wanted_since_) return;
    if (time <= last_time_) {
      Throw<ProtocolError>("its stamps do not advance: is it stuck, or sent by two senders?");
    }
    // A count that runs backwards is that of a device which began anew.
    const bool follows = last_device_sequence_ >= 0 && line.sequence > last_device_sequence_;
    const std::int64_t step = follows ? line.sequence - last_device_sequence_ : 1;
    last_device_sequence_ = line.sequence;
    last_time_ = time;
    sequence_ += static_cast<std::uint64_t>(step);
    missed_ += static_cast<std::uint64_t>(step - 1);
    line_at_ = arrival;
    rejected_.clear();
    lines_.Push({time, sequence_, Ranges(line)});
  }

  void Reject(const std::string& why) {
    const std::scoped_lock lock(mutex_);
    rejected_ = why;
  }

  /// Lines from now on are wanted.
  void Want(Time now) {
    const std::scoped_lock lock(mutex_);
    wanted_ = true;
    wanted_since_ = now;
  }

  void WaitForStatus(Duration timeout) {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, timeout, [&] { return heard_; });
  }

  std::vector<ScanLine> Take() { return lines_.TakeAll(); }

  std::uint64_t lost() const {
    const std::scoped_lock lock(mutex_);
    return missed_ + lines_.dropped();
  }

  /// Why it is of no use; empty when it is. @param on_since When it was switched on; empty: it is
  /// off and need not send lines.
  std::string Trouble(const std::optional<Time>& on_since, const std::string& url) const {
    const std::scoped_lock lock(mutex_);
    const Time oldest = clock_->Now() - Seconds(config_.patience_seconds);
    if (!heard_ || status_at_ < oldest) {
      return fmt::format(
          "nothing came on channel '{}' of {} for {} s: is its driver running, and does it send "
          "there? `lcm-spy` shows what is sent{}",
          channel::kStriperStatus, url, config_.patience_seconds, Because());
    }
    if (!device_fault_.empty()) return "it cannot measure: " + device_fault_;
    if (on_since && std::max(*on_since, line_at_) < oldest) {
      return fmt::format("it is on, and no good line came on channel '{}' of {} for {} s{}",
                         channel::kStriperLine, url, config_.patience_seconds, Because());
    }
    return "";
  }

 private:
  std::vector<float> Ranges(const striper_line_t& line) const {
    std::vector<float> ranges = line.ranges;
    for (float& range : ranges) {
      if (!(range >= config_.min_range && range <= config_.max_range)) {
        range = std::numeric_limits<float>::quiet_NaN();
      }
    }
    return ranges;
  }

  std::string Because() const { return rejected_.empty() ? "" : ": " + rejected_; }

  const LcmStriperConfig config_;
  const Clock* clock_;
  SenderTime sender_time_;  // of the link's thread
  BoundedQueue<ScanLine> lines_;
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable came_;
  bool heard_{};
  Time status_at_{};
  std::string device_fault_;
  bool wanted_{};
  Time wanted_since_{};
  Time last_time_{};
  Time line_at_{};
  std::int64_t last_device_sequence_{-1};
  std::uint64_t sequence_{};
  std::uint64_t missed_{};
  std::string rejected_;
};

void LcmStriperConfig::Validate() const {
  if (name.empty()) Throw<ConfigError>("'name' is empty: messages call the striper by it");
  CheckRange(points, 2, 10'000, "'points'");
  CheckRange(field_of_view_deg, 0.1, 170.0, "'field_of_view_deg'");
  CheckRange(min_range, 0.001, 60.0, "'min_range'");
  CheckRange(max_range, min_range, 65.0, "'max_range'");
  CheckRange(lines_per_second, 0.1, 10'000.0, "'lines_per_second'");
  CheckRange(range_sigma, 1e-7, 1.0, "'range_sigma'");
  CheckRange(held, 1, 100'000, "'held'");
  CheckRange(patience_seconds, 0.1, 60.0, "'patience_seconds'");
  CheckRange(latency_seconds, 0.0, 1.0, "'latency_seconds'");
}

LcmStriper::LcmStriper(const LcmStriperConfig& config, std::shared_ptr<LcmLink> link,
                       const Clock* clock)
    : config_(config), link_(std::move(link)), clock_(clock) {
  config_.Validate();
  info_ = {
      config_.name,       config_.points,    config_.field_of_view_deg / 180.0 * std::numbers::pi,
      config_.min_range,  config_.max_range, config_.lines_per_second,
      config_.range_sigma};
  inbox_ = std::make_shared<Inbox>(config_, clock_);
  const auto intake = [inbox = inbox_](const char* on) {
    return transport::Intake{
        std::string(transport::TypeOn(on)), {}, kQueue, [inbox](const std::string& why) {
          inbox->Reject(why);
        }};
  };
  transport::Intake lines = intake(channel::kStriperLine);
  lines.limits.values = config_.points;
  lines.limits.bytes = 4 * static_cast<std::size_t>(config_.points) + 64;
  link_->Listen(channel::kStriperStatus, intake(channel::kStriperStatus),
                [inbox = inbox_](const auto& message) { inbox->ReceiveStatus(message); });
  link_->Listen(channel::kStriperLine, std::move(lines),
                [inbox = inbox_](const auto& message) { inbox->ReceiveLine(message); });
  inbox_->WaitForStatus(Seconds(config_.patience_seconds));
  RequireThere();
}

LcmStriper::~LcmStriper() { Off(); }

void LcmStriper::On() {
  RequireThere();
  on_since_ = clock_->Now();
  attended_until_ = on_since_ + kAttended;
  inbox_->Want(on_since_);
  on_ = true;
  Command(true);
}

void LcmStriper::Off() noexcept try {
  on_ = false;
  Command(false);
} catch (const std::exception& error) {
  spdlog::error("striper '{}': cannot be told to go off, its light lapses in {} s: {}", info_.name,
                ToSeconds(kAttended), error.what());
}

std::vector<ScanLine> LcmStriper::Take() {
  const Time now = clock_->Now();
  if (now > attended_until_) on_ = false;
  attended_until_ = now + kAttended;
  RequireThere();
  if (on_ && now - commanded_ >= kRenew) Command(true);
  return inbox_->Take();
}

std::uint64_t LcmStriper::lost() const { return inbox_->lost(); }

void LcmStriper::Command(bool on) {
  striper_command_t command{};
  const Time now = clock_->Now();
  if (on) commanded_ = now;
  command.utime = Microseconds(now);
  command.on = on ? 1 : 0;
  command.valid_seconds = ToSeconds(kAttended);
  link_->Publish(transport::Pack(channel::kStriperCommand, command));
}

void LcmStriper::RequireThere() const {
  const std::string trouble =
      inbox_->Trouble(on_ ? std::optional(on_since_) : std::nullopt, link_->url());
  if (!trouble.empty()) Throw<DeviceError>("striper '{}': {}", info_.name, trouble);
}

}  // namespace secondlook::hal

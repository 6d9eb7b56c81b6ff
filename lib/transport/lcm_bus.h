#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "lib/transport/message.h"
#include "lib/transport/message_json.h"

struct _lcm_t;

namespace secondlook::transport {

/// This machine alone (ttl=0), with room for a burst of what comes in.
inline constexpr const char* kDefaultLcmUrl =
    "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=8388608";

/// True when what is sent to `url` leaves this machine: its ttl is not 0, which is LCM's default.
bool ReachesBeyondThisHost(std::string_view url);

/// What has gone over a bus so far.
struct BusCounts {
  std::int64_t sent{};
  std::int64_t send_failures{};
  std::int64_t received{};    ///< On the channels that are listened to.
  std::int64_t rejected{};    ///< Of these, not acted on.
  std::string last_rejected;  ///< Its channel and why; empty: none was.
};

/// What is let in on a channel.
struct Intake {
  std::string type;  ///< As messages/ names it.
  Limits limits;
  int queue{1'000};  ///< LCM keeps at most so many messages until Handle() comes for them.
  /// Is told why a message was rejected; may be empty.
  std::function<void(const std::string& why)> on_reject{};
};

/// One LCM network: messages out, and in on the channels that are listened to. What comes in is
/// checked against the schema and `Limits` before anybody sees it, so it can be given to lcm-gen's
/// decoder.
///
/// What LCM loses because a channel's queue is full nobody can count.
/// Threading: Publish(), Reject() and counts() from any thread, the rest from one.
class LcmBus {
 public:
  using Handler = std::function<void(const Message&)>;

  static constexpr int kQueue = 1'000;  ///< Of our own channels.

  /// @param url `udpm://ADDRESS:PORT?…`, or `memq://`: this object alone, for tests. LCM's other
  ///     providers can make their caller wait.
  /// @throws ConfigError for another URL, or one that LCM does not take. A machine without a route
  /// for multicast is no error: see unreachable().
  explicit LcmBus(const std::string& url);
  ~LcmBus();
  LcmBus(const LcmBus&) = delete;
  LcmBus& operator=(const LcmBus&) = delete;

  /// Why nobody outside can listen or speak, and what to do about it; empty when they can.
  const std::string& unreachable() const { return unreachable_; }

  /// Hands to `handler`, from Handle(), what comes in on `channel`, one of Channels(). An Error
  /// that `handler` throws rejects the message.
  void Listen(const std::string& channel, Handler handler);

  /// Likewise what comes in on any `channel` and keeps to `intake`.
  /// @throws InvalidArgument when there is no such type.
  void Listen(const std::string& channel, Intake intake, Handler handler);

  /// False when it could not be sent.
  bool Publish(const Message& message);

  /// Hands on what has come in, at most kQueue messages, and returns at once.
  void Handle();

  /// Can be polled for reading: something has come in. -1: nothing ever will.
  int fileno() const;

  /// Counts a message that was received, but not acted on.
  void Reject(const std::string& channel, const std::string& why);

  BusCounts counts() const;

 private:
  struct Subscription {
    LcmBus* bus{};
    std::string channel;
    Intake intake;
    Handler handler;
  };
  struct Destroy {
    void operator()(_lcm_t* lcm) const;
  };

  void Receive(const Subscription& subscription, const std::uint8_t* data, std::size_t size);

  std::unique_ptr<_lcm_t, Destroy> lcm_;  ///< Null when unreachable.
  std::string unreachable_;
  std::deque<Subscription> subscriptions_;  ///< LCM holds on to them where they are.
  mutable std::mutex mutex_;                ///< Of counts_.
  BusCounts counts_;
};

}  // namespace secondlook::transport

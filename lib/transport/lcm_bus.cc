#include "lib/transport/lcm_bus.h"

#include <arpa/inet.h>
#include <lcm/lcm.h>
#include <sys/socket.h>
#include <unistd.h>

#include <exception>
#include <span>
#include <utility>

#include "lib/common/error.h"
#include "lib/transport/channels.h"

namespace secondlook::transport {
namespace {

constexpr std::string_view kMulticast = "udpm://";
constexpr std::string_view kMemory = "memq://";

/// True when the system has a route to the multicast group of `url`. LCM would ask the same way,
/// but complains at length on standard error.
bool HasRoute(std::string_view url) {
  std::string_view group = url.substr(kMulticast.size());
  group = group.substr(0, group.find_first_of(":?"));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);
  if (inet_pton(AF_INET, std::string(group.empty() ? "239.255.76.67" : group).c_str(),
                &address.sin_addr) != 1) {
    return true;  // for LCM to refuse
  }
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return true;
  const bool connected =
      connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  close(probe);
  return connected;
}

/// All messages of channels.h begin with their utime, after the fingerprint.
std::int64_t UtimeOf(std::span<const std::uint8_t> bytes) {
  std::uint64_t utime = 0;
  for (const std::uint8_t byte : bytes.subspan(8, 8)) utime = utime << 8 | byte;
  return static_cast<std::int64_t>(utime);
}

}  // namespace

bool ReachesBeyondThisHost(std::string_view url) {
  const std::size_t ttl = url.find("ttl=");
  if (ttl == std::string_view::npos) return false;
  const std::string_view value = url.substr(ttl + 4);
  return value.substr(0, value.find_first_not_of("0123456789")).find_first_not_of('0') !=
         std::string_view::npos;
}

void LcmBus::Destroy::operator()(_lcm_t* lcm) const { lcm_destroy(lcm); }

LcmBus::LcmBus(const std::string& url) {
  const bool multicast = url.starts_with(kMulticast);
  if (!multicast && !url.starts_with(kMemory)) {
    Throw<ConfigError>("LCM URL '{}': it must begin with {} or {}, e.g. {}", url, kMulticast,
                       kMemory, kDefaultLcmUrl);
  }
  if (multicast && !HasRoute(url)) {
    unreachable_ =
        "this machine has no route for multicast; `ip route add 224.0.0.0/4 dev lo` adds one "
        "for listeners on the machine itself";
    return;
  }
  lcm_.reset(lcm_create(url.c_str()));
  if (!lcm_) Throw<ConfigError>("LCM URL '{}': LCM does not take it, see above", url);
}

LcmBus::~LcmBus() = default;

void LcmBus::Listen(const std::string& channel, Handler handler) {
  if (TypeOn(channel).empty()) Throw<InvalidArgument>("'{}' is no channel of ours", channel);
  Listen(channel, Intake{std::string(TypeOn(channel)), {}}, std::move(handler));
}

void LcmBus::Listen(const std::string& channel, Intake intake, Handler handler) {
  static_cast<void>(Schema::Messages().Of(intake.type));
  if (!lcm_) return;
  Subscription& subscription = subscriptions_.emplace_back(
      Subscription{this, channel, std::move(intake), std::move(handler)});
  const auto receive = [](const lcm_recv_buf_t* message, const char*, void* user) {
    const auto* to = static_cast<const Subscription*>(user);
    to->bus->Receive(*to, static_cast<const std::uint8_t*>(message->data), message->data_size);
  };
  lcm_subscription_t* taken = lcm_subscribe(lcm_.get(), channel.c_str(), receive, &subscription);
  if (taken == nullptr) {
    unreachable_ =
        "multicast does not come back to this machine; check its firewall, and that 224.0.0.0/4 "
        "is routed to an interface that can multicast";
    lcm_.reset();
    return;
  }
  lcm_subscription_set_queue_capacity(taken, subscription.intake.queue);
}

bool LcmBus::Publish(const Message& message) {
  const bool sent = lcm_ && lcm_publish(lcm_.get(), message.channel.c_str(), message.bytes.data(),
                                        static_cast<unsigned int>(message.bytes.size())) == 0;
  const std::scoped_lock lock(mutex_);
  ++(sent ? counts_.sent : counts_.send_failures);
  return sent;
}

void LcmBus::Handle() {
  if (!lcm_) return;
  for (int i = 0; i < kQueue && lcm_handle_timeout(lcm_.get(), 0) > 0; ++i) {
  }
}

int LcmBus::fileno() const { return lcm_ ? lcm_get_fileno(lcm_.get()) : -1; }

void LcmBus::Receive(const Subscription& subscription, const std::uint8_t* data,
                     std::size_t size) try {
  {
    const std::scoped_lock lock(mutex_);
    ++counts_.received;
  }
  const std::span bytes(data, size);
  Check(bytes, subscription.intake.type, subscription.intake.limits);
  subscription.handler({subscription.channel, UtimeOf(bytes), {bytes.begin(), bytes.end()}});
} catch (const std::exception& error) {  // none may pass through LCM, which is C
  Reject(subscription.channel, error.what());
  if (subscription.intake.on_reject) subscription.intake.on_reject(error.what());
}

void LcmBus::Reject(const std::string& channel, const std::string& why) {
  const std::scoped_lock lock(mutex_);
  ++counts_.rejected;
  counts_.last_rejected = channel + ": " + why;
}

BusCounts LcmBus::counts() const {
  const std::scoped_lock lock(mutex_);
  return counts_;
}

}  // namespace secondlook::transport

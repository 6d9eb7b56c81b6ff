#include "apps/listener.h"

#include <fmt/format.h>

#include "lib/common/error.h"
#include "lib/transport/channels.h"

namespace secondlook::apps {
namespace {

/// So many messages wait in LCM's queue when a step tells all it has at once.
constexpr int kQueue = 1'000;

}  // namespace

Listener::Listener(lcm::LCM* lcm, Story* story)
    : lcm_(lcm),
      subscription_(lcm->subscribe("SECONDLOOK_.*", &Listener::Receive, this)),
      story_(story) {
  subscription_->setQueueCapacity(kQueue);
}

Listener::~Listener() { lcm_->unsubscribe(subscription_); }

Heard Listener::heard() const {
  const std::scoped_lock lock(mutex_);
  Heard heard = heard_;
  if (since_status_) heard.status_age = since_status_->Seconds();
  return heard;
}

void Listener::Receive(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
  std::string fault;
  try {
    if (transport::TypeOn(channel).empty()) Throw<ProtocolError>("no such channel");
    if (buffer->data_size > transport::kMaxMessageBytes) {
      Throw<ProtocolError>("{} bytes; at most {} are right", buffer->data_size,
                           transport::kMaxMessageBytes);
    }
    const auto* data = static_cast<const std::uint8_t*>(buffer->data);
    story_->Post({channel, buffer->recv_utime, {data, data + buffer->data_size}});
  } catch (const Error& error) {
    fault = fmt::format("{}: {}", channel, error.what());
  }
  const std::scoped_lock lock(mutex_);
  ++heard_.messages;
  if (!fault.empty()) {
    ++heard_.rejected;
    heard_.last_rejected = fault;
  } else if (channel == transport::channel::kStatus) {
    since_status_.emplace();
  }
}

}  // namespace secondlook::apps

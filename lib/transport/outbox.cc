#include "lib/transport/outbox.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "lib/transport/channels.h"

namespace secondlook::transport {
namespace {

/// The channels that can be missed, those that matter least first.
constexpr std::array<std::string_view, 5> kExpendable{
    channel::kImage, channel::kNavStatus, channel::kTiming, channel::kView, channel::kCandidates};

auto Worth(const Message& message) {
  return std::find(kExpendable.begin(), kExpendable.end(), message.channel) - kExpendable.begin();
}

}  // namespace

void Outbox::Post(const Message& message) {
  const std::scoped_lock lock(mutex_);
  messages_.push_back(message);
  bytes_ += message.bytes.size();
  while (bytes_ > capacity_) MakeRoom();
}

void Outbox::MakeRoom() {
  const auto less = [](const Message& a, const Message& b) { return Worth(a) < Worth(b); };
  const auto least = std::min_element(messages_.begin(), messages_.end(), less);  // the oldest
  bytes_ -= least->bytes.size();
  messages_.erase(least);
  ++drops_;
}

std::optional<Message> Outbox::Take() {
  const std::scoped_lock lock(mutex_);
  if (messages_.empty()) return std::nullopt;
  Message message = std::move(messages_.front());
  messages_.pop_front();
  bytes_ -= message.bytes.size();
  return message;
}

bool Outbox::Empty() const {
  const std::scoped_lock lock(mutex_);
  return messages_.empty();
}

std::int64_t Outbox::drops() const {
  const std::scoped_lock lock(mutex_);
  return drops_;
}

}  // namespace secondlook::transport

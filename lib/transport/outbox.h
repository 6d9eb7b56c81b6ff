#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>

#include "lib/transport/message.h"

namespace secondlook::transport {

/// Messages on their way out, in the order they came. When there is no more room, the oldest of
/// those that matter least is dropped: images first, then how far the way is and where the time
/// went, then views and candidates, and last what is believed and decided. The map's changes count
/// with these, as nobody tells them again.
/// Threading: any.
class Outbox : public Sink {
 public:
  /// `capacity`: the bytes of all messages that wait.
  explicit Outbox(std::size_t capacity) : capacity_(capacity) {}

  void Post(const Message& message) override;

  /// The next one; empty when none waits.
  std::optional<Message> Take();

  bool Empty() const;
  /// How many were dropped so far.
  std::int64_t drops() const;

 private:
  void MakeRoom();

  std::size_t capacity_;
  mutable std::mutex mutex_;
  std::deque<Message> messages_;
  std::size_t bytes_{};
  std::int64_t drops_{};
};

}  // namespace secondlook::transport

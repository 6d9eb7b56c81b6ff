#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <iterator>
#include <mutex>
#include <utility>
#include <vector>

#include "lib/common/error.h"

namespace secondlook {

/// Hands values from one thread to another, each of them or a count: when nobody comes for them and
/// it is full, the oldest gives way. Threading: any.
template <class T>
class BoundedQueue {
 public:
  /// @throws InvalidArgument unless `capacity` > 0.
  explicit BoundedQueue(int capacity) : capacity_(static_cast<std::size_t>(capacity)) {
    if (capacity <= 0) Throw<InvalidArgument>("a queue for {} values; it must hold one", capacity);
  }

  void Push(T value) {
    const std::scoped_lock lock(mutex_);
    if (values_.size() == capacity_) {
      values_.pop_front();
      ++dropped_;
    }
    values_.push_back(std::move(value));
  }

  /// All that is there, oldest first.
  std::vector<T> TakeAll() {
    const std::scoped_lock lock(mutex_);
    std::vector<T> values(std::make_move_iterator(values_.begin()),
                          std::make_move_iterator(values_.end()));
    values_.clear();
    return values;
  }

  /// How many have given way so far.
  std::uint64_t dropped() const {
    const std::scoped_lock lock(mutex_);
    return dropped_;
  }

 private:
  const std::size_t capacity_;
  mutable std::mutex mutex_;  // of what follows
  std::deque<T> values_;
  std::uint64_t dropped_{};
};

}  // namespace secondlook

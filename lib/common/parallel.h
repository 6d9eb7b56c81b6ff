#pragma once

#include <functional>

namespace secondlook {

/// Calls `body(i)` for every i in [0, count), on up to as many threads as the ThreadLimit in force
/// allows. Each call may write only to what belongs to its own i; then the result is the same for
/// any number of threads. An exception thrown by a body is thrown again here.
void ParallelFor(int count, const std::function<void(int)>& body);

/// The most threads that ParallelFor uses while the returned object lives. @pre threads >= 1.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  void* control_;
};

}  // namespace secondlook

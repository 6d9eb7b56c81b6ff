#pragma once

#include <chrono>

namespace secondlook {

/// Measures how long something truly takes, for reports alone: no decision may depend on it.
class Stopwatch {
 public:
  /// Wall time since this was made [s].
  double Seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
};

}  // namespace secondlook

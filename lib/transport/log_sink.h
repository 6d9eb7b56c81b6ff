#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

#include "lib/transport/event_log.h"
#include "lib/transport/message.h"

namespace secondlook::transport {

/// Writes every message it is given into a log, in the order in which they came. The writing is
/// done by a thread of its own, so that a slow disk keeps nobody waiting. When the disk is full or
/// takes less than comes, the recording ends where it is, is said to have ended, and the rest is
/// dropped: a log never has a gap.
///
/// The times in the log are those of the newest recorded input (a REC_ channel), so that the log of
/// a simulated mission depends on the mission alone.
/// Threading: any thread.
class LogSink : public Sink {
 public:
  /// Begins the log. @throws ConfigError as EventLogWriter does.
  LogSink(const std::filesystem::path& file, std::int64_t part_bytes);
  /// Writes what waits.
  ~LogSink() override;

  void Post(const Message& message) override;

  /// Writes what waits and ends the recording. What comes later is dropped.
  void Close();

  /// The part that is being written, or why the recording has ended.
  std::string state() const;

  /// Why the recording ended before it was closed; empty when it didn't.
  std::string failure() const;

 private:
  struct Entry {
    std::int64_t utime{};
    Message message;
  };

  void Run();
  void Fail(const std::string& reason);

  EventLogWriter writer_;  // of the thread
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Entry> queue_;
  std::size_t waiting_bytes_{};
  std::int64_t utime_{};
  std::string part_;
  std::string failure_;
  bool closing_{};
  std::thread thread_;
};

}  // namespace secondlook::transport

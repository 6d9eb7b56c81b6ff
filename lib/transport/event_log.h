#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace secondlook::transport {

// LCM's log format, as lcm-logger writes it and lcm-logplayer reads it. Each event is, with numbers
// big-endian: the word 0xEDA1DA01, its number (int64), its time (int64 [us]), the length of its
// channel's name (int32) and of its data (int32), the name, the data. LCM's own functions neither
// say where a file is damaged nor bound what they allocate for it, and buffer what they write.

/// A message in a log.
struct LogEvent {
  std::int64_t utime{};  ///< When it was logged [us].
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

/// Part `i` of the log `file`: the file itself, then FILE.01, FILE.02, …
std::filesystem::path LogPart(const std::filesystem::path& file, int i);

/// Writes a log. Each event is handed to the system whole, so that it is in the file even when the
/// process is killed right after.
class EventLogWriter {
 public:
  /// Begins `file` anew, and removes the further parts that an earlier log may have left. A part
  /// that would be longer than `part_bytes` [bytes] is ended and the next one begun.
  /// @throws ConfigError naming the file and the system's reason.
  EventLogWriter(const std::filesystem::path& file, std::int64_t part_bytes);
  ~EventLogWriter();
  EventLogWriter(const EventLogWriter&) = delete;
  EventLogWriter& operator=(const EventLogWriter&) = delete;

  /// @throws DeviceError naming the file and the system's reason; what was written of the event is
  /// taken back. @pre `channel` has at most 63 bytes.
  void Write(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> bytes);

  /// The part that is being written.
  std::filesystem::path part() const { return LogPart(file_, part_); }

 private:
  void Open();

  std::filesystem::path file_;
  std::int64_t part_bytes_;
  int part_{};
  int descriptor_{-1};
  std::int64_t size_{};    // of this part [bytes]
  std::int64_t number_{};  // of the next event, through all parts
};

/// What of a log is no whole event.
struct LogDamage {
  int places{};                  ///< Where something between whole events is not one.
  std::int64_t bytes{};          ///< Skipped there.
  std::int64_t cut_off_bytes{};  ///< Of an event that the end of the log has cut off.
};

/// Reads a log and its further parts, whatever their bytes are.
class EventLogReader {
 public:
  /// @throws ConfigError naming the file when it cannot be read.
  explicit EventLogReader(const std::filesystem::path& file);
  ~EventLogReader();
  EventLogReader(const EventLogReader&) = delete;
  EventLogReader& operator=(const EventLogReader&) = delete;

  /// The next whole event; empty at the end. What is damaged is skipped.
  std::optional<LogEvent> Next();

  /// Of what was read so far.
  const LogDamage& damage() const { return damage_; }

 private:
  bool Open(int part);
  bool ReadAt(std::int64_t at, std::span<std::uint8_t> bytes) const;
  std::optional<LogEvent> ReadEvent(std::int64_t* length);
  void SkipDamage();

  std::filesystem::path file_;
  int part_{};
  int descriptor_{-1};
  std::int64_t size_{};  // of this part [bytes]
  std::int64_t at_{};    // of the next event in it
  LogDamage damage_;
};

}  // namespace secondlook::transport

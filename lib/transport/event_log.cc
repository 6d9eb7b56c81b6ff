#include "lib/transport/event_log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "lib/common/error.h"

namespace secondlook::transport {
namespace {

constexpr std::uint32_t kSync = 0xEDA1DA01;
constexpr std::size_t kHeaderBytes = 28;
/// A longer name is none of LCM's.
constexpr std::int32_t kMaxChannelBytes = 63;
constexpr std::array<std::uint8_t, 4> kSyncBytes{0xED, 0xA1, 0xDA, 0x01};

template <class T>
void Put(T value, std::vector<std::uint8_t>* bytes) {
  for (int shift = 8 * (sizeof(T) - 1); shift >= 0; shift -= 8) {
    bytes->push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> shift));
  }
}

template <class T>
T Get(const std::uint8_t* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = value << 8 | bytes[i];
  return static_cast<T>(value);
}

/// The reason of the system's for the last failure.
std::string Reason() { return std::strerror(errno); }

/// True when all of `bytes` could be written.
bool WriteAll(int descriptor, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

std::filesystem::path LogPart(const std::filesystem::path& file, int i) {
  if (i == 0) return file;
  return file.string() + fmt::format(".{:02}", i);
}

EventLogWriter::EventLogWriter(const std::filesystem::path& file, std::int64_t part_bytes)
    : file_(file), part_bytes_(part_bytes) {
  std::error_code ignored;
  std::filesystem::create_directories(file_.parent_path(), ignored);  // opening it will say why
  for (int i = 1; std::filesystem::remove(LogPart(file_, i), ignored); ++i) {
  }
  try {
    Open();
  } catch (const DeviceError& error) {
    throw ConfigError(error.what());
  }
}

EventLogWriter::~EventLogWriter() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void EventLogWriter::Open() {
  if (descriptor_ >= 0) ::close(descriptor_);
  size_ = 0;
  descriptor_ = ::open(part().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor_ < 0) Throw<DeviceError>("{}: cannot be written: {}", part().string(), Reason());
}

void EventLogWriter::Write(std::int64_t utime, const std::string& channel,
                           std::span<const std::uint8_t> bytes) {
  std::vector<std::uint8_t> event;
  event.reserve(kHeaderBytes + channel.size() + bytes.size());
  Put(kSync, &event);
  Put(number_, &event);
  Put(utime, &event);
  Put(static_cast<std::int32_t>(channel.size()), &event);
  Put(static_cast<std::int32_t>(bytes.size()), &event);
  event.insert(event.end(), channel.begin(), channel.end());
  event.insert(event.end(), bytes.begin(), bytes.end());
  const auto length = static_cast<std::int64_t>(event.size());
  if (size_ > 0 && size_ + length > part_bytes_) {
    ++part_;
    Open();
  }
  if (!WriteAll(descriptor_, event)) {
    const std::string reason = Reason();
    [[maybe_unused]] const int kept = ::ftruncate(descriptor_, size_);  // a device has no length
    Throw<DeviceError>("{}: cannot be written: {}", part().string(), reason);
  }
  size_ += length;
  ++number_;
}

EventLogReader::EventLogReader(const std::filesystem::path& file) : file_(file) {
  if (!Open(0)) Throw<ConfigError>("{}: cannot be read: {}", file.string(), Reason());
  if (size_ < 0) Throw<ConfigError>("{}: is no file", file.string());
}

EventLogReader::~EventLogReader() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

/// Goes to the beginning of a part. False when there is none.
bool EventLogReader::Open(int part) {
  const int descriptor = ::open(LogPart(file_, part).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = descriptor;
  struct stat status {};
  const bool regular = ::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
  size_ = regular ? status.st_size : -1;
  part_ = part;
  at_ = 0;
  return true;
}

bool EventLogReader::ReadAt(std::int64_t at, std::span<std::uint8_t> bytes) const {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(descriptor_, bytes.data(), bytes.size(), at);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    at += got;
  }
  return true;
}

std::optional<LogEvent> EventLogReader::Next() {
  while (true) {
    std::int64_t length = 0;
    if (std::optional<LogEvent> event = ReadEvent(&length)) {
      at_ += length;
      return event;
    }
    if (at_ < size_) {
      SkipDamage();
    } else if (!Open(part_ + 1)) {
      return std::nullopt;
    }
  }
}

/// The event that begins here, and how long it is; empty when there is no whole one that another
/// event or the end follows.
std::optional<LogEvent> EventLogReader::ReadEvent(std::int64_t* length) {
  std::array<std::uint8_t, kHeaderBytes> header{};
  if (at_ + static_cast<std::int64_t>(kHeaderBytes) > size_ || !ReadAt(at_, header)) return {};
  const auto channel_bytes = Get<std::int32_t>(&header[20]);
  const auto data_bytes = Get<std::int32_t>(&header[24]);
  if (Get<std::uint32_t>(header.data()) != kSync || channel_bytes < 0 ||
      channel_bytes > kMaxChannelBytes || data_bytes < 0) {
    return {};
  }
  *length = static_cast<std::int64_t>(kHeaderBytes) + channel_bytes + data_bytes;
  const std::int64_t end = at_ + *length;
  std::array<std::uint8_t, 4> next = kSyncBytes;
  if (end > size_ || (end + 4 <= size_ && !ReadAt(end, next)) || next != kSyncBytes) return {};
  LogEvent event;
  event.utime = Get<std::int64_t>(&header[12]);
  std::vector<std::uint8_t> channel(static_cast<std::size_t>(channel_bytes));
  event.bytes.resize(static_cast<std::size_t>(data_bytes));
  if (!ReadAt(end - data_bytes - channel_bytes, channel) ||
      !ReadAt(end - data_bytes, event.bytes)) {
    return {};
  }
  event.channel.assign(channel.begin(), channel.end());
  return event;
}

/// Goes on to where the next event may begin.
void EventLogReader::SkipDamage() {
  const std::int64_t begin = at_++;
  std::vector<std::uint8_t> block(65'536);
  bool found = false;
  while (!found && at_ + 4 <= size_) {
    block.resize(static_cast<std::size_t>(
        std::min<std::int64_t>(static_cast<std::int64_t>(block.size()), size_ - at_)));
    if (!ReadAt(at_, block)) break;
    const auto sync = std::search(block.begin(), block.end(), kSyncBytes.begin(), kSyncBytes.end());
    found = sync != block.end();
    at_ += found ? sync - block.begin() : static_cast<std::int64_t>(block.size()) - 3;
  }
  if (found) {
    ++damage_.places;
    damage_.bytes += at_ - begin;
  } else {
    at_ = size_;
    damage_.cut_off_bytes += size_ - begin;
  }
}

}  // namespace secondlook::transport

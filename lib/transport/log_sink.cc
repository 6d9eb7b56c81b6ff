#include "lib/transport/log_sink.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "lib/common/error.h"

namespace secondlook::transport {
namespace {

/// More than this waiting [bytes], and the disk will not catch up.
constexpr std::size_t kMaxWaitingBytes = 64'000'000;

}  // namespace

LogSink::LogSink(const std::filesystem::path& file, std::int64_t part_bytes)
    : writer_(file, part_bytes), part_(writer_.part().string()), thread_([this] { Run(); }) {}

LogSink::~LogSink() { Close(); }

void LogSink::Post(const Message& message) {
  const std::scoped_lock lock(mutex_);
  if (closing_ || !failure_.empty()) return;
  if (message.channel.starts_with("REC_")) utime_ = std::max(utime_, message.utime);
  waiting_bytes_ += message.bytes.size();
  if (waiting_bytes_ > kMaxWaitingBytes) {
    Fail(fmt::format("{}: the disk is too slow: {} MB wait to be written", part_,
                     waiting_bytes_ / 1'000'000));
    return;
  }
  queue_.push_back({utime_, message});
  wake_.notify_one();
}

void LogSink::Close() {
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;
    wake_.notify_one();
  }
  if (thread_.joinable()) thread_.join();
}

std::string LogSink::state() const {
  const std::scoped_lock lock(mutex_);
  return failure_.empty() ? part_ : "ended: " + failure_;
}

std::string LogSink::failure() const {
  const std::scoped_lock lock(mutex_);
  return failure_;
}

void LogSink::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return closing_ || !queue_.empty(); });
    if (queue_.empty()) return;
    const Entry entry = std::move(queue_.front());
    queue_.pop_front();
    waiting_bytes_ -= entry.message.bytes.size();
    lock.unlock();
    std::string reason;
    try {
      writer_.Write(entry.utime, entry.message.channel, entry.message.bytes);
    } catch (const DeviceError& error) {
      reason = error.what();
    }
    lock.lock();
    part_ = writer_.part().string();
    if (!reason.empty()) Fail(reason);
  }
}

/// With the mutex locked.
void LogSink::Fail(const std::string& reason) {
  if (!failure_.empty()) return;
  failure_ = reason;
  queue_.clear();
  waiting_bytes_ = 0;
  spdlog::warn("the recording ends here, the mission goes on: {}", reason);
}

}  // namespace secondlook::transport

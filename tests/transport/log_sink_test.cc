#include "lib/transport/log_sink.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::transport {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kNoLimit = 1'000'000'000;

std::vector<LogEvent> ReadAll(const std::filesystem::path& file) {
  std::vector<LogEvent> events;
  EventLogReader reader(file);
  while (auto event = reader.Next()) events.push_back(std::move(*event));
  return events;
}

TEST(LogSink, WritesEveryMessageInItsOrder) {
  const TemporaryFolder folder;
  {
    LogSink sink(folder / "log", kNoLimit);
    for (std::uint8_t i = 0; i < 200; ++i) sink.Post({"SECONDLOOK_VIEW", i, {i}});
    EXPECT_EQ(sink.state(), (folder / "log").string());
  }
  const std::vector<LogEvent> events = ReadAll(folder / "log");
  ASSERT_EQ(events.size(), 200U);
  for (std::uint8_t i = 0; i < 200; ++i) EXPECT_EQ(events[i].bytes, std::vector<std::uint8_t>{i});
}

TEST(LogSink, DatesEventsByTheNewestInput) {
  const TemporaryFolder folder;
  {
    LogSink sink(folder / "log", kNoLimit);
    sink.Post({"SECONDLOOK_STATUS", 1'700'000'000'000'000, {}});
    sink.Post({"REC_CLOCK", 20, {}});
    sink.Post({"SECONDLOOK_VIEW", 15, {}});
    sink.Post({"REC_CLOCK", 30, {}});
  }
  std::vector<std::int64_t> times;
  for (const LogEvent& event : ReadAll(folder / "log")) times.push_back(event.utime);
  EXPECT_EQ(times, (std::vector<std::int64_t>{0, 20, 20, 30}));
}

TEST(LogSink, TakesMessagesFromSeveralThreads) {
  const TemporaryFolder folder;
  {
    LogSink sink(folder / "log", kNoLimit);
    const auto post = [&] {
      for (int i = 0; i < 100; ++i) sink.Post({"A", 0, {1, 2, 3}});
    };
    std::thread other(post);
    post();
    other.join();
  }
  EXPECT_EQ(ReadAll(folder / "log").size(), 200U);
}

TEST(LogSink, OnAFullDiskEndsTheRecordingAndSaysSo) {
  LogSink sink("/dev/full", kNoLimit);
  sink.Post({"A", 0, {1}});
  sink.Post({"B", 0, {2}});
  sink.Close();
  EXPECT_EQ(sink.failure(), "/dev/full: cannot be written: No space left on device");
  EXPECT_EQ(sink.state(), "ended: " + sink.failure());
  sink.Post({"C", 0, {3}});  // to nobody
}

TEST(LogSink, OnADiskThatTakesNothingEndsTheRecordingAndNeverWaits) {
  const TemporaryFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  auto sink = std::make_unique<LogSink>(pipe, kNoLimit);  // nobody reads: it takes 64 kB
  const Message message{"A", 0, std::vector<std::uint8_t>(1'000'000)};
  for (int i = 0; i < 70; ++i) sink->Post(message);
  EXPECT_THAT(sink->failure(), HasSubstr("pipe: the disk is too slow: 65 MB wait to be written"));
  std::thread drain([&] {
    std::vector<char> bytes(100'000);
    pollfd end{reader, POLLIN, 0};
    while (poll(&end, 1, -1) == 1 && read(reader, bytes.data(), bytes.size()) > 0) {
    }
  });
  sink.reset();  // closes the pipe
  drain.join();
  close(reader);
}

TEST(LogSink, ThatCannotBeWrittenIsAConfigErrorAtOnce) {
  EXPECT_THROWS(LogSink("/proc/none/log", kNoLimit), ConfigError,
                "/proc/none/log: cannot be written");
}

}  // namespace
}  // namespace secondlook::transport

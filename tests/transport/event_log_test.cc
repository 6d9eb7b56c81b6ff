#include "lib/transport/event_log.h"

#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::transport {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::int64_t kNoLimit = 1'000'000'000;

/// The events are "CHANNEL_<i>" with i bytes of the value i.
void WriteEvents(const std::filesystem::path& file, int n, std::int64_t part_bytes = kNoLimit) {
  EventLogWriter writer(file, part_bytes);
  for (int i = 0; i < n; ++i) {
    writer.Write(1000 * i, "CHANNEL_" + std::to_string(i),
                 Bytes(static_cast<std::size_t>(i), static_cast<std::uint8_t>(i)));
  }
}

/// The numbers of the events that can be read; each must be as it was written.
std::vector<int> ReadEvents(EventLogReader* reader) {
  std::vector<int> numbers;
  while (const auto event = reader->Next()) {
    const int i = static_cast<int>(event->bytes.size());
    EXPECT_EQ(event->channel, "CHANNEL_" + std::to_string(i));
    EXPECT_EQ(event->utime, 1000 * i);
    EXPECT_EQ(event->bytes, Bytes(event->bytes.size(), static_cast<std::uint8_t>(i)));
    numbers.push_back(i);
  }
  return numbers;
}

/// 0, 1, …, n - 1.
std::vector<int> UpTo(int n) {
  std::vector<int> numbers;
  for (int i = 0; i < n; ++i) numbers.push_back(i);
  return numbers;
}

/// Where event i ends in the file: 28 bytes of header, the name, i bytes.
std::size_t EndOfEvent(int i) {
  std::size_t end = 0;
  for (int k = 0; k <= i; ++k) {
    end += 28 + std::string("CHANNEL_").size() + std::to_string(k).size() +
           static_cast<std::size_t>(k);
  }
  return end;
}

TEST(EventLog, IsInLcmsFormat) {
  const TemporaryFolder folder;
  {
    EventLogWriter writer(folder / "log", kNoLimit);
    writer.Write(0x0102030405060708, "AB", Bytes{0x11, 0x22, 0x33});
    writer.Write(0, "C", Bytes{});
  }
  std::string expected("\xED\xA1\xDA\x01\0\0\0\0\0\0\0\0\1\2\3\4\5\6\7\x08\0\0\0\2\0\0\0\3", 28);
  expected += "AB\x11\x22\x33";
  expected.append("\xED\xA1\xDA\x01\0\0\0\0\0\0\0\1\0\0\0\0\0\0\0\0\0\0\0\1\0\0\0\0", 28);
  expected += "C";
  EXPECT_EQ(ReadFile(folder / "log"), expected);
}

TEST(EventLog, ReturnsWhatWasWritten) {
  const TemporaryFolder folder;
  WriteEvents(folder / "log", 60);
  EventLogReader reader(folder / "log");
  EXPECT_EQ(ReadEvents(&reader), UpTo(60));
  EXPECT_EQ(reader.damage().places, 0);
  EXPECT_EQ(reader.damage().cut_off_bytes, 0);
}

TEST(EventLog, IsReadableWhileItIsBeingWritten) {
  const TemporaryFolder folder;
  EventLogWriter writer(folder / "log", kNoLimit);
  writer.Write(0, "CHANNEL_0", Bytes{});
  EventLogReader reader(folder / "log");
  EXPECT_EQ(ReadEvents(&reader), UpTo(1));
}

TEST(EventLog, ContinuesInFurtherPartsOfBoundedSize) {
  const TemporaryFolder folder;
  WriteEvents(folder / "log", 60, 1000);
  EXPECT_TRUE(std::filesystem::exists(folder / "log.01"));
  EXPECT_TRUE(std::filesystem::exists(folder / "log.02"));
  for (const auto& part : std::filesystem::directory_iterator(folder.path())) {
    EXPECT_LE(part.file_size(), 1000U) << part.path();
  }
  EventLogReader reader(folder / "log");
  EXPECT_EQ(ReadEvents(&reader), UpTo(60));
  EXPECT_EQ(reader.damage().places + reader.damage().cut_off_bytes, 0);
}

TEST(EventLog, ReplacesAnEarlierOneWithAllItsParts) {
  const TemporaryFolder folder;
  WriteEvents(folder / "log", 60, 1000);
  WriteEvents(folder / "log", 3);
  EXPECT_FALSE(std::filesystem::exists(folder / "log.01"));
  EventLogReader reader(folder / "log");
  EXPECT_EQ(ReadEvents(&reader), UpTo(3));
}

TEST(EventLog, CutOffAtAnyByteIsReadUpToTheLastWholeEvent) {
  const TemporaryFolder folder;
  WriteEvents(folder / "log", 12);
  const std::string whole = ReadFile(folder / "log");
  ASSERT_EQ(whole.size(), EndOfEvent(11));
  int events = 0;
  for (std::size_t bytes = 0; bytes <= whole.size(); ++bytes) {
    if (bytes == EndOfEvent(events)) ++events;
    WriteFile(folder / "cut", whole.substr(0, bytes));
    EventLogReader reader(folder / "cut");
    EXPECT_EQ(ReadEvents(&reader), UpTo(events)) << bytes << " bytes";
    const std::size_t rest = bytes - (events == 0 ? 0 : EndOfEvent(events - 1));
    EXPECT_EQ(reader.damage().cut_off_bytes, static_cast<std::int64_t>(rest));
    EXPECT_EQ(reader.damage().places, 0);
  }
}

TEST(EventLog, SkipsWhatIsDamagedAndCountsIt) {
  const TemporaryFolder folder;
  WriteEvents(folder / "log", 30);
  std::string damaged = ReadFile(folder / "log");
  damaged[EndOfEvent(9)] = 'x';           // the word that event 10 begins with
  damaged[EndOfEvent(19) + 24] = '\x7f';  // the length of event 20: two gigabytes
  WriteFile(folder / "log", damaged);
  EventLogReader reader(folder / "log");
  std::vector<int> expected = UpTo(30);
  // An event that no other event follows is not believed either.
  std::erase_if(expected, [](int i) { return i == 9 || i == 10 || i == 20; });
  EXPECT_EQ(ReadEvents(&reader), expected);
  EXPECT_EQ(reader.damage().places, 2);
  EXPECT_EQ(reader.damage().bytes, static_cast<std::int64_t>(EndOfEvent(10) - EndOfEvent(8) +
                                                             EndOfEvent(20) - EndOfEvent(19)));
}

TEST(EventLog, OfAnyBytesEndsAndNamesNoEventTwice) {
  const TemporaryFolder folder;
  WriteEvents(folder / "log", 40);
  const std::string whole = ReadFile(folder / "log");
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    std::string damaged = whole;
    for (int i = 0; i < 1 + trial % 20; ++i) {
      damaged[random() % damaged.size()] = static_cast<char>(random());
    }
    WriteFile(folder / "damaged", damaged);
    EventLogReader reader(folder / "damaged");
    std::int64_t bytes = 0;
    while (const auto event = reader.Next()) {
      bytes += static_cast<std::int64_t>(28 + event->channel.size() + event->bytes.size());
    }
    const LogDamage& damage = reader.damage();
    EXPECT_EQ(bytes + damage.bytes + damage.cut_off_bytes,
              static_cast<std::int64_t>(damaged.size()));
  }
}

TEST(EventLog, ThatCannotBeWrittenIsAConfigErrorNamingTheFile) {
  const TemporaryFolder folder;
  WriteFile(folder / "file", "");
  EXPECT_THROWS(EventLogWriter(folder / "file" / "log", kNoLimit), ConfigError,
                "file/log: cannot be written: Not a directory");
  EXPECT_THROWS(EventLogWriter(folder.path(), kNoLimit), ConfigError, "Is a directory");
}

TEST(EventLog, ThatCannotBeReadIsAConfigErrorNamingTheFile) {
  const TemporaryFolder folder;
  EXPECT_THROWS(EventLogReader(folder / "none"), ConfigError,
                "none: cannot be read: No such file or directory");
  EXPECT_THROWS(EventLogReader(folder.path()), ConfigError, "is no file");
}

TEST(EventLog, SaysThatTheDiskIsFull) {
  EventLogWriter writer("/dev/full", kNoLimit);
  EXPECT_THROWS(writer.Write(0, "A", Bytes{1}), DeviceError,
                "/dev/full: cannot be written: No space left on device");
}

}  // namespace
}  // namespace secondlook::transport

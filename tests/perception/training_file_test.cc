#include "lib/perception/training_file.h"

#include <cstring>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/hash.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::perception {
namespace {

using testing::HasSubstr;

/// What the log says while it lives.
class LogText {
 public:
  LogText() : before_(spdlog::default_logger()) {
    const auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(text_);
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", sink));
  }
  ~LogText() { spdlog::set_default_logger(before_); }
  LogText(const LogText&) = delete;
  LogText& operator=(const LogText&) = delete;

  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

/// A database of one cup that lies in a folder.
class TrainingFileTest : public testing::Test {
 protected:
  TrainingFileTest() {
    cup_.name = "cup";
    cup_.mesh = geometry::MakeCylinder(0.04, 0.1, 24, {0.8F, 0.3F, 0.2F});
    cup_.hash = 0x1234;
    cup_.folder = folder_ / "cup";
  }

  std::filesystem::path File() const { return TrainingFile(cup_.folder); }

  /// Writes the training of the cup, changed by `change`.
  template <class Change>
  void Spoil(Change change) {
    SaveTraining(TrainModel(cup_), File());
    std::string bytes = ReadFile(File());
    change(&bytes);
    WriteFile(File(), bytes);
  }

  RecognitionModel Train() const { return TrainModels(world::ObjectDatabase({cup_})).front(); }

  /// Expects that the file is refused with `message`, warned about and made anew.
  void ExpectMadeAnew(const std::string& message) {
    EXPECT_THROWS(LoadTraining(cup_, File()), ConfigError, message);
    const LogText log;
    EXPECT_EQ(Train().points.size(), RecognitionModel::kPoints);
    EXPECT_THAT(log.text(), HasSubstr(message));
    EXPECT_THAT(log.text(), HasSubstr("'cup' is trained anew"));
    EXPECT_NO_THROW(LoadTraining(cup_, File()));
  }

  TemporaryFolder folder_;
  world::ObjectModel cup_;
};

TEST_F(TrainingFileTest, GivesBackExactlyWhatWasTrained) {
  const RecognitionModel trained = TrainModel(cup_);
  SaveTraining(trained, File());
  const std::string bytes = ReadFile(File());
  const RecognitionModel loaded = LoadTraining(cup_, File());
  EXPECT_EQ(loaded.name, "cup");
  EXPECT_EQ(loaded.ppf.entries.size(), trained.ppf.entries.size());
  EXPECT_EQ(loaded.symmetry.axis.has_value(), true);
  // Written again, it is the same to the last bit.
  SaveTraining(loaded, File());
  EXPECT_EQ(ReadFile(File()), bytes);
}

TEST_F(TrainingFileTest, IsMadeTheFirstTimeAndReadTheNext) {
  Train();
  ASSERT_TRUE(std::filesystem::exists(File()));
  const auto written = std::filesystem::last_write_time(File());
  const LogText log;
  Train();
  EXPECT_EQ(std::filesystem::last_write_time(File()), written);
  EXPECT_EQ(log.text(), "");
}

TEST_F(TrainingFileTest, AnotherVersionIsMadeAnew) {
  Spoil([](std::string* bytes) { (*bytes)[8] = 77; });
  ExpectMadeAnew("cup.recognition: is of version 77; this program reads version ");
}

TEST_F(TrainingFileTest, ATruncatedFileIsMadeAnew) {
  for (const std::size_t length : {12UL, 36UL, 1000UL}) {
    Spoil([&](std::string* bytes) { bytes->resize(length); });
    ExpectMadeAnew("cup.recognition: is truncated");
  }
}

TEST_F(TrainingFileTest, ADamagedFileIsMadeAnew) {
  Spoil([](std::string* bytes) { (*bytes)[5000] ^= 1; });
  ExpectMadeAnew("cup.recognition: is damaged: its checksum is not right");
}

TEST_F(TrainingFileTest, ALengthThatPromisesMoreThanThereIsAllocatesNothing) {
  Spoil([](std::string* bytes) {
    // The first count, of surface points; and a checksum that fits.
    constexpr std::size_t kHead = 36;
    std::string payload = bytes->substr(kHead);
    std::memset(payload.data() + 8 + 24 + 8, 0xff, 4);
    const std::uint64_t checksum = Fnv1a(payload);
    std::memcpy(bytes->data() + kHead - 8, &checksum, 8);
    bytes->replace(kHead, payload.size(), payload);
  });
  ExpectMadeAnew("is damaged: 4294967295 values of 36 bytes are to follow");
}

TEST_F(TrainingFileTest, WhatIsNoTrainingFileIsMadeAnew) {
  WriteFile(File(), "a shopping list");
  ExpectMadeAnew("cup.recognition: is no training file");
}

TEST_F(TrainingFileTest, TheFileOfAnotherMeshIsMadeAnew) {
  Train();
  cup_.hash = 0x5678;
  ExpectMadeAnew(
      "was trained from an object with hash 0000000000001234, and 'cup' has hash 0000000000005678");
}

TEST_F(TrainingFileTest, AFileThatIsFarTooLargeIsNotRead) {
  WriteFile(File(), "");
  std::filesystem::resize_file(File(), 60'000'000);
  ExpectMadeAnew("cup.recognition: has 60000000 bytes (at most 50000000)");
}

TEST_F(TrainingFileTest, AFolderThatCannotBeWrittenIsAWarning) {
  WriteFile(folder_ / "no folder", "");
  cup_.folder = folder_ / "no folder" / "cup";
  const LogText log;
  EXPECT_EQ(Train().points.size(), RecognitionModel::kPoints);
  EXPECT_THAT(log.text(), HasSubstr("cup.recognition: cannot"));
  EXPECT_THAT(log.text(), HasSubstr("is not kept"));
}

}  // namespace
}  // namespace secondlook::perception

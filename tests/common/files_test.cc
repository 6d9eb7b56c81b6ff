#include "lib/common/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook {
namespace {

namespace fs = std::filesystem;

TEST(WriteFile, MakesTheFolderAndLeavesNothingBeside) {
  TemporaryFolder folder;
  WriteFile(folder / "new/file.txt", "one");
  WriteFile(folder / "new/file.txt", "two");
  EXPECT_EQ(ReadFile(folder / "new/file.txt"), "two");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "new"), fs::directory_iterator()), 1);
}

TEST(WriteFile, FollowsALinkInsteadOfReplacingIt) {
  TemporaryFolder folder;
  WriteFile(folder / "target.txt", "old");
  fs::create_symlink(folder / "target.txt", folder / "link.txt");
  WriteFile(folder / "link.txt", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link.txt"));
  EXPECT_EQ(ReadFile(folder / "target.txt"), "new");
}

TEST(WriteFile, WritesToADeviceAndDoesNotReplaceIt) {
  WriteFile("/dev/null", "nothing");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_THROWS(WriteFile("/dev/full", "something"), ConfigError, "/dev/full: cannot be written");
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST(WriteFile, SaysWhyItCannot) {
  TemporaryFolder folder;
  WriteFile(folder / "file.txt", "x");
  EXPECT_THROWS(WriteFile(folder / "file.txt/below.txt", "y"), ConfigError, "below.txt");
}

TEST(ReadFile, NamesTheFileThatIsMissingOrAFolder) {
  TemporaryFolder folder;
  EXPECT_THROWS(ReadFile(folder / "none.txt"), ConfigError, "none.txt: cannot be read");
  EXPECT_THROWS(ReadFile(folder.path()), ConfigError, "is a folder");
}

}  // namespace
}  // namespace secondlook

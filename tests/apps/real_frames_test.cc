#include <filesystem>

#include <gtest/gtest.h>

#include "apps/experiments/experiment.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::apps {
namespace {

TEST(RealFrames, SaysWhatTheFolderHasToHold) {
  ExperimentOptions options;
  options.data = "/no/such/folder";
  EXPECT_THROWS(RunRealFramesExperiment(options), ConfigError,
                "--data /no/such/folder: no such folder; real-frames needs one with "
                "NAME-color.png, NAME-depth.png and NAME-gt.json");
  const TemporaryFolder folder;
  options.data = folder.path().string();
  EXPECT_THROWS(RunRealFramesExperiment(options), ConfigError, "holds no *-gt.json");
  WriteFile(folder.path() / "7-gt.json", "{ no json");
  EXPECT_THROWS(RunRealFramesExperiment(options), ConfigError, "7-gt.json: is no JSON");
}

}  // namespace
}  // namespace secondlook::apps

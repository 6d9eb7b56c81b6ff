#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace secondlook {
namespace {

namespace fs = std::filesystem;

/// Which folders each folder may include from, besides itself: the arrows of the architecture.
const std::map<std::string, std::set<std::string>> kAllowed = {
    {"lib/common", {}},
    {"lib/geometry", {"lib/common"}},
    {"lib/kinematics", {"lib/common", "lib/geometry"}},
    {"lib/transport", {"lib/common"}},
    {"lib/hal", {"lib/common", "lib/geometry"}},
    {"lib/hal/replay",
     {"lib/common", "lib/geometry", "lib/kinematics", "lib/transport", "second_look", "lib/hal"}},
    {"lib/hal/drivers",
     {"lib/common", "lib/geometry", "lib/kinematics", "lib/transport", "bot_core", "drake",
      "second_look", "lib/hal"}},
    {"lib/world", {"lib/common", "lib/geometry", "lib/hal"}},
    {"lib/perception", {"lib/common", "lib/geometry", "lib/hal", "lib/world"}},
    {"lib/perception/appearance", {"lib/common"}},
    {"lib/fusion", {"lib/common", "lib/geometry", "lib/hal", "lib/world"}},
    {"lib/planning/motion",
     {"lib/common", "lib/geometry", "lib/kinematics", "lib/hal", "lib/world"}},
    {"lib/planning",
     {"lib/common", "lib/geometry", "lib/kinematics", "lib/hal", "lib/world", "lib/perception",
      "lib/fusion", "lib/planning/motion"}},
    {"sim", {"lib/common", "lib/geometry", "lib/kinematics", "lib/hal"}},
};

/// Who besides sim/ itself may see the truth.
const std::vector<std::string> kMaySeeTheTruth = {"tests/", "bench/", "apps/experiments/"};

/// The folder of a file or an include, as kAllowed names it: "lib/hal", "lib/hal/replay", "sim",
/// "apps".
std::string FolderOf(const std::string& path) {
  const std::size_t first = path.find('/');
  if (first == std::string::npos) return "";
  const std::string whole = path.substr(0, path.rfind('/'));
  if (kAllowed.contains(whole)) return whole;
  if (path.substr(0, first) != "lib") return path.substr(0, first);
  return path.substr(0, path.find('/', first + 1));
}

struct Include {
  std::string file;
  int line;
  std::string included;
};

std::vector<Include> AllIncludes() {
  std::vector<Include> includes;
  const std::regex pattern("^\\s*#include \"([^\"]+)\"");
  for (const std::string top : {"lib", "sim", "apps"}) {
    for (const auto& entry : fs::recursive_directory_iterator(top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cc") continue;
      std::ifstream in(entry.path());
      std::string text;
      for (int line = 1; std::getline(in, text); ++line) {
        std::smatch match;
        if (std::regex_search(text, match, pattern)) {
          includes.push_back({entry.path().string(), line, match[1]});
        }
      }
    }
  }
  return includes;
}

TEST(Layering, EveryIncludeRunsAlongTheArrows) {
  const std::vector<Include> includes = AllIncludes();
  ASSERT_GT(includes.size(), 50U) << "run from the root of the repository";
  for (const Include& i : includes) {
    const std::string from = FolderOf(i.file);
    const std::string to = FolderOf(i.included);
    if (from == "apps" || from == to) continue;
    ASSERT_TRUE(kAllowed.contains(from)) << from << " is not in this test's table";
    EXPECT_TRUE(kAllowed.at(from).contains(to))
        << i.file << ":" << i.line << " includes \"" << i.included << "\", but " << from
        << " may not see " << (to.empty() ? "a file without its folder" : to);
  }
}

TEST(Layering, TheMissionNeverSeesTheTruth) {
  for (const Include& i : AllIncludes()) {
    if (i.included != "sim/ground_truth.h") continue;
    const bool allowed =
        FolderOf(i.file) == "sim" ||
        std::any_of(kMaySeeTheTruth.begin(), kMaySeeTheTruth.end(),
                    [&](const auto& folder) { return i.file.starts_with(folder); });
    EXPECT_TRUE(allowed) << i.file << ":" << i.line;
  }
}

}  // namespace
}  // namespace secondlook

#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "apps/run_config.h"
#include "lib/common/files.h"
#include "lib/common/yaml_reader.h"
#include "lib/transport/channels.h"
#include "sim/noise.h"
#include "sim/scene.h"
#include "tests/support/temporary_folder.h"

namespace secondlook {
namespace {

namespace fs = std::filesystem;

/// All that is documentation, relative to the root of the repository, which is the working folder.
std::vector<fs::path> Pages() {
  std::vector<fs::path> pages{"README.md", "CONTRIBUTING.md", "CHANGELOG.md"};
  for (const auto& entry : fs::recursive_directory_iterator("docs")) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  std::sort(pages.begin(), pages.end());
  return pages;
}

/// The first group of every match of `pattern`.
std::vector<std::string> AllMatches(const std::string& text, const std::string& pattern) {
  std::vector<std::string> matches;
  const std::regex regex(pattern);
  for (auto i = std::sregex_iterator(text.begin(), text.end(), regex); i != std::sregex_iterator();
       ++i) {
    matches.push_back((*i)[1]);
  }
  return matches;
}

/// The fenced blocks of a page that are marked as YAML.
std::vector<std::string> YamlBlocks(const fs::path& page) {
  return AllMatches(ReadFile(page), "```yaml\n([^`]*)```");
}

/// The lines of `page` from the heading `title` up to the next one.
std::vector<std::string> SectionLines(const fs::path& page, const std::string& title) {
  std::istringstream in(ReadFile(page));
  std::vector<std::string> lines;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("## ")) inside = line == "## " + title;
    if (inside) lines.push_back(line);
  }
  return lines;
}

/// A key of a documented table, with its default as it stands there.
struct DocumentedKey {
  std::string key;
  std::string default_text;
};

/// The keys in the first column of a section's table, and what its third column says. In a row of
/// several keys the later ones stand without what comes before the last dot.
std::vector<DocumentedKey> DocumentedKeys(const fs::path& page, const std::string& title) {
  std::vector<DocumentedKey> keys;
  for (const std::string& line : SectionLines(page, title)) {
    const std::vector<std::string> cells = AllMatches(line, "\\|\\s*([^|]*[^|\\s])?\\s*(?=\\|)");
    if (cells.size() < 3) continue;
    std::vector<std::string> row = AllMatches(cells[0], "`([^`]+)`");
    for (std::size_t i = 1; i < row.size(); ++i) {
      row[i] = row[0].substr(0, row[0].rfind('.') + 1) + row[i];
    }
    std::string text = cells[2];
    std::erase(text, '`');
    YAML::Node defaults;
    try {
      defaults = YAML::Load("[" + text + "]");
    } catch (const YAML::Exception&) {
      defaults = YAML::Load("[]");
    }
    const bool one_each = row.size() > 1 && defaults.size() == row.size();
    for (std::size_t i = 0; i < row.size(); ++i) {
      keys.push_back({row[i], one_each ? YAML::Dump(defaults[i]) : text});
    }
  }
  return keys;
}

/// A value of a configuration.
struct Leaf {
  std::string key;  ///< Its path; "[]" stands for any element of a list of maps.
  YAML::Node value;
};

void AddLeaves(const YAML::Node& node, const std::string& path, std::vector<Leaf>* leaves,
               std::set<std::string>* containers) {
  if (node.IsMap()) {
    containers->insert(path);
    const std::string prefix = path.empty() ? "" : path + ".";
    for (const auto& entry : node) {
      AddLeaves(entry.second, prefix + entry.first.as<std::string>(), leaves, containers);
    }
  } else if (node.IsSequence() && node.size() > 0 && node[0].IsMap()) {
    containers->insert(path);
    AddLeaves(node[0], path + "[]", leaves, containers);
  } else {
    leaves->push_back({path, node});
  }
}

/// All keys of a configuration, those of its leaves with their values.
struct Keys {
  std::vector<Leaf> leaves;
  std::set<std::string> containers;

  explicit Keys(const std::string& yaml) { AddLeaves(YAML::Load(yaml), "", &leaves, &containers); }

  bool Contain(const std::string& key) const {
    return containers.contains(key) ||
           std::any_of(leaves.begin(), leaves.end(), [&](const Leaf& l) { return l.key == key; });
  }
};

/// The keys of a scene that has one of each thing, all with their defaults.
Keys SceneKeys() {
  sim::Scene scene;
  scene.objects.emplace_back();
  scene.boxes.emplace_back();
  scene.moving_obstacles.emplace_back();
  scene.walls.emplace();
  return Keys(ToYaml(scene));
}

/// True when both are the same lists, numbers or texts.
bool Same(const YAML::Node& a, const YAML::Node& b) {
  if (a.IsSequence() != b.IsSequence()) return false;
  if (a.IsSequence()) {
    bool same = a.size() == b.size();
    for (std::size_t i = 0; same && i < a.size(); ++i) same = Same(a[i], b[i]);
    return same;
  }
  double x = 0.0;
  double y = 0.0;
  if (YAML::convert<double>::decode(a, x) && YAML::convert<double>::decode(b, y)) return x == y;
  return a.as<std::string>() == b.as<std::string>();
}

/// Holds a documented table to what the code has: the same keys with the same defaults.
/// `special` are defaults in words, which no code can be compared with.
void ExpectDocumented(const std::vector<DocumentedKey>& documented, const Keys& keys,
                      const std::set<std::string>& special) {
  ASSERT_GT(documented.size(), 10U);
  for (const Leaf& leaf : keys.leaves) {
    const auto found = std::find_if(documented.begin(), documented.end(),
                                    [&](const DocumentedKey& d) { return d.key == leaf.key; });
    if (found == documented.end()) {
      ADD_FAILURE() << leaf.key << " is not documented";
      continue;
    }
    if (special.contains(found->default_text)) continue;
    EXPECT_TRUE(Same(YAML::Load(found->default_text), leaf.value))
        << leaf.key << " is documented with the default " << found->default_text << ", but has "
        << leaf.value;
  }
  for (const DocumentedKey& d : documented) {
    EXPECT_TRUE(keys.Contain(d.key)) << d.key << " is documented, but there is no such key";
  }
}

TEST(Docs, EveryRelativeLinkLeadsSomewhere) {
  int links = 0;
  for (const fs::path& page : Pages()) {
    for (const std::string& link : AllMatches(ReadFile(page), "\\]\\(([^)#\\s]+)[^)]*\\)")) {
      if (link.find("://") != std::string::npos) continue;
      EXPECT_TRUE(fs::exists(page.parent_path() / link)) << page << " links to " << link;
      ++links;
    }
  }
  EXPECT_GT(links, 15);
}

TEST(Docs, EveryFileThatIsNamedExists) {
  int files = 0;
  for (const fs::path& page : Pages()) {
    for (const std::string& file : AllMatches(
             ReadFile(page),
             "`((?:apps|bench|cmake|config|docs|lib|sim|tests|tools|\\.ci)/[\\w./-]*)[` ]")) {
      EXPECT_TRUE(fs::exists(file)) << page << " names " << file;
      ++files;
    }
  }
  EXPECT_GT(files, 20);
}

TEST(Docs, EveryKeyOfAConfigurationThatIsNamedExists) {
  const Keys config(ToYaml(apps::RunConfig{}));
  apps::RunConfig on_real_robot;
  on_real_robot.robot = apps::RealConfig{};
  const Keys real(ToYaml(on_real_robot));
  const Keys scene = SceneKeys();
  int keys = 0;
  for (const fs::path& page : Pages()) {
    const std::string text = ReadFile(page);
    std::vector<std::string> named = AllMatches(text, "--set ([a-z][\\w.]*)=");
    for (const std::string& key :
         AllMatches(text, "`((?:robot|task|mission)(?!\\.(?:json|h)\\b)(?:\\.[a-z0-9_]+)+)`")) {
      named.push_back(key);
    }
    for (const std::string& key : named) {
      EXPECT_TRUE(config.Contain(key) || real.Contain(key) || scene.Contain(key))
          << page << " names '" << key << "'";
      ++keys;
    }
  }
  EXPECT_GT(keys, 5);
}

TEST(Docs, EveryExampleOfASceneLoads) {
  const TemporaryFolder folder;
  int examples = 0;
  for (const std::string& yaml : YamlBlocks("docs/scenes.md")) {
    if (!std::regex_search(yaml, std::regex("(^|\n)table:"))) continue;  // a part of one
    WriteFile(folder.path() / "example.yaml", yaml);
    const sim::Scene scene = sim::LoadScene(folder.path() / "example.yaml");
    EXPECT_FALSE(scene.objects.empty());
    for (const auto& object : YAML::Load(yaml)["objects"]) {
      const fs::path mesh = object["mesh"].as<std::string>();
      if (mesh.is_relative()) {
        EXPECT_TRUE(fs::exists("sim/scenes" / mesh)) << mesh;
      }
    }
    ++examples;
  }
  EXPECT_GE(examples, 1);
}

TEST(Docs, EveryExampleOfAConfigurationLoads) {
  const TemporaryFolder folder;
  int examples = 0;
  for (const std::string& yaml : YamlBlocks("README.md")) {
    WriteFile(folder.path() / "example.yaml", yaml);
    const apps::RunConfig config = apps::LoadRunConfig(folder.path() / "example.yaml", {});
    EXPECT_EQ(fs::path(config.models).parent_path(), folder.path());
    ++examples;
  }
  EXPECT_GE(examples, 1);
}

void ExpectChannels(const std::string& file, const std::vector<transport::ChannelType>& channels) {
  const std::string text = ReadFile(file);
  for (const transport::ChannelType& c : channels) {
    EXPECT_TRUE(std::regex_search(
        text, std::regex(fmt::format("\\n\\| `{}` \\| `{}` \\|", c.channel, c.type))))
        << c.channel << " of type " << c.type << " in " << file;
  }
}

TEST(Docs, EveryChannelStandsThereWithItsType) {
  ExpectChannels("docs/channels.md", transport::Channels());
  ExpectChannels("docs/real_robot.md", transport::DeviceChannels());
}

TEST(Docs, TheExampleOfASubscriberIsTheFileThatRuns) {
  const std::vector<std::string> blocks =
      AllMatches(ReadFile("docs/channels.md"), "```python\n([^`]*)```");
  ASSERT_EQ(blocks.size(), 1U);
  EXPECT_EQ(blocks[0], ReadFile("tools/listen.py"));
}

TEST(Docs, TheKeysOfASceneStandThereWithTheirDefaults) {
  std::vector<DocumentedKey> documented = DocumentedKeys("docs/scenes.md", "The keys");
  std::erase_if(documented, [](const auto& d) { return d.key == "noise"; });  // YAML in YAML
  ExpectDocumented(documented, SceneKeys(), {"*required*"});
}

TEST(Docs, TheRobotsErrorsStandThereWithTheirDefaults) {
  ExpectDocumented(DocumentedKeys("docs/scenes.md", "The robot's errors"),
                   Keys(ToYaml(sim::NoiseConfig{})), {});
}

}  // namespace
}  // namespace secondlook

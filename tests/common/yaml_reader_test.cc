#include "lib/common/yaml_reader.h"

#include <gtest/gtest.h>

#include "tests/support/expect_throws.h"

namespace secondlook {
namespace {

struct Sim {
  static constexpr const char* kTag = "Sim";
  int fps = 30;
  template <class A>
  void Serialize(A* a) {
    a->Visit("fps", &fps);
  }
};

struct Real {
  static constexpr const char* kTag = "Real";
  std::string uri = "any";
  template <class A>
  void Serialize(A* a) {
    a->Visit("uri", &uri);
  }
};

struct Config {
  std::variant<Sim, Real> camera;
  double speed = 0.5;
  std::vector<double> rings{1.0, 2.0};
  std::map<std::string, double> wanted;
  std::optional<int> limit;
  Eigen::Vector3d size{1.0, 2.0, 3.0};

  template <class A>
  void Serialize(A* a) {
    a->Visit("camera", &camera);
    a->Visit("speed", &speed);
    a->Visit("rings", &rings);
    a->Visit("wanted", &wanted);
    a->Visit("limit", &limit);
    a->Visit("size", &size);
  }
  void Validate() const {
    if (speed <= 0.0) Throw<ConfigError>("'speed' = {} must be positive", speed);
  }
};

Config Read(const std::string& yaml) {
  Config config;
  ApplyLayer({YAML::Load(yaml), "robot.yaml"}, &config);
  return config;
}

TEST(YamlReader, KeepsTheDefaultsOfKeysThatAreMissing) {
  const Config config = Read("{speed: 2}");
  EXPECT_EQ(config.speed, 2.0);
  EXPECT_EQ(std::get<Sim>(config.camera).fps, 30);
}

TEST(YamlReader, ChoosesTheAlternativeByItsTag) {
  EXPECT_EQ(std::get<Real>(Read("camera: !Real {uri: usb}").camera).uri, "usb");
  EXPECT_EQ(std::get<Real>(Read("camera: !Real").camera).uri, "any");
}

TEST(YamlReader, NamesThePlaceAndPathOfAnUnknownKey) {
  EXPECT_THROWS(Read("speed: 1\ncamera: !Sim\n  fsp: 3\n"), ConfigError,
                "robot.yaml:3:3: unknown key 'camera.fsp'; known here: fps");
}

TEST(YamlReader, NamesTheTypeThatWasExpected) {
  EXPECT_THROWS(Read("speed: fast"), ConfigError,
                "robot.yaml:1:8: 'speed' must be a finite number");
  EXPECT_THROWS(Read("speed: .nan"), ConfigError, "'speed' must be a finite number");
  EXPECT_THROWS(Read("camera: !Sim {fps: 2.5}"), ConfigError,
                "'camera.fps' must be a whole number");
  EXPECT_THROWS(Read("rings: 3"), ConfigError, "'rings' must be a list");
  EXPECT_THROWS(Read("size: [1, 2]"), ConfigError, "'size' must be a list of 3 values");
  EXPECT_THROWS(Read("[1, 2]"), ConfigError, "'the file' must be a map");
}

TEST(YamlReader, NamesTheTagsItKnows) {
  EXPECT_THROWS(Read("camera: !Kinect {}"), ConfigError,
                "robot.yaml:1:9: 'camera' has tag '!Kinect'; expected one of !Sim !Real");
}

TEST(YamlReader, RefusesAKeyThatStandsTwice) {
  EXPECT_THROWS(Read("speed: 1\nspeed: 2\n"), ConfigError, "'speed' stands here twice");
}

TEST(YamlReader, PutsThePlaceInFrontOfWhatValidateSays) {
  EXPECT_THROWS(Read("speed: -1"), ConfigError, "robot.yaml:1:1: 'speed' = -1 must be positive");
}

TEST(YamlReader, AnOverrideReachesIntoTheFileBelow) {
  Config config = Read("camera: !Real {uri: usb}");
  ApplyLayer(ParseOverride("camera.uri=eth"), &config);
  ApplyLayer(ParseOverride("rings=[3]"), &config);
  EXPECT_EQ(std::get<Real>(config.camera).uri, "eth");
  EXPECT_EQ(config.rings, std::vector<double>{3.0});
  EXPECT_THROWS(ApplyLayer(ParseOverride("camera.url=eth"), &config), ConfigError,
                "unknown key 'camera.url'");
  EXPECT_THROWS(ParseOverride("camera"), ConfigError, "--set camera: must be KEY=VALUE");
}

TEST(YamlWriter, WritesWhatTheReaderReadsBack) {
  Config config;
  config.camera = Real{"a \"quoted\" name"};
  config.speed = 0.1;
  config.wanted["mug"] = 0.99;
  const std::string text = ToYaml(config);
  const Config again = Read(text);
  EXPECT_EQ(ToYaml(again), text);
  EXPECT_EQ(again.speed, 0.1);
  EXPECT_EQ(std::get<Real>(again.camera).uri, "a \"quoted\" name");
  EXPECT_FALSE(again.limit.has_value());
}

}  // namespace
}  // namespace secondlook

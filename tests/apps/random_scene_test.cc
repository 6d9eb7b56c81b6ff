#include "apps/experiments/random_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "lib/geometry/mesh.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector2d;

constexpr double kPi = std::numbers::pi;

const Repertoire& Shipped() {
  static const Repertoire repertoire = LoadRepertoire("sim/models", "sim/unfamiliar");
  return repertoire;
}

std::vector<Vector2d> Outline(const sim::PlacedObject& object) {
  std::vector<Vector2d> outline;
  for (const Eigen::Vector3f& p_MV : object.mesh.vertices) {
    outline.emplace_back((object.X_WM * p_MV.cast<double>()).head<2>());
  }
  return outline;
}

/// The distance between the outlines' convex hulls, from below: the widest gap along any of many
/// directions (every separating line is near one of them).
double Gap(const std::vector<Vector2d>& a, const std::vector<Vector2d>& b) {
  double widest = -1.0;
  for (int i = 0; i < 720; ++i) {
    const Vector2d axis(std::cos(i * kPi / 360.0), std::sin(i * kPi / 360.0));
    double a_high = -1e9;
    double b_low = 1e9;
    for (const Vector2d& p : a) a_high = std::max(a_high, axis.dot(p));
    for (const Vector2d& p : b) b_low = std::min(b_low, axis.dot(p));
    widest = std::max(widest, b_low - a_high);
  }
  return widest;
}

TEST(RandomScene, KeepsItsLawsWhateverIsDrawn) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Rng rng(seed);
    const sim::Scene scene = DrawScene(Shipped(), &rng);
    EXPECT_NO_THROW(scene.Validate());
    EXPECT_GE(scene.objects.size(), 4U) << seed;
    EXPECT_LE(scene.objects.size(), 8U) << seed;
    std::set<std::string> names;
    int unknown = 0;
    for (const sim::SceneObject& object : scene.objects) {
      names.insert(object.name);
      if (object.role == "unknown") ++unknown;
    }
    EXPECT_EQ(names.size(), scene.objects.size()) << "something was drawn twice";
    EXPECT_LE(unknown, 2);

    const std::vector<sim::PlacedObject> placed = sim::PlaceObjects(scene);
    std::vector<std::vector<Vector2d>> outlines;
    for (const sim::PlacedObject& object : placed) {
      outlines.push_back(Outline(object));
      for (const Vector2d& p : outlines.back()) {
        EXPECT_TRUE(scene.table.Contains(p)) << object.name << ", seed " << seed;
      }
    }
    for (std::size_t i = 0; i < placed.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        // 720 directions miss the best one by 1/4 degree at most: 1e-5 of the width.
        EXPECT_GE(Gap(outlines[i], outlines[j]), 0.03 - 1e-4)
            << placed[i].name << " and " << placed[j].name << ", seed " << seed;
      }
    }
  }
}

TEST(RandomScene, StartsTheRobotInFreeSpaceFacingTheTable) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Rng rng(seed);
    const sim::Scene scene = DrawScene(Shipped(), &rng);
    const Vector2d start = scene.robot.position;
    EXPECT_GE(start.norm(), 1.5);
    EXPECT_LE(start.norm(), 2.2);
    const double to_table = std::atan2(-start.y(), -start.x());
    const double off = WrapAngle(scene.robot.yaw_deg * kPi / 180.0 - to_table);
    EXPECT_LE(std::abs(off), 15.0 * kPi / 180.0 + 1e-9) << seed;
    for (const sim::SceneBox& crate : scene.boxes) {
      const Vector2d p =
          Eigen::Rotation2Dd(-crate.yaw_deg * kPi / 180.0) * (start - crate.position.head<2>());
      const Vector2d beyond = (p.cwiseAbs() - crate.size.head<2>() / 2.0).cwiseMax(0.0);
      EXPECT_GT(beyond.norm(), 0.28) << "the robot starts in a crate, seed " << seed;
    }
  }
}

TEST(RandomScene, DependsOnTheGeneratorAlone) {
  Rng a(5);
  Rng b(5);
  Rng c(6);
  const std::string scene = sim::SceneToYaml(DrawScene(Shipped(), &a));
  EXPECT_EQ(sim::SceneToYaml(DrawScene(Shipped(), &b)), scene);
  EXPECT_NE(sim::SceneToYaml(DrawScene(Shipped(), &c)), scene);
  EXPECT_NE(sim::SceneToYaml(DrawScene(Shipped(), &a)), scene) << "the generator moves on";
}

TEST(RandomScene, HasUnknownThingsInAboutHalfOfAllDraws) {
  int with = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Rng rng(seed);
    for (const sim::SceneObject& object : DrawScene(Shipped(), &rng).objects) {
      if (object.role != "unknown") continue;
      ++with;
      break;
    }
  }
  // 2 of 4 draws have some; 60 scenes: 30 +- 5 sigma.
  EXPECT_GT(with, 10);
  EXPECT_LT(with, 50);
}

TEST(CrowdedTable, HoldsAllItsThingsApartFromEachOther) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Rng rng(seed);
    const std::vector<sim::SceneObject> things = DrawObjects(Shipped().known, 7, &rng);
    const sim::Scene scene = DrawCrowdedTable(things, &rng);
    ASSERT_EQ(scene.objects.size(), 7U) << seed;
    EXPECT_NO_THROW(scene.Validate());
    const std::vector<sim::PlacedObject> placed = sim::PlaceObjects(scene);
    for (std::size_t i = 0; i < placed.size(); ++i) {
      EXPECT_EQ(placed[i].name, things[i].name);
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_GE(Gap(Outline(placed[i]), Outline(placed[j])), 0.03 - 1e-4) << seed;
      }
    }
  }
}

TEST(DrawObjects, TakesNoneTwiceAndAllWhenThereAreFewer) {
  Rng rng(3);
  std::set<std::string> names;
  for (const auto& object : DrawObjects(Shipped().known, 7, &rng)) names.insert(object.name);
  EXPECT_EQ(names.size(), 7U);
  EXPECT_EQ(DrawObjects(Shipped().known, 1000, &rng).size(), Shipped().known.size());
}

TEST(Repertoire, WithoutAFolderOfUnfamiliarThingsHasKnownOnesAlone) {
  const Repertoire repertoire = LoadRepertoire("sim/models", "");
  EXPECT_GE(repertoire.known.size(), 16U);
  EXPECT_TRUE(repertoire.unknown.empty());
}

}  // namespace
}  // namespace secondlook::apps

#include "lib/planning/scan_gain.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"
#include "tests/support/half_ball.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector3d;

/// One ray along the optical axis.
const geometry::CameraModel kOneRay{1, 1, 100.0, 100.0, 0.0, 0.0};
const ScanGainConfig kEveryRay{.max_range_m = 5.0, .stride = 1};

/// Looks along +x from x = -0.1 through the middle of voxels of 0.1 m.
Pose AlongX() { return LookAt(Vector3d(-0.1, 0.05, 0.05), Vector3d(1.0, 0.05, 0.05)); }

world::BrickGrid Grid() { return {0.1, {Vector3d(0, -0.4, -0.4), Vector3d(0.8, 0.4, 0.4)}}; }

TEST(ScanGain, SumsTheEntropyUpToWhatIsOccupied) {
  world::BrickGrid grid = Grid();
  const auto entropy = [&] {
    return ScanGainField(grid, {}, {}, tests::LevelPlane(-1), kEveryRay)
        .Measure(kOneRay, AlongX())
        .entropy;
  };
  EXPECT_NEAR(entropy(), 8.0, 1e-3);  // unknown: a bit each
  grid.SetPoints({{0.05, 0.05, 0.05}, {0.15, 0.05, 0.05}}, world::LogOdds(0.1));
  EXPECT_NEAR(entropy(), 6.0 + 2.0 * 0.468996, 1e-3);  // H(0.1)
  grid.SetPoints({{0.45, 0.05, 0.05}}, world::LogOdds(0.9));
  EXPECT_NEAR(entropy(), 2.0 + 3.0 * 0.468996, 1e-3);
}

TEST(ScanGain, RaysOutOfTheGridMeetNothing) {
  const world::BrickGrid grid = Grid();
  const ScanGainField field(grid, {}, {}, tests::LevelPlane(-1), kEveryRay);
  const Pose away = LookAt(Vector3d(-0.1, 0.05, 0.05), Vector3d(-1.0, 0.05, 0.05));
  EXPECT_EQ(field.Measure(kOneRay, away).entropy, 0.0);
  EXPECT_EQ(field.Measure(kOneRay, away).quality, 1.0);
}

TEST(ScanGain, QualityIsTheMeanOfBordersAndDensityByLambda) {
  world::BrickGrid grid = Grid();
  grid.SetPoints({{0.45, 0.05, 0.05}}, world::LogOdds(0.9));
  world::PartialMesh surface;  // one triangle, all border, of density 0.6
  surface.mesh.vertices = {{0.45F, 0.02F, 0.02F}, {0.45F, 0.08F, 0.02F}, {0.45F, 0.05F, 0.08F}};
  surface.mesh.triangles = {{0, 1, 2}};
  surface.normals.assign(3, Eigen::Vector3f(-1, 0, 0));
  surface.density.assign(3, 0.6F);
  ScanGainConfig config = kEveryRay;
  config.lambda = 0.25;
  const ScanGainField field(grid, surface, {}, tests::LevelPlane(-1), config);
  EXPECT_NEAR(field.Measure(kOneRay, AlongX()).quality, 0.25 * 0.0 + 0.75 * 0.6, 1e-6);
}

TEST(ScanGain, SurfaceWhereTheMapKnowsNothingTellsOfQualityAlone) {
  world::PartialMesh surface;  // the first triangles of a scan whose rays the map does not hold
  for (int i = 0; i < 3; ++i) {
    const float x = 0.15F + 0.1F * static_cast<float>(i);
    surface.mesh.vertices.insert(surface.mesh.vertices.end(),
                                 {{x, 0.02F, 0.02F}, {x, 0.08F, 0.02F}, {x, 0.05F, 0.08F}});
    surface.mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  surface.normals.assign(9, Eigen::Vector3f(-1, 0, 0));
  surface.density.assign(9, 1.0F);
  const std::vector<SurfaceTrend> trends{{Vector3d(0.65, 0.05, 0.05), Vector3d(-1, 0, 0), 0.1}};
  ScanGainConfig config = kEveryRay;
  config.unknown_survival = 1.0;
  const ScanGain gain = ScanGainField(Grid(), surface, trends, tests::LevelPlane(-1), config)
                            .Measure(kOneRay, AlongX());
  EXPECT_NEAR(gain.quality, 0.5, 1e-6);  // dense, but all border
  EXPECT_NEAR(gain.new_surface, 0.1 * 0.1, 1e-9);
}

TEST(ScanGain, NewSurfaceIsExpectedAtTrendsThatAreSeenFirstAndFaceTheSensor) {
  world::BrickGrid grid = Grid();
  grid.Fill(grid.box_W(), -2.0F);
  grid.Forget({Vector3d(0.4, 0.0, 0.0), Vector3d(0.5, 0.1, 0.1)});  // one unknown voxel
  const auto gain = [&](const Vector3d& normal) {
    const std::vector<SurfaceTrend> trends{{Vector3d(0.45, 0.05, 0.05), normal, 0.1}};
    return ScanGainField(grid, {}, trends, tests::LevelPlane(-1), kEveryRay)
        .Measure(kOneRay, AlongX())
        .new_surface;
  };
  EXPECT_NEAR(gain({-1, 0, 0}), 0.1 * 0.1, 1e-9);
  EXPECT_EQ(gain({1, 0, 0}), 0.0);  // its back
  EXPECT_EQ(gain({0, 0, 1}), 0.0);  // too flat
  grid.SetPoints({{0.25, 0.05, 0.05}}, 2.0F);
  EXPECT_EQ(gain({-1, 0, 0}), 0.0);  // hidden
}

TEST(ScanGain, WhatLiesBehindUnknownSpaceCountsByTheOddsThatItIsFree) {
  world::BrickGrid grid = Grid();
  grid.Fill(grid.box_W(), -2.0F);
  grid.Forget({Vector3d(0.2, 0.0, 0.0), Vector3d(0.3, 0.1, 0.1)});  // a shadow before…
  grid.Forget({Vector3d(0.4, 0.0, 0.0), Vector3d(0.5, 0.1, 0.1)});  // …where surface is expected
  const std::vector<SurfaceTrend> trends{{Vector3d(0.45, 0.05, 0.05), Vector3d(-1, 0, 0), 0.1}};
  ScanGainConfig config = kEveryRay;
  config.unknown_survival = 0.25;
  const auto gain = [&] {
    return ScanGainField(grid, {}, trends, tests::LevelPlane(-1), config)
        .Measure(kOneRay, AlongX())
        .new_surface;
  };
  EXPECT_NEAR(gain(), 0.25 * 0.1 * 0.1, 1e-9);
  config.unknown_m = 0.1;  // no more than it allows
  EXPECT_NEAR(gain(), 0.1 * 0.1, 1e-9);
}

TEST(ScanGain, KriegelWeighsQualityAsMuchAsExplorationAfterEightScans) {
  const ScanGainConfig config;
  EXPECT_EQ(QualityWeight(0, config), 0.0);
  EXPECT_DOUBLE_EQ(QualityWeight(8, config), 0.5);
  EXPECT_DOUBLE_EQ(QualityWeight(24, config), 0.75);
  // Entropy as a share of the most: 1 and 0.5; the second sees surface of quality 0.2.
  const std::vector<ScanGain> gains{{200.0, 1.0, 0.0}, {100.0, 0.2, 0.0}};
  const std::vector<double> first = KriegelUtilities(gains, 0, config);
  EXPECT_DOUBLE_EQ(first[0], 1.0);
  EXPECT_DOUBLE_EQ(first[1], 0.5);
  const std::vector<double> later = KriegelUtilities(gains, 8, config);
  EXPECT_DOUBLE_EQ(later[0], 0.5);
  EXPECT_DOUBLE_EQ(later[1], 0.25 + 0.4);
}

TEST(ScanGain, NamesAWrongConfiguration) {
  const world::BrickGrid grid = Grid();
  EXPECT_THROWS(ScanGainField(grid, {}, {}, tests::LevelPlane(0), {.lambda = 2.0}), ConfigError,
                "lambda = 2 must lie in 0..1");
}

}  // namespace
}  // namespace secondlook::planning

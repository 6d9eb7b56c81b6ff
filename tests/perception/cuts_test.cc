#include "lib/perception/cuts.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/perception/explain.h"
#include "tests/perception/synthetic_view.h"

namespace secondlook::perception {
namespace {

using testing::IsEmpty;

const Eigen::Vector3f kRed(0.8F, 0.15F, 0.1F);
const Eigen::Vector3f kBlue(0.1F, 0.2F, 0.8F);

/// Boxes flush in a row along x, as one cluster; `widths` along x.
struct Row {
  Row(const std::vector<double>& widths, const std::vector<Eigen::Vector3f>& colors) {
    std::vector<world::ObjectModel> boxes;
    for (std::size_t i = 0; i < widths.size(); ++i) {
      boxes.push_back(MakeBoxModel(std::string(1, static_cast<char>('a' + i)),
                                   {widths[i], 0.07, 0.1}, colors[i], colors[i]));
    }
    const std::vector<RecognitionModel> models = TrainModels(world::ObjectDatabase(boxes));
    std::vector<Placed> things;
    double x = 0.0;
    for (std::size_t i = 0; i < widths.size(); ++i) {
      things.push_back({&models[i], Upright(x + 0.5 * widths[i], 0.0, 0.0)});
      x += widths[i];
    }
    Rng rng(1);
    scene = DrawView(things, -1.2, true, &rng);
    std::vector<int> pixels;
    for (const world::Cluster& c : scene.clusters) {
      pixels.insert(pixels.end(), c.pixels.begin(), c.pixels.end());
    }
    whole = MakeCluster(pixels, scene.view.depth, scene.view.camera);
  }

  SyntheticView scene;
  world::Cluster whole;
};

/// The share of `part`'s pixels that lie in the better of the cut's two.
double ShareInOne(const world::Cluster& part, const Cut& cut) {
  std::size_t most = 0;
  for (const std::vector<int>& side : cut) {
    std::vector<int> both;
    std::set_intersection(part.pixels.begin(), part.pixels.end(), side.begin(), side.end(),
                          std::back_inserter(both));
    most = std::max(most, both.size());
  }
  return static_cast<double>(most) / static_cast<double>(part.pixels.size());
}

TEST(CutsByColor, FollowsTheEdgeBetweenTwoColours) {
  const Row row({0.13, 0.06}, {kRed, kBlue});
  const std::vector<Cut> cuts = CutsByColor(row.whole, row.scene.view);
  ASSERT_EQ(cuts.size(), 1U);
  for (const world::Cluster& part : row.scene.clusters) EXPECT_GT(ShareInOne(part, cuts[0]), 0.95);
  EXPECT_EQ(cuts[0][0].size() + cuts[0][1].size(), row.whole.pixels.size());
}

TEST(CutsByColor, FindsNothingOnOneColourNorWithoutColour) {
  Row row({0.13, 0.06}, {kRed, kRed});
  EXPECT_THAT(CutsByColor(row.whole, row.scene.view), IsEmpty());
  Row blind({0.13, 0.06}, {kRed, kBlue});
  blind.scene.view.color = cv::Mat();
  EXPECT_THAT(CutsByColor(blind.whole, blind.scene.view), IsEmpty());
}

TEST(CutsByShape, HalvesTheLongestSide) {
  const Row row({0.08, 0.08}, {kRed, kRed});
  const std::vector<Cut> cuts = CutsByShape(row.whole, row.scene.view.plane_C);
  ASSERT_FALSE(cuts.empty());
  for (const world::Cluster& part : row.scene.clusters) EXPECT_GT(ShareInOne(part, cuts[0]), 0.9);
}

TEST(CutsByShape, TakesAThirdOfALongRow) {
  const Row row({0.08, 0.08, 0.08}, {kRed, kRed, kRed});
  const std::vector<Cut> cuts = CutsByShape(row.whole, row.scene.view.plane_C);
  EXPECT_TRUE(std::any_of(cuts.begin(), cuts.end(), [&](const Cut& cut) {
    return std::all_of(row.scene.clusters.begin(), row.scene.clusters.end(),
                       [&](const world::Cluster& part) { return ShareInOne(part, cut) > 0.9; });
  }));
}

TEST(CutsByShape, OfTwoPointsMakesNothing) {
  world::Cluster two;
  two.pixels = {0, 1};
  two.points_C = {{0, 0, 1}, {0.1, 0, 1}};
  EXPECT_THAT(CutsByShape(two, {}), IsEmpty());
}

}  // namespace
}  // namespace secondlook::perception

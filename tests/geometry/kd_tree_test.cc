#include "lib/geometry/kd_tree.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::geometry {
namespace {

std::vector<Eigen::Vector3d> RandomPoints(Rng* rng, int count) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(rng->Uniform(-1, 1), rng->Uniform(-1, 1), rng->Uniform(-1, 1));
  }
  return points;
}

/// All points by distance, by brute force.
std::vector<Neighbour> Sorted(const std::vector<Eigen::Vector3d>& points,
                              const Eigen::Vector3d& query) {
  std::vector<Neighbour> all;
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    all.push_back({i, (points[i] - query).squaredNorm()});
  }
  std::sort(all.begin(), all.end(), [](const Neighbour& a, const Neighbour& b) {
    return a.squared_distance < b.squared_distance;
  });
  return all;
}

TEST(KdTree, FindsWhatBruteForceFinds) {
  Rng rng(3);
  const KdTree tree(RandomPoints(&rng, 300));
  for (const Eigen::Vector3d& query : RandomPoints(&rng, 200)) {
    const std::vector<Neighbour> all = Sorted(tree.points(), query);

    const std::vector<Neighbour> five = tree.Nearest(query, 5);
    ASSERT_EQ(five.size(), 5U);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(five[i].index, all[i].index);

    const std::optional<Neighbour> one = tree.Nearest(query, 0.15);
    ASSERT_EQ(one.has_value(), all[0].squared_distance < 0.15 * 0.15);
    if (one) {
      EXPECT_EQ(one->index, all[0].index);
      EXPECT_DOUBLE_EQ(one->squared_distance, all[0].squared_distance);
    }

    const auto expected = std::count_if(all.begin(), all.end(), [](const Neighbour& neighbour) {
      return neighbour.squared_distance < 0.3 * 0.3;
    });
    const std::vector<Neighbour> within = tree.Within(query, 0.3);
    ASSERT_EQ(static_cast<long>(within.size()), expected);
    for (std::size_t i = 0; i < within.size(); ++i) EXPECT_EQ(within[i].index, all[i].index);
  }
}

TEST(KdTree, OfNoPointsFindsNothing) {
  const KdTree tree({});
  EXPECT_FALSE(tree.Nearest(Eigen::Vector3d::Zero(), 10.0).has_value());
  EXPECT_TRUE(tree.Nearest(Eigen::Vector3d::Zero(), 3).empty());
  EXPECT_TRUE(tree.Within(Eigen::Vector3d::Zero(), 10.0).empty());
}

TEST(KdTree, GivesAllPointsWhenAskedForMoreThanItHolds) {
  Rng rng(4);
  const KdTree tree(RandomPoints(&rng, 7));
  EXPECT_EQ(tree.Nearest(Eigen::Vector3d::Zero(), 20).size(), 7U);
}

}  // namespace
}  // namespace secondlook::geometry

#include "lib/world/brick_grid.h"

#include <limits>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/world/solid_voxels.h"
#include "tests/support/expect_throws.h"

namespace secondlook::world {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kInf = std::numeric_limits<double>::infinity();

BrickGrid Grid() { return {0.01, {Vector3d(-0.1, 0.0, 0.5), Vector3d(0.4, 0.3, 0.9)}}; }

TEST(BrickGrid, CoversItsBoxInWholeBricks) {
  const BrickGrid grid = Grid();
  EXPECT_EQ(grid.first_brick(), Vector3i(-2, 0, 6));  // bricks of 0.08 m
  EXPECT_EQ(grid.brick_count(), Vector3i(7, 4, 6));
  EXPECT_TRUE(grid.Contains({-0.159, 0.0, 0.48}));
  EXPECT_FALSE(grid.Contains({-0.161, 0.0, 0.5}));
  EXPECT_FALSE(grid.Contains(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_EQ(grid.At({kInf, 0, 0}), Occupancy::kUnknown);
}

TEST(BrickGrid, HoldsAVoxelsStateAndNoOthers) {
  BrickGrid grid = Grid();
  grid.SetPoints({{0.105, 0.105, 0.605}, {9.0, 9.0, 9.0}}, 2.0F);
  grid.SetPoints({{0.115, 0.105, 0.605}}, -2.0F);
  EXPECT_EQ(grid.At({0.109, 0.101, 0.609}), Occupancy::kOccupied);
  EXPECT_EQ(grid.At({0.119, 0.101, 0.609}), Occupancy::kFree);
  EXPECT_EQ(grid.At({0.129, 0.101, 0.609}), Occupancy::kUnknown);
  EXPECT_NEAR(grid.ProbabilityAt({0.105, 0.105, 0.605}).value(), 0.880797, 1e-6);  // e^2/(1+e^2)
  EXPECT_FALSE(grid.ProbabilityAt({0.125, 0.105, 0.605}));
}

TEST(BrickGrid, KeepsWhatItHoldsWhenItGrows) {
  BrickGrid grid = Grid();
  grid.SetPoints({{0.105, 0.105, 0.605}}, 2.0F);
  grid.Cover({Vector3d(-3.0, -0.2, 0.0), Vector3d(0.0, 0.2, 0.6)});
  EXPECT_TRUE(grid.Contains({-2.9, -0.1, 0.1}));
  EXPECT_TRUE(grid.Contains({0.39, 0.29, 0.89}));
  EXPECT_EQ(grid.At({0.105, 0.105, 0.605}), Occupancy::kOccupied);
  EXPECT_EQ(grid.At({0.115, 0.105, 0.605}), Occupancy::kUnknown);
}

TEST(BrickGrid, ForgetsABoxByTheCentresOfItsVoxels) {
  BrickGrid grid = Grid();
  const AlignedBox3d all = grid.box_W();
  grid.Fill(all, -1.0F);
  const AlignedBox3d box(Vector3d(0.004, 0.006, 0.6), Vector3d(0.056, 0.05, 0.65));
  grid.Forget(box);
  Rng rng(3);
  for (int i = 0; i < 5000; ++i) {
    const Vector3d p(rng.Uniform(-0.1, 0.2), rng.Uniform(0, 0.2), rng.Uniform(0.5, 0.8));
    EXPECT_EQ(grid.At(p),
              box.contains(grid.CenterOf(grid.KeyOf(p))) ? Occupancy::kUnknown : Occupancy::kFree);
  }
}

TEST(BrickGrid, RefusesWhatIsNoBox) {
  const Vector3d zero = Vector3d::Zero();
  EXPECT_THROWS(BrickGrid(0.01, AlignedBox3d(zero, Vector3d(1, 1, 0))), InvalidArgument,
                "must be finite and have a volume");
  EXPECT_THROWS(BrickGrid(0.01, AlignedBox3d()), InvalidArgument, "have a volume");
  EXPECT_THROWS(BrickGrid(0.01, AlignedBox3d(zero, Vector3d(1, 1, kInf))), InvalidArgument,
                "must be finite");
  EXPECT_THROWS(BrickGrid(0.001, AlignedBox3d(zero, Vector3d(100, 100, 100))), InvalidArgument,
                "is too large for voxels of 0.001 m");
  EXPECT_THROWS(BrickGrid(0.0, AlignedBox3d(zero, Vector3d(1, 1, 1))), InvalidArgument,
                "voxels of 0 m");
}

TEST(SolidVoxels, FillABoxButNotTheInsideOfACup) {
  Pose X_WM = Pose::Identity();
  X_WM.translation() << 0.1, -0.2, 0.3;
  const geometry::Mesh box = geometry::MakeBox({0.098, 0.058, 0.038}, {1, 1, 1});
  EXPECT_EQ(SolidVoxels(box, X_WM, 0.01).size(), 10U * 6U * 4U);
  // A cup: the box without its lid. Its walls, floor and nothing else; the hollow is 8 x 4 x 3.
  geometry::Mesh cup = box;
  std::erase_if(cup.triangles, [&](const Vector3i& triangle) {
    return std::all_of(triangle.begin(), triangle.end(),
                       [&](int v) { return cup.vertices[v].z() > 0.0F; });
  });
  ASSERT_EQ(cup.triangles.size(), 10U);
  EXPECT_EQ(SolidVoxels(cup, X_WM, 0.01).size(), 10U * 6U * 4U - 8U * 4U * 3U);
}

TEST(SolidVoxels, RefuseBadInput) {
  const geometry::Mesh box = geometry::MakeBox({0.1, 0.1, 0.1}, {1, 1, 1});
  Pose X_WM = Pose::Identity();
  EXPECT_THROWS(SolidVoxels(box, X_WM, 1e-5), InvalidArgument, "less than 512 voxels wide");
  EXPECT_THROWS(SolidVoxels(geometry::Mesh(), X_WM, 0.01), InvalidArgument, "0 triangles");
  X_WM.translation().x() = kInf;
  EXPECT_THROWS(SolidVoxels(box, X_WM, 0.01), InvalidArgument, "X_WM is not finite");
}

}  // namespace
}  // namespace secondlook::world

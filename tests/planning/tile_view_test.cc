#include "lib/planning/tile_view.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

const Eigen::Vector3d kObject(0.1, -0.05, 0.8);

TEST(TileView, LooksAtTheObjectFromItsOwnDepth) {
  for (int t = 0; t < kTiles; ++t) {
    const Pose X_CV = TileView(static_cast<Tile>(t), kObject, 0.4);
    EXPECT_NEAR(X_CV.translation().z(), 0.8, 1e-12);
    const Eigen::Vector3d p_VO = X_CV.inverse() * kObject;
    EXPECT_NEAR((p_VO - Eigen::Vector3d(0.0, 0.0, 0.4)).norm(), 0.0, 1e-12);
    EXPECT_NEAR(X_CV.linear().determinant(), 1.0, 1e-12);
  }
}

TEST(TileView, StandsOnTheSideOfItsTile) {
  const Pose left = TileView(Tile::kLeft, kObject, 0.4);
  EXPECT_NEAR(left.translation().x(), -0.3, 1e-12);
  EXPECT_NEAR(left.linear().col(1).y(), 1.0, 1e-12);  // upright
  const Pose corner = TileView(Tile::kUpperRight, kObject, 0.4);
  EXPECT_NEAR(corner.translation().x(), 0.1 + 0.4 * std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(corner.translation().y(), -0.05 - 0.4 * std::sqrt(0.5), 1e-12);
  const Pose top = TileView(Tile::kTop, kObject, 0.4);
  EXPECT_NEAR(top.translation().y(), -0.45, 1e-12);
  EXPECT_NEAR(top.linear().col(1).z(), -1.0, 1e-12);  // what is near C is down
}

TEST(TileView, NamesWhatItCannotLookAt) {
  EXPECT_THROWS(TileView(Tile::kTop, {0.0, 0.0, -1.0}, 0.4), InvalidArgument,
                "is not before the camera");
  EXPECT_THROWS(TileView(Tile::kTop, kObject, 0.0), InvalidArgument, "a view from 0 m");
}

}  // namespace
}  // namespace secondlook::planning

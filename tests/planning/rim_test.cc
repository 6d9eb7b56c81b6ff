#include "lib/planning/rim.h"

#include <gtest/gtest.h>

#include "lib/planning/model_analysis.h"
#include "tests/support/analytic_scene.h"

namespace secondlook::planning {
namespace {

using Eigen::Vector3d;

constexpr geometry::CameraModel kCamera{640, 480, 577.0, 577.0, 319.5, 239.5};

/// Of a box of `size` [m] at the origin, seen along -x from `distance` [m] by every fourth pixel.
double InnerShareOf(const Vector3d& size, double distance) {
  const geometry::Mesh mesh = geometry::MakeBox(size, Eigen::Vector3f::Constant(0.5F));
  const geometry::RayCaster caster(mesh);
  const PosedModel model{&mesh, &caster};
  const Pose X_WC = testing::LookingAt({distance, 0.0, 0.0}, Vector3d::Zero());
  std::vector<BoxRay> rays;
  for (int v = 0; v < kCamera.height; v += 4) {
    for (int u = 0; u < kCamera.width; u += 4) {
      rays.push_back({X_WC.linear() * kCamera.Ray(u, v)});
    }
  }
  return InnerShare(model, kCamera, X_WC, rays, CastAt(model, X_WC, rays));
}

TEST(InnerShare, OfAThickThingIsNearlyAllOfIt) {
  // 58 pixels wide and high, 56 of them off the rim.
  EXPECT_NEAR(InnerShareOf({0.02, 0.1, 0.1}, 1.0), 56.0 * 56.0 / (58.0 * 58.0), 0.07);
}

TEST(InnerShare, OfAThingThinnerThanTwoRimsIsNone) {
  // 1.5 pixels high.
  EXPECT_EQ(InnerShareOf({0.002, 0.4, 0.004}, 1.5), 0.0);
}

TEST(InnerShare, GrowsAsTheCameraComesNear) {
  // A rod of 10 mm is 2.9 pixels high from 2 m, and 11.5 from 0.5 m.
  EXPECT_GT(InnerShareOf({0.01, 0.3, 0.01}, 0.5), InnerShareOf({0.01, 0.3, 0.01}, 2.0) + 0.2);
}

TEST(InnerShare, OfWhatNoRayHitsIsNone) { EXPECT_EQ(InnerShareOf({1e-4, 1e-4, 1e-4}, 1.0), 0.0); }

}  // namespace
}  // namespace secondlook::planning

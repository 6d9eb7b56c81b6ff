#include "apps/experiments/free_camera.h"

#include <string>

#include <gtest/gtest.h>

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;

sim::SceneObject Known(const std::string& name, double x, double y) {
  sim::SceneObject object;
  object.mesh = "sim/models/" + name + "/mesh.obj";
  object.name = name;
  object.position = {x, y};
  return object;
}

/// A large box with a can straight behind it as seen from -x.
sim::Scene BoxBeforeCan() {
  sim::Scene scene;
  scene.objects = {Known("oat_box", 0.0, 0.0), Known("soup_can", 0.15, 0.0)};
  return scene;
}

TEST(FreeCamera, SeesAllOfAThingThatStandsBeforeAllOthers) {
  FreeCamera camera(BoxBeforeCan(), 1);
  const Photo photo = camera.Take(LookAt({-0.9, 0.0, 0.95}, {0.0, 0.0, 0.85}));
  const std::vector<double> visible = camera.VisibleShares(photo);
  ASSERT_EQ(visible.size(), 2U);
  EXPECT_GT(visible[0], 0.95);
  EXPECT_LT(visible[1], 0.2);
  const std::vector<double> behind =
      camera.VisibleShares(camera.Take(LookAt({0.15, 0.9, 0.95}, {0.15, 0.0, 0.8})));
  EXPECT_GT(behind[1], 0.95);
}

TEST(FreeCamera, SeesHalfOfWhatThePictureCutsInTwo) {
  FreeCamera camera(BoxBeforeCan(), 1);
  // Turned so that the middle of the box is at the left border: half of the field of view, 29 deg.
  const Vector3d eye(-0.9, 0.0, 0.85);
  Pose X_WC = LookAt(eye, {0.0, 0.0, 0.85});
  X_WC.linear() = Eigen::AngleAxisd(-29.0 / 57.29578, Vector3d::UnitZ()) * X_WC.linear();
  EXPECT_NEAR(camera.VisibleShares(camera.Take(X_WC))[0], 0.5, 0.06);
}

TEST(FreeCamera, SeesNothingNearerThanTheDepthCameraMeasures) {
  FreeCamera camera(BoxBeforeCan(), 1);
  const Photo photo = camera.Take(LookAt({-0.4, 0.0, 0.95}, {0.0, 0.0, 0.85}));
  EXPECT_EQ(camera.VisibleShares(photo)[0], 0.0);
}

}  // namespace
}  // namespace secondlook::apps

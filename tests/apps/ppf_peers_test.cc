#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "apps/experiments/clutter.h"
#include "apps/experiments/ppf_peer.h"
#include "apps/experiments/random_scene.h"
#include "lib/perception/recognition_model.h"
#include "lib/world/object_database.h"

namespace secondlook::apps {
namespace {

std::vector<sim::SceneObject> Things() {
  Rng rng(1);
  return DrawObjects(LoadRepertoire("sim/models", "").known, 5, &rng);
}

TEST(DrawClutteredThing, ShowsMoreThanHalfOfAThingThatStandsWhereTheTruthSays) {
  const ClutteredThing thing = DrawClutteredThing(Things(), 7);
  EXPECT_GT(thing.visible, 0.5);
  ASSERT_GT(thing.cluster.pixels.size(), 200U);
  // The cluster lies about the thing's origin, which is in the middle of its base.
  EXPECT_LT((thing.cluster.center_C - thing.X_CM.translation()).norm(), 0.2);
}

TEST(DrawClutteredThing, DependsOnItsSeedAlone) {
  const ClutteredThing one = DrawClutteredThing(Things(), 7);
  const ClutteredThing two = DrawClutteredThing(Things(), 7);
  EXPECT_EQ(one.name, two.name);
  EXPECT_EQ(one.cluster.pixels, two.cluster.pixels);
  EXPECT_TRUE(one.X_CM.isApprox(two.X_CM));
  EXPECT_FALSE(one.X_CM.isApprox(DrawClutteredThing(Things(), 8).X_CM));
}

TEST(PpfPeer, FindsTheSideOfItsModelThatFacesTheCamera) {
  const auto database = world::ObjectDatabase::Load("sim/models");
  const perception::RecognitionModel model = perception::TrainModel(*database.Find("power_drill"));
  Pose X_CM = Pose::Identity();
  X_CM.linear() = RotationFromVector({0.4, -0.9, 1.7});
  X_CM.translation() << 0.1, -0.05, 0.8;
  std::vector<geometry::OrientedPoint> cloud_C;
  for (const perception::ModelPoint& point : model.points) {
    const Eigen::Vector3d p_C = X_CM * point.point.cast<double>();
    const Eigen::Vector3d n_C = X_CM.linear() * point.normal.cast<double>();
    if (n_C.dot(p_C) < 0.0) cloud_C.push_back({p_C.cast<float>(), n_C.cast<float>()});
  }
  const std::vector<PeerPose> poses = PpfPeer(model).Match(cloud_C, 5);
  ASSERT_EQ(poses.size(), 5U);
  EXPECT_GE(poses.front().votes, poses.back().votes);
  // Its ICP has the very points to align, so what the votes bring near ends at the truth.
  const auto best = std::min_element(
      poses.begin(), poses.end(),
      [](const PeerPose& a, const PeerPose& b) { return a.residual < b.residual; });
  EXPECT_LT((best->X_CM.translation() - X_CM.translation()).norm(), 1e-3);
  EXPECT_LT(RotationDistance(best->X_CM.linear(), X_CM.linear()), 1e-2);
}

TEST(PpfPeer, FindsNothingInAHandfulOfPoints) {
  const auto database = world::ObjectDatabase::Load("sim/models");
  const perception::RecognitionModel model = perception::TrainModel(*database.Find("mug"));
  const std::vector<geometry::OrientedPoint> cloud_C(
      9, {Eigen::Vector3f::UnitZ(), -Eigen::Vector3f::UnitZ()});
  EXPECT_TRUE(PpfPeer(model).Match(cloud_C, 5).empty());
}

}  // namespace
}  // namespace secondlook::apps

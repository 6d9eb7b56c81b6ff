#include "apps/exploration.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/experiments/free_camera.h"
#include "apps/experiments/pedestal.h"
#include "lib/common/error.h"
#include "lib/geometry/point_image.h"
#include "lib/perception/recognition_model.h"
#include "tests/support/expect_throws.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr Time kNow(Seconds(12.0));

/// A duck on a pedestal, and what views of it from all around have shown.
class Duck : public ::testing::Test {
 protected:
  Duck() : camera_(OnPedestal(TheDuck()), 3) {
    const double table = camera_.world().scene().table.height;
    belief_.plane_W.emplace();
    belief_.plane_W->offset = table;
    const sim::PlacedObject& duck = camera_.world().objects().at(0);
    for (const Eigen::Vector3f& p_M : duck.mesh.vertices) {
      box_W_.extend(duck.X_WM * p_M.cast<double>());
    }
    const Vector3d around(0.2, 0.2, 0.1);
    space_ = world::VoxelSpace({}, {box_W_.min() - around, box_W_.max() + around});
    belief_.objects.resize(1);
    belief_.objects[0].state = world::ObjectState::kUnknown;
  }

  static sim::SceneObject TheDuck() {
    sim::SceneObject object;
    object.mesh = "sim/unfamiliar/duck/mesh.obj";
    object.name = "duck";
    return object;
  }

  /// A view from `azimuth_deg` around, 40 degrees above, `distance` away, that errs by `error_W`
  /// [m].
  void See(double azimuth_deg, const Vector3d& error_W = Vector3d::Zero(), double distance = 0.75) {
    const double azimuth = azimuth_deg * std::numbers::pi / 180.0;
    const double up = 40.0 * std::numbers::pi / 180.0;
    const Vector3d middle_W = box_W_.center();
    const Pose X_WC =
        LookAt(middle_W + distance * Vector3d(std::cos(up) * std::cos(azimuth),
                                              std::cos(up) * std::sin(azimuth), std::sin(up)),
               middle_W);
    world::Observation view;
    view.frame = camera_.Take(X_WC).frame;
    view.camera = camera_.info().model;
    view.X_WC = Eigen::Translation3d(error_W) * X_WC;
    world::ObjectBelief& duck = belief_.objects[0];
    const geometry::PointImage cloud = geometry::Deproject(view.frame.depth, view.camera);
    for (std::size_t i = 0; i < cloud.points_C.size(); i += 7) {
      if (!geometry::IsMeasured(cloud.points_C[i])) continue;
      const Vector3d p_W = X_WC * cloud.points_C[i].cast<double>();
      if (!box_W_.contains(p_W) || belief_.plane_W->HeightOf(p_W) < 0.006) continue;
      duck.points_W.push_back(p_W);
      duck.extent_W.extend(p_W);
    }
    space_.Insert(view.frame.depth, view.camera, X_WC, 2);
    duck.sightings.push_back({static_cast<int>(belief_.views.size()), 0});
    belief_.views.push_back(std::move(view));
  }

  FreeCamera camera_;
  Eigen::AlignedBox3d box_W_;
  world::VoxelSpace space_;
  world::SceneBelief belief_;
};

TEST_F(Duck, IsScannedFromAllAroundUntilEnoughOfItIsSeen) {
  Exploration exploration({.coverage = 0.75}, {});
  See(0.0);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  const std::optional<ScanTarget> first = exploration.Target(belief_, space_);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->object, 0);
  EXPECT_EQ(first->scans, 1);
  // The other side shows more that is new than the same again.
  const auto shows = [&](double azimuth_deg) {
    const double azimuth = azimuth_deg * std::numbers::pi / 180.0;
    const Vector3d eye_W =
        box_W_.center() + Vector3d(0.6 * std::cos(azimuth), 0.6 * std::sin(azimuth), 0.4);
    return first->gain->Measure(camera_.info().model.Scaled(0.25), LookAt(eye_W, box_W_.center()))
        .new_surface;
  };
  EXPECT_GT(shows(120.0), 2.0 * shows(0.0));

  std::optional<ModelledThing> done;
  for (double azimuth = 60.0; azimuth < 360.0 && !done; azimuth += 60.0) {
    See(azimuth);
    done = exploration.Work(belief_, kNow);
  }
  ASSERT_TRUE(done);
  EXPECT_THAT(done->reason, HasSubstr("enough of it is seen"));
  EXPECT_EQ(done->model, "object_1");
  EXPECT_TRUE(done->refused.empty());
  EXPECT_GT(done->coverage.back(), done->coverage.front());
  EXPECT_EQ(done->scanned.provenance.finished, kNow);
  EXPECT_EQ(done->scanned.provenance.scans, static_cast<int>(done->coverage.size()));
  // What is stored is the duck, standing at its place.
  const Eigen::AlignedBox3d made_M = geometry::Bounds(done->scanned.mesh);
  EXPECT_NEAR(made_M.min().z(), 0.0, 0.003);
  EXPECT_LT((made_M.sizes() - box_W_.sizes()).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_LT((done->X_WM * made_M.center() - box_W_.center()).norm(), 0.01);
  EXPECT_LT(done->scanned.mesh.triangles.size(), done->scanned.full.triangles.size());
  EXPECT_EQ(done->scanned.mesh.vertex_colors.size(), done->scanned.mesh.vertices.size());
  EXPECT_NO_THROW(perception::TrainModel(AsModel(done->scanned)));
  EXPECT_FALSE(exploration.Work(belief_, kNow)) << "it is done with";
}

TEST_F(Duck, IsNoModelWhenLittleOfItWasSeen) {
  Exploration exploration({.least_coverage = 0.9}, {});
  See(0.0);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  const ModelledThing thing = exploration.Finish(belief_, "no scan adds anything", kNow);
  EXPECT_EQ(thing.model, "");
  EXPECT_THAT(thing.reason, HasSubstr("no scan adds anything; only "));
  EXPECT_THAT(thing.reason, HasSubstr("was seen in 1 scans, and a model wants 90 %"));
}

TEST_F(Duck, TakesANameThatNoOtherModelHas) {
  const world::ObjectDatabase known(
      {{"object_1", geometry::MakeBox({0.1, 0.1, 0.1}, {1.0, 1.0, 1.0}), 1}});
  Exploration exploration({.least_coverage = 0.1}, known);
  See(0.0);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  EXPECT_EQ(exploration.Finish(belief_, "", kNow).model, "object_2");
}

TEST_F(Duck, NeedsNoModelOnceItIsRecognisedOrGone) {
  Exploration exploration({}, {});
  See(0.0);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  belief_.objects[0].state = world::ObjectState::kRejected;
  belief_.objects[0].reason = "is gone from its place: view 3 sees through it";
  const std::optional<ModelledThing> thing = exploration.Work(belief_, kNow);
  ASSERT_TRUE(thing);
  EXPECT_EQ(thing->model, "");
  EXPECT_EQ(thing->reason,
            "is no longer unknown: it is gone from its place: view 3 sees through it");
  EXPECT_FALSE(exploration.Target(belief_, space_));
}

TEST_F(Duck, IsTooLargeForAModel) {
  Exploration exploration({.largest_m = 0.05}, {});
  See(0.0);
  const std::optional<ModelledThing> thing = exploration.Work(belief_, kNow);
  ASSERT_TRUE(thing);
  EXPECT_EQ(thing->model, "");
  EXPECT_THAT(thing->reason, HasSubstr("mission.modelling.largest_m = 0.05"));
}

TEST_F(Duck, KeepsClearOfScansThatWereRefused) {
  Exploration exploration({}, {});
  See(0.0);
  See(90.0, {0.0, 0.0, 0.06});  // its pose errs by far more than it is known to
  See(10.0, {0.0, 0.2, 0.0});   // the duck was moved
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  const std::optional<ScanTarget> target = exploration.Target(belief_, space_);
  ASSERT_TRUE(target);
  EXPECT_EQ(target->scans, 1);
  ASSERT_EQ(target->refused_W.size(), 2U);
  EXPECT_EQ(target->refused_W[0], belief_.views[1].X_WC.translation());
  const ModelledThing thing = exploration.Finish(belief_, "", kNow);
  ASSERT_EQ(thing.refused.size(), 2U);
  EXPECT_THAT(thing.refused[0], HasSubstr("view 1: "));
  EXPECT_THAT(thing.refused[1], HasSubstr("view 2: it sees through "));
}

TEST_F(Duck, IsScannedFirstFromNearbyWhateverTheOrderOfTheViews) {
  Exploration exploration({}, {});
  See(180.0, Vector3d::Zero(), 2.2);  // too far to measure much
  See(0.0);
  See(40.0);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  const ModelledThing thing = exploration.Finish(belief_, "", kNow);
  EXPECT_GE(thing.coverage.size(), 2U);
  EXPECT_THAT(thing.refused, ::testing::Not(::testing::Contains(HasSubstr("view 1: "))));
  EXPECT_THAT(thing.refused, ::testing::Not(::testing::Contains(HasSubstr("view 2: "))));
}

TEST_F(Duck, SeenFromOneSideIsWorthAScanFromTheOther) {
  Exploration exploration({}, {});
  for (double azimuth = -40.0; azimuth < 60.0; azimuth += 40.0) See(azimuth);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  const std::optional<ScanTarget> target = exploration.Target(belief_, space_);
  ASSERT_TRUE(target);
  const Vector3d behind_W = box_W_.center() + Vector3d(-0.6, 0.0, 0.4);
  const planning::ScanGain gain =
      target->gain->Measure(camera_.info().model.Scaled(0.25), LookAt(behind_W, box_W_.center()));
  EXPECT_GT(gain.new_surface, 0.1 * target->surface);
}

TEST_F(Duck, OfWhichOnlyOneSideCanBeReachedIsKeptAsThatSide) {
  Exploration exploration({.least_coverage = 0.3}, {});
  for (double azimuth = -40.0; azimuth < 60.0; azimuth += 40.0) See(azimuth);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  const ModelledThing thing = exploration.Finish(belief_, "no scan adds anything", kNow);
  EXPECT_EQ(thing.model, "object_1");
  EXPECT_LT(thing.scanned.provenance.coverage, 0.9);
  EXPECT_EQ(thing.scanned.provenance.coverage, thing.coverage.back());
  // No face stands for what nobody has seen: the far side's lower half is open.
  int behind = 0;
  for (const Eigen::Vector3f& vertex : thing.scanned.full.vertices) {
    const Vector3d p_W = thing.X_WM * vertex.cast<double>();
    behind += p_W.x() < box_W_.min().x() + 0.003 && p_W.z() < box_W_.center().z() ? 1 : 0;
  }
  EXPECT_EQ(behind, 0);
}

TEST_F(Duck, WhoseSurfaceReturnsNothingGetsNoModel) {
  Exploration exploration({}, {});
  See(0.0);
  belief_.views[0].frame.depth.setTo(0.0F);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  EXPECT_TRUE(exploration.Target(belief_, space_));
  const ModelledThing thing = exploration.Finish(belief_, "no scan adds anything", kNow);
  EXPECT_EQ(thing.model, "");
  EXPECT_THAT(thing.refused, ::testing::ElementsAre("view 0: it measured nothing there"));
  EXPECT_THAT(thing.reason, HasSubstr("only 0 % of it was seen in 0 scans"));
}

TEST_F(Duck, EndsWithTheBudgetOfScans) {
  Exploration exploration({.scans = 2, .least_coverage = 0.1}, {});
  for (double azimuth = 0.0; azimuth < 30.0; azimuth += 10.0) See(azimuth);
  ASSERT_FALSE(exploration.Work(belief_, kNow)) << "views for other things' sake are no scans";
  See(40.0);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  See(80.0);
  const std::optional<ModelledThing> thing = exploration.Work(belief_, kNow);
  ASSERT_TRUE(thing);
  EXPECT_THAT(thing->reason, HasSubstr("the budget of 2 scans for one thing is spent"));
  EXPECT_EQ(thing->model, "object_1");
}

TEST_F(Duck, IsNotRecognisedAnewAfterViewsInVain) {
  Exploration exploration({.recognition_failures = 2}, {});
  See(0.0);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  EXPECT_TRUE(exploration.NotToRecognise().empty());
  See(40.0);
  ASSERT_FALSE(exploration.Work(belief_, kNow));
  EXPECT_EQ(exploration.NotToRecognise(), std::set<int>{0});
}

TEST(Exploration, TakesTheLargestUnknownFirst) {
  world::SceneBelief belief;
  belief.plane_W.emplace();
  belief.objects.resize(3);
  for (int i = 0; i < 3; ++i) {
    belief.objects[i].id = i;
    belief.objects[i].state = world::ObjectState::kUnknown;
    const double half = i == 1 ? 0.1 : 0.05;
    belief.objects[i].extent_W = {Vector3d(i - half, -half, 0.0), Vector3d(i + half, half, half)};
  }
  Exploration exploration({}, {});
  EXPECT_FALSE(exploration.Work(belief, kNow));
  EXPECT_EQ(exploration.Finish(belief, "", kNow).object, 1);
}

TEST(ModellingConfig, NamesTheValueThatIsWrong) {
  EXPECT_NO_THROW(ModellingConfig{}.Validate());
  EXPECT_THROWS(ModellingConfig{.coverage = 1.2}.Validate(), ConfigError,
                "modelling.coverage = 1.2 must be a share: more than 0 and at most 1");
  EXPECT_THROWS(ModellingConfig{.scans = 0}.Validate(), ConfigError,
                "modelling.scans = 0 must be at least 1");
  EXPECT_THROWS(ModellingConfig{.largest_m = -1.0}.Validate(), ConfigError,
                "modelling.largest_m = -1 must be more than 0 and at most 2 m");
  EXPECT_THROWS(ModellingConfig{.strategy = "best"}.Validate(), ConfigError,
                "modelling.strategy = 'best'; it must be 'new surface', 'Kriegel', 'random' or "
                "'fixed step'");
}

}  // namespace
}  // namespace secondlook::apps

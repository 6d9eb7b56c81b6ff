#include "apps/scene_understanding.h"

#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/experiments/free_camera.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using testing::Contains;
using testing::HasSubstr;
using testing::Truly;
using world::ObjectBelief;
using world::ObjectState;

sim::SceneObject Known(const std::string& name, double x, double y, double yaw_deg) {
  sim::SceneObject object;
  object.mesh = "sim/models/" + name + "/mesh.obj";
  object.name = name;
  object.position = {x, y};
  object.yaw_deg = yaw_deg;
  return object;
}

world::ObjectDatabase Shipped(const std::vector<std::string>& names) {
  std::vector<world::ObjectModel> models;
  for (const std::string& name : names) models.push_back(world::ReadModel("sim/models/" + name));
  return world::ObjectDatabase(std::move(models));
}

/// A small table with `objects`, seen by a camera that knows where it is.
class Table {
 public:
  explicit Table(std::vector<sim::SceneObject> objects)
      : scene_(SceneWith(std::move(objects))), camera_(scene_, 1) {}

  Capture From(double azimuth_deg) {
    const double azimuth = azimuth_deg * 3.14159265 / 180.0;
    const Vector3d eye(0.85 * std::cos(azimuth), 0.85 * std::sin(azimuth), 1.3);
    const Photo photo = camera_.Take(LookAt(eye, {0.0, 0.0, 0.8}));
    return {"head", photo.frame, camera_.info().model, photo.X_WC, Vector3d(0.0, 0.0, -eye.z())};
  }

  Vector3d CenterOf(int index) const {
    const sim::PlacedObject& object = camera_.world().objects()[index];
    return object.X_WM * geometry::Bounds(object.mesh).center();
  }

 private:
  static sim::Scene SceneWith(std::vector<sim::SceneObject> objects) {
    sim::Scene scene;
    scene.table.size = {0.8, 0.6};
    scene.objects = std::move(objects);
    return scene;
  }

  sim::Scene scene_;
  FreeCamera camera_;
};

std::vector<const ObjectBelief*> Verified(const SceneUnderstanding& understanding,
                                          const std::string& model) {
  std::vector<const ObjectBelief*> verified;
  for (const ObjectBelief& object : understanding.belief().objects) {
    if (object.state == ObjectState::kVerified && object.Best()->model == model) {
      verified.push_back(&object);
    }
  }
  return verified;
}

/// How far the verified object's centre is from `p_W` [m].
double DistanceTo(const Vector3d& p_W, const ObjectBelief& object, const std::string& model) {
  const geometry::Mesh mesh = world::ReadModel("sim/models/" + model).mesh;
  return (object.Best()->X_WM * geometry::Bounds(mesh).center() - p_W).norm();
}

TEST(SceneUnderstanding, TellsTwoOfOneModelApartOverTheViews) {
  Table table({Known("tea_box", -0.1, 0.05, 20.0), Known("tea_box", 0.12, -0.05, 75.0)});
  SceneUnderstanding understanding({}, {}, Shipped({"tea_box", "mug"}));
  for (const double azimuth : {0.0, 80.0, 170.0, 260.0}) {
    ASSERT_EQ(understanding.Add(table.From(azimuth)), "");
  }
  const auto boxes = Verified(understanding, "tea_box");
  ASSERT_EQ(boxes.size(), 2U);
  for (const int i : {0, 1}) {
    EXPECT_LT(std::min(DistanceTo(table.CenterOf(i), *boxes[0], "tea_box"),
                       DistanceTo(table.CenterOf(i), *boxes[1], "tea_box")),
              0.01)
        << i;
  }
  for (const ObjectBelief* box : boxes) EXPECT_EQ(box->sightings.size(), 4U);
}

TEST(SceneUnderstanding, TellsTheTurnOfABowlByTheFewTrianglesThatDiffer) {
  // Turned by half, four of its eight triangles have the same colour.
  const SceneUnderstanding blank({}, {}, Shipped({"bowl", "tea_box"}));
  for (const double yaw_deg : {50.0, 150.0, 250.0}) {
    Table table({Known("bowl", 0.0, 0.0, yaw_deg)});
    SceneUnderstanding understanding = blank;
    ASSERT_EQ(understanding.Add(table.From(0.0)), "");
    const auto bowls = Verified(understanding, "bowl");
    ASSERT_EQ(bowls.size(), 1U) << yaw_deg << ": " << understanding.belief().objects.at(0).reason;
    EXPECT_LT(
        RotationDistance(bowls[0]->Best()->X_WM.linear(),
                         RotationFromRollPitchYaw(0.0, 0.0, yaw_deg * std::numbers::pi / 180.0)),
        0.05)
        << yaw_deg;
  }
}

TEST(SceneUnderstanding, CountsThreeCansOfOneModelOverTwoViews) {
  Table table({Known("soup_can", -0.15, 0.05, 0.0), Known("soup_can", 0.02, -0.08, 80.0),
               Known("soup_can", 0.16, 0.08, 200.0)});
  SceneUnderstanding understanding({}, {}, Shipped({"soup_can", "mug"}));
  for (const double azimuth : {20.0, 110.0}) ASSERT_EQ(understanding.Add(table.From(azimuth)), "");
  const auto cans = Verified(understanding, "soup_can");
  ASSERT_EQ(cans.size(), 3U);
  for (const int i : {0, 1, 2}) {
    EXPECT_THAT(cans, Contains(Truly([&](const ObjectBelief* can) {
                  return DistanceTo(table.CenterOf(i), *can, "soup_can") < 0.01;
                })))
        << i;
  }
}

TEST(SceneUnderstanding, TellsBoxesThatTouchApartInAllViews) {
  // Flush, the one turned end to end so that the print does not repeat.
  const double half = 0.5 * geometry::Bounds(Shipped({"tea_box"}).models()[0].mesh).sizes().x();
  Table table({Known("tea_box", -half, 0.0, 0.0), Known("tea_box", half, 0.0, 180.0)});
  SceneUnderstanding understanding({}, {}, Shipped({"tea_box", "mug"}));
  for (const double azimuth : {-70.0, 60.0, 110.0}) {
    ASSERT_EQ(understanding.Add(table.From(azimuth)), "");
  }
  const auto boxes = Verified(understanding, "tea_box");
  ASSERT_EQ(boxes.size(), 2U);
  for (const int i : {0, 1}) {
    EXPECT_THAT(boxes, Contains(Truly([&](const ObjectBelief* box) {
                  return DistanceTo(table.CenterOf(i), *box, "tea_box") < 0.01;
                })))
        << i;
  }
}

TEST(SceneUnderstanding, TellsThingsApartInTheViewsFromBeforeTheirModelWasKnown) {
  const world::ObjectDatabase tea = Shipped({"tea_box"});
  const double half = 0.5 * geometry::Bounds(tea.models()[0].mesh).sizes().x();
  Table table({Known("tea_box", -half, 0.0, 0.0), Known("tea_box", half, 0.0, 180.0)});
  SceneUnderstanding understanding({}, {}, Shipped({"mug"}));
  ASSERT_EQ(understanding.Add(table.From(-70.0)), "");
  ASSERT_EQ(understanding.belief().objects.size(), 1U);
  understanding.Learn(tea.models()[0]);
  ASSERT_EQ(understanding.Add(table.From(110.0)), "");
  const auto boxes = Verified(understanding, "tea_box");
  ASSERT_EQ(boxes.size(), 2U);
  for (const ObjectBelief* box : boxes) {
    EXPECT_EQ(box->sightings.size(), 2U) << "one in each view";
    EXPECT_LT(box->extent_W.sizes().x(), 3.0 * half);
  }
}

TEST(SceneUnderstanding, KeepsTheIdentityOfWhatWasMovedBetweenLooks) {
  const std::vector<std::string> names{"tea_box", "mug", "soup_can"};
  Table before({Known("tea_box", -0.2, 0.0, 20.0), Known("mug", 0.15, 0.15, 0.0),
                Known("soup_can", 0.2, -0.15, 0.0)});
  Table after({Known("tea_box", -0.02, -0.18, 65.0), Known("mug", 0.15, 0.15, 0.0),
               Known("soup_can", 0.2, -0.15, 0.0)});
  SceneUnderstanding understanding({}, {}, Shipped(names));
  for (const double azimuth : {0.0, 80.0, 200.0}) {
    ASSERT_EQ(understanding.Add(before.From(azimuth)), "");
  }
  ASSERT_EQ(Verified(understanding, "tea_box").size(), 1U);
  const int id = Verified(understanding, "tea_box")[0]->id;
  EXPECT_EQ(understanding.space().At(before.CenterOf(0)), world::Occupancy::kOccupied);

  for (const double azimuth : {30.0, 120.0, 240.0}) {
    ASSERT_EQ(understanding.Add(after.From(azimuth)), "");
  }
  EXPECT_NE(understanding.space().At(before.CenterOf(0)), world::Occupancy::kOccupied);
  const auto boxes = Verified(understanding, "tea_box");
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_EQ(boxes[0]->id, id);
  // 0.18 sqrt(2) = 0.255 m, less what the poses err.
  EXPECT_THAT(boxes[0]->reason,
              ::testing::ContainsRegex("; was moved by 0\\.2[456] m before view 3"));
  EXPECT_LT(DistanceTo(after.CenterOf(0), *boxes[0], "tea_box"), 0.01);
  EXPECT_EQ(understanding.space().At(after.CenterOf(0)), world::Occupancy::kOccupied);
  for (const char* still : {"mug", "soup_can"}) {
    EXPECT_EQ(Verified(understanding, still).size(), 1U) << still;
  }
}

TEST(SceneUnderstanding, DeclaresNewWhatStandsFarFromAnyThatIsGone) {
  const std::vector<std::string> names{"tea_box", "mug", "soup_can"};
  const auto with_box = [&](double x, double y) {
    return Table({Known("tea_box", x, y, 20.0), Known("mug", 0.15, 0.15, 0.0),
                  Known("soup_can", 0.2, -0.15, 0.0)});
  };
  Table before = with_box(-0.25, -0.1);
  Table after = with_box(-0.25, 0.15);
  UnderstandingConfig config;
  config.moved_within_m = 0.2;
  SceneUnderstanding understanding(config, {}, Shipped(names));
  for (const double azimuth : {0.0, 80.0, 200.0}) {
    ASSERT_EQ(understanding.Add(before.From(azimuth)), "");
  }
  ASSERT_EQ(Verified(understanding, "tea_box").size(), 1U);
  const int id = Verified(understanding, "tea_box")[0]->id;
  for (const double azimuth : {30.0, 120.0, 240.0}) {
    ASSERT_EQ(understanding.Add(after.From(azimuth)), "");
  }
  EXPECT_EQ(understanding.belief().objects[id].state, ObjectState::kRejected);
  EXPECT_EQ(understanding.belief().objects[id].reason,
            "is gone from its place: view 3 sees through it");
  const auto boxes = Verified(understanding, "tea_box");
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_NE(boxes[0]->id, id);
  EXPECT_THAT(boxes[0]->reason, HasSubstr("is new: the 'tea_box' that is gone stood 0.25 m away"));
}

TEST(SceneUnderstanding, BelievesNoViewThatSeesThroughMostOfWhatStandsThere) {
  const std::vector<std::string> names{"tea_box", "mug", "soup_can"};
  Table table({Known("tea_box", -0.2, 0.0, 20.0), Known("mug", 0.15, 0.15, 0.0),
               Known("soup_can", 0.2, -0.15, 0.0)});
  Table cleared({});
  SceneUnderstanding understanding({}, {}, Shipped(names));
  for (const double azimuth : {0.0, 80.0}) {
    ASSERT_EQ(understanding.Add(table.From(azimuth)), "");
  }
  EXPECT_THAT(understanding.Add(cleared.From(150.0)),
              HasSubstr("it sees through verified objects"));
  EXPECT_EQ(understanding.belief().views.size(), 2U);
  EXPECT_EQ(Verified(understanding, "tea_box").size(), 1U);
}

TEST(SceneUnderstanding, RegistersAViewFromBehindByWhatItRecognises) {
  sim::Scene scene;  // a box alone on a plinth: the two views have hardly a surface in common
  scene.table.size = {0.5, 0.5};
  scene.table.height = 0.95;
  scene.table.solid = true;
  scene.objects = {Known("tea_box", 0.0, 0.0, 20.0)};
  FreeCamera camera(scene, 1);
  SceneUnderstanding understanding({}, {}, Shipped({"tea_box", "mug"}));
  const auto capture = [&](double azimuth_deg, const Pose& error) {
    const double azimuth = azimuth_deg * 3.14159265 / 180.0;
    const Vector3d eye(1.1 * std::cos(azimuth), 1.1 * std::sin(azimuth), 1.15);
    const Photo photo = camera.Take(LookAt(eye, {0.0, 0.0, 1.0}));
    return Capture{"camera", photo.frame, camera.info().model, error * photo.X_WC,
                   Vector3d(0.0, 0.0, -eye.z())};
  };
  ASSERT_EQ(understanding.Add(capture(0.0, Pose::Identity())), "");
  Pose error = Pose::Identity();  // 36 mm
  error.translation() = Vector3d(-0.03, 0.02, 0.0);
  const Capture behind = capture(170.0, error);
  ASSERT_EQ(understanding.Add(behind), "");
  const Pose& X_WC = understanding.belief().views[1].X_WC;
  const Vector3d p_CO = (error.inverse() * behind.X_WC).inverse() * Vector3d(0.0, 0.0, 1.0);
  EXPECT_LT((X_WC * p_CO - Vector3d(0.0, 0.0, 1.0)).norm(), 0.008);
}

}  // namespace
}  // namespace secondlook::apps

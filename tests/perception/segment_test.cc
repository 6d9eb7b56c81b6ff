#include "lib/perception/segment.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// A cloud without image order, z up, seen by a camera at the origin that looks along x.
class SceneCloud {
 public:
  SceneCloud() { cloud_.height = 1; }

  /// Adds a rectangle of points 4 mm apart spanned by two edges from a corner, with noise.
  SceneCloud& Rectangle(const Vector3d& corner, const Vector3d& a, const Vector3d& b) {
    const int rows = static_cast<int>(a.norm() / 0.004);
    const int columns = static_cast<int>(b.norm() / 0.004);
    for (int i = 0; i <= rows; ++i) {
      for (int j = 0; j <= columns; ++j) {
        Add(corner + a * i / rows + b * j / columns);
      }
    }
    return *this;
  }

  /// Adds the top and the front of a box whose bottom centre is at `p`.
  SceneCloud& Box(const Vector3d& p, const Vector3d& size) {
    const Vector3d low = p - Vector3d(size.x() / 2, size.y() / 2, 0);
    Rectangle(low + Vector3d(0, 0, size.z()), {size.x(), 0, 0}, {0, size.y(), 0});
    return Rectangle(low, {0, size.y(), 0}, {0, 0, size.z()});
  }

  /// Adds what the camera sees of a bowl open upwards, half a ball, but for what it sees askance.
  SceneCloud& Bowl(const Vector3d& center, double radius) {
    for (double tilt = 0.05; tilt < 1.57; tilt += 0.02) {
      for (double turn = 0.0; turn < 6.28; turn += 0.02) {
        const Vector3d n(std::cos(tilt) * std::cos(turn), std::cos(tilt) * std::sin(turn),
                         -std::sin(tilt));
        const Vector3d p = center + radius * n;
        const Vector3d to_camera = -p.normalized();
        const double cosine = n.dot(to_camera);
        if (std::abs(cosine) < 0.12) continue;
        // From the inside, the ray to the camera leaves the ball through its open half.
        const Vector3d exit = p - 2.0 * radius * cosine * to_camera;
        if (cosine > 0.0 || exit.z() > center.z()) Add(p);
      }
    }
    return *this;
  }

  /// x forward, z up to the camera frame (z forward, y down).
  static Vector3d Rotated(const Vector3d& p) { return {-p.y(), -p.z(), p.x()}; }

  const geometry::PointImage& cloud() const { return cloud_; }

 private:
  void Add(Vector3d p) {
    p += Vector3d(rng_.Gaussian(0.001), rng_.Gaussian(0.001), rng_.Gaussian(0.001));
    cloud_.points_C.push_back(Rotated(p).cast<float>());
    ++cloud_.width;
  }

  Rng rng_{3};
  geometry::PointImage cloud_;
};

const Vector3d kUp = SceneCloud::Rotated(Vector3d::UnitZ());

SceneCloud TableWithFloorAndWall() {
  SceneCloud scene;
  scene.Rectangle({0.8, -0.4, -0.5}, {0.6, 0, 0}, {0, 0.8, 0});  // table, 0.5 m below the camera
  scene.Rectangle({0.3, -1.0, -1.2}, {2.0, 0, 0}, {0, 2.0, 0});  // floor, larger
  scene.Rectangle({2.2, -1.0, -1.2}, {0, 2.0, 0}, {0, 0, 2.0});  // wall
  return scene;
}

TEST(Segment, TakesTheTableAndNeitherTheFloorNorTheWall) {
  SceneCloud scene = TableWithFloorAndWall();
  const Segmentation result = Segment(scene.cloud(), kUp, {});
  ASSERT_TRUE(result.plane_C) << result.reason;
  EXPECT_NEAR(result.plane_C->normal_A.dot(kUp), 1.0, 1e-3);
  EXPECT_NEAR(result.plane_C->offset, -0.5, 0.002);
  const auto& c = result.plane_C->corners_A;
  const double a = (c[1] - c[0]).norm();
  const double b = (c[2] - c[1]).norm();
  EXPECT_NEAR(std::min(a, b), 0.6, 0.02);
  EXPECT_NEAR(std::max(a, b), 0.8, 0.02);
  EXPECT_GT((c[1] - c[0]).cross(c[2] - c[1]).dot(kUp), 0.0) << "counter-clockwise from above";
}

TEST(Segment, FindsEachThingThatStandsOnTheTable) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Box({1.0, 0.1, -0.5}, {0.1, 0.1, 0.15}).Box({1.1, -0.2, -0.5}, {0.1, 0.1, 0.1});
  const Segmentation result = Segment(scene.cloud(), kUp, {});
  ASSERT_EQ(result.clusters.size(), 2U) << result.reason;
  // The larger first. The means of top and front lie within the boxes.
  const Vector3d tall = SceneCloud::Rotated({1.0, 0.1, -0.4});
  EXPECT_LT((result.clusters[0].center_C - tall).norm(), 0.06);
  EXPECT_EQ(result.clusters[0].pixels.size(), result.clusters[0].points_C.size());
}

TEST(Segment, SeparatesThingsTwoCentimetresApartAndJoinsThoseThatStandFlush) {
  SceneCloud apart = TableWithFloorAndWall();
  apart.Box({1.0, 0.0, -0.5}, {0.1, 0.1, 0.1}).Box({1.0, 0.12, -0.5}, {0.1, 0.1, 0.1});
  EXPECT_EQ(Segment(apart.cloud(), kUp, {}).clusters.size(), 2U);
  SceneCloud touching = TableWithFloorAndWall();
  touching.Box({1.0, 0.0, -0.5}, {0.1, 0.1, 0.1}).Box({1.0, 0.1, -0.5}, {0.1, 0.1, 0.1});
  EXPECT_EQ(Segment(touching.cloud(), kUp, {}).clusters.size(), 1U);
}

SegmentConfig WithoutSplitting() {
  SegmentConfig config;
  config.split_touching = false;
  return config;
}

TEST(Segment, TellsAThingFromTheOneItStandsOn) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Rectangle({0.875, -0.125, -0.5}, {0, 0.25, 0}, {0, 0, 0.08});    // a flat box, its front,
  scene.Rectangle({0.875, -0.125, -0.42}, {0.125, 0, 0}, {0, 0.25, 0});  // what is seen of its top,
  scene.Box({1.05, 0.0, -0.42}, {0.1, 0.1, 0.12});                       // and a box on it
  EXPECT_EQ(Segment(scene.cloud(), kUp, WithoutSplitting()).clusters.size(), 1U);
  const Segmentation result = Segment(scene.cloud(), kUp, {});
  ASSERT_EQ(result.clusters.size(), 2U);
  // Fronts and tops of 25 x 8 + 25 x 12.5 and of 10 x 12 + 10 x 10 cm.
  const double lower = static_cast<double>(result.clusters[0].pixels.size());
  EXPECT_NEAR(lower / static_cast<double>(result.clusters[1].pixels.size()), 512.5 / 220.0, 0.3);
}

TEST(Segment, KeepsAHandleWithItsThing) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Box({1.0, 0.0, -0.5}, {0.1, 0.1, 0.12});
  scene.Rectangle({0.9, -0.01, -0.43}, {0.05, 0, 0}, {0, 0.02, 0});  // a bar that sticks out
  EXPECT_EQ(Segment(scene.cloud(), kUp, {}).clusters.size(), 1U);
}

TEST(Segment, JoinsTheInsideOfABowlToItsOutside) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Bowl({1.0, 0.0, -0.42}, 0.08);
  EXPECT_EQ(Segment(scene.cloud(), kUp, WithoutSplitting()).clusters.size(), 2U);
  EXPECT_EQ(Segment(scene.cloud(), kUp, {}).clusters.size(), 1U);
}

TEST(Segment, LeavesApartABoxOfEqualHeightBehindABowl) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Bowl({1.0, 0.0, -0.42}, 0.08).Box({1.15, 0.0, -0.5}, {0.1, 0.1, 0.08});
  EXPECT_EQ(Segment(scene.cloud(), kUp, {}).clusters.size(), 2U);
}

TEST(Segment, TakesATableThatLeansALittleAgainstTheFloor) {
  SceneCloud scene;
  scene.Rectangle({0.3, -1.0, -1.2}, {2.0, 0, 0}, {0, 2.0, 0});
  scene.Rectangle({0.8, -0.2, -0.5}, {0.4, 0, 0.04}, {0, 0.4, 0});  // 5.7 deg
  const Segmentation result = Segment(scene.cloud(), kUp, {});
  ASSERT_TRUE(result.plane_C) << result.reason;
  EXPECT_NEAR(result.plane_C->normal_A.dot(kUp), std::cos(std::atan(0.1)), 1e-3);
}

TEST(Segment, LeavesOutWhatStandsBesideTheTable) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Box({1.6, 0.0, -1.2}, {0.2, 0.2, 0.9});  // a chair behind it, higher than the table
  const Segmentation result = Segment(scene.cloud(), kUp, {});
  EXPECT_TRUE(result.clusters.empty());
  EXPECT_THAT(result.reason, testing::HasSubstr("nothing stands on the support plane"));
}

TEST(Segment, IgnoresTheFloorWhereTheCameraHeightIsKnown) {
  SceneCloud scene;
  scene.Rectangle({0.3, -1.0, -1.2}, {2.0, 0, 0}, {0, 2.0, 0});
  EXPECT_TRUE(Segment(scene.cloud(), kUp, {}).plane_C);
  const Segmentation result = Segment(scene.cloud(), kUp, {}, 1.0);
  EXPECT_FALSE(result.plane_C);
  EXPECT_THAT(result.reason, testing::HasSubstr("no support plane"));
}

TEST(Segment, TakesTheTableAndNotAHigherCrateWhereTheFloorIsOut) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Rectangle({0.8, 0.6, -0.35}, {0.3, 0, 0}, {0, 0.3, 0});  // the top of a crate
  const Segmentation result = Segment(scene.cloud(), kUp, {}, 1.0);
  ASSERT_TRUE(result.plane_C) << result.reason;
  EXPECT_NEAR(result.plane_C->offset, -0.5, 0.005);
}

TEST(Segment, TakesTheFarTableAndNotTheNearerTopOfALowerCrate) {
  // A plane that leans from one to the other has more points than either: with the first crate a
  // part of the table's, with the second all.
  struct Distances {
    double crate_height, table_x, table_depth;
  };
  for (const Distances& d : {Distances{-0.56, 1.2, 0.8}, Distances{-0.525, 1.5, 0.6}}) {
    SceneCloud scene;
    for (int i = 0; i < 8; ++i) {
      scene.Rectangle({0.5, -0.7, d.crate_height}, {0.4, 0, 0}, {0, 0.4, 0});
    }
    scene.Rectangle({d.table_x, -0.4, -0.5}, {d.table_depth, 0, 0}, {0, 1.2, 0});
    const Segmentation result = Segment(scene.cloud(), kUp, {}, 1.0);
    ASSERT_TRUE(result.plane_C) << result.reason;
    EXPECT_NEAR(result.plane_C->offset, -0.5, 0.005) << "crate at " << d.crate_height;
    EXPECT_NEAR(result.plane_C->normal_A.dot(kUp), 1.0, 1e-4);
  }
}

/// Which of the result's planes is at `height`; -1: none.
int PlaneAt(const Segmentation& result, double height) {
  const std::vector<world::SupportPlane> planes = result.Planes();
  for (std::size_t k = 0; k < planes.size(); ++k) {
    if (std::abs(planes[k].offset - height) < 0.005) return static_cast<int>(k);
  }
  return -1;
}

/// Which plane the cluster nearest to `p` stands on.
int PlaneOfThingAt(const Segmentation& result, const Vector3d& p) {
  int plane = -1;
  double nearest = 0.07;
  for (std::size_t i = 0; i < result.clusters.size(); ++i) {
    const double distance = (result.clusters[i].center_C - SceneCloud::Rotated(p)).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    plane = result.stands_on[i];
  }
  return plane;
}

TEST(Segment, FindsTwoTablesAndAShelfAndWhatStandsOnEach) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Rectangle({1.55, -0.4, -0.65}, {0.5, 0, 0}, {0, 0.8, 0});  // a lower table behind it
  scene.Rectangle({1.15, 0.0, -0.2}, {0.25, 0, 0}, {0, 0.4, 0});   // a shelf over the table
  scene.Box({0.95, -0.2, -0.5}, {0.1, 0.1, 0.15});
  scene.Box({1.7, 0.1, -0.65}, {0.1, 0.1, 0.12});
  scene.Box({1.25, 0.2, -0.2}, {0.08, 0.08, 0.1});
  const Segmentation result = Segment(scene.cloud(), kUp, {}, 0.9);
  EXPECT_EQ(result.further.size(), 2U);
  const int table = PlaneAt(result, -0.5);
  const int lower = PlaneAt(result, -0.65);
  const int shelf = PlaneAt(result, -0.2);
  EXPECT_EQ(table, 0);
  ASSERT_GT(lower, 0);
  ASSERT_GT(shelf, 0);
  EXPECT_EQ(PlaneOfThingAt(result, {0.93, -0.2, -0.4}), table);
  EXPECT_EQ(PlaneOfThingAt(result, {1.68, 0.1, -0.57}), lower);
  EXPECT_EQ(PlaneOfThingAt(result, {1.23, 0.2, -0.13}), shelf);
  const world::SupportPlane patch = result.Planes()[static_cast<std::size_t>(lower)];
  EXPECT_NEAR((patch.corners_A[1] - patch.corners_A[0]).norm() +
                  (patch.corners_A[2] - patch.corners_A[1]).norm(),
              0.5 + 0.8, 0.04);
}

TEST(Segment, TakesTheLowestOfSeveralPlanesForTheFloorWhereTheHeightIsNotKnown) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Rectangle({1.55, -0.4, -0.65}, {0.5, 0, 0}, {0, 0.8, 0});
  const Segmentation result = Segment(scene.cloud(), kUp, {});
  EXPECT_EQ(PlaneAt(result, -0.5), 0);
  EXPECT_EQ(PlaneAt(result, -0.65), 1);
  EXPECT_EQ(PlaneAt(result, -1.2), -1);
}

TEST(Segment, TellsWhatStandsOnALargeBoxFromTheBox) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Box({1.1, 0.0, -0.5}, {0.3, 0.3, 0.2}).Box({1.1, 0.0, -0.3}, {0.08, 0.08, 0.08});
  const Segmentation result = Segment(scene.cloud(), kUp, {}, 0.9);
  ASSERT_EQ(result.clusters.size(), 2U);
  EXPECT_EQ(result.stands_on[0], 0) << "the box is still a thing on the table";
  EXPECT_EQ(result.stands_on[1], PlaneAt(result, -0.3));
}

TEST(PutFirst, KeepsToTheTableThatIsKnownAlready) {
  SceneCloud scene = TableWithFloorAndWall();
  scene.Rectangle({1.5, -0.6, -0.65}, {0.55, 0, 0}, {0, 1.2, 0});
  scene.Box({1.0, 0.0, -0.5}, {0.1, 0.1, 0.1});
  Segmentation result = Segment(scene.cloud(), kUp, {}, 0.9);
  ASSERT_EQ(PlaneAt(result, -0.65), 0) << "the larger";
  Pose X_WC = Pose::Identity();
  X_WC.linear().col(0) = -Vector3d::UnitY();
  X_WC.linear().col(1) = -Vector3d::UnitZ();
  X_WC.linear().col(2) = Vector3d::UnitX();
  world::SupportPlane known_W;
  known_W.offset = -0.49;
  PutFirst(known_W, X_WC, &result);
  EXPECT_EQ(PlaneAt(result, -0.5), 0);
  EXPECT_EQ(PlaneAt(result, -0.65), 1);
  ASSERT_EQ(result.clusters.size(), 1U);
  EXPECT_EQ(result.stands_on[0], 0);
  known_W.offset = -0.3;  // none is there
  PutFirst(known_W, X_WC, &result);
  EXPECT_EQ(PlaneAt(result, -0.5), 0);
}

TEST(Segment, SaysWhyThereIsNoPlaneWhereThereIsOnlyAWall) {
  SceneCloud scene;
  scene.Rectangle({1.5, -1.0, -1.0}, {0, 2.0, 0}, {0, 0, 2.0});
  const Segmentation result = Segment(scene.cloud(), kUp, {});
  EXPECT_FALSE(result.plane_C);
  EXPECT_THAT(result.reason, testing::HasSubstr("no support plane: of the planes within 10 deg"));
}

TEST(Segment, SurvivesAnEmptyCloudOnePointAndNothingButNaN) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& points : {std::vector<Vector3f>{}, std::vector<Vector3f>{{0, 0, 1}},
                             std::vector<Vector3f>(1000, Vector3f::Constant(nan)),
                             std::vector<Vector3f>(1000, Vector3f::Zero())}) {
    const geometry::PointImage cloud{static_cast<int>(points.size()), 1, points};
    const Segmentation result = Segment(cloud, kUp, {});
    EXPECT_FALSE(result.plane_C);
    EXPECT_FALSE(result.reason.empty());
  }
}

TEST(Segment, RefusesMillimetresTakenForMetres) {
  geometry::PointImage cloud{100, 1, std::vector<Vector3f>(100, Vector3f(10, 20, 900))};
  EXPECT_THROWS(Segment(cloud, kUp, {}), InvalidArgument, "median distance is 900.3 m");
  cloud.points_C.assign(100, Vector3f(0.0F, 0.0F, 0.001F));
  EXPECT_THROWS(Segment(cloud, kUp, {}), InvalidArgument, "nearer than any depth camera sees");
}

TEST(SegmentConfig, SaysWhichValueIsOutOfRange) {
  EXPECT_NO_THROW(SegmentConfig{}.Validate());
  const auto with = [](auto set) {
    SegmentConfig config;
    set(&config);
    return config;
  };
  EXPECT_THROWS(with([](auto* c) { c->max_tilt_deg = 0.0; }).Validate(), ConfigError,
                "max_tilt_deg = 0 must lie in 0 to 90");
  EXPECT_THROWS(with([](auto* c) { c->cluster_gap_m = -0.01; }).Validate(), ConfigError,
                "cluster_gap_m = -0.01 must be greater than 0");
  EXPECT_THROWS(with([](auto* c) { c->min_height_m = 0.7; }).Validate(), ConfigError,
                "max_height_m = 0.6 above it");
  EXPECT_THROWS(with([](auto* c) { c->edge_clearance_m = -1.0; }).Validate(), ConfigError,
                "must not be negative");
  EXPECT_THROWS(with([](auto* c) { c->split.crease_deg = 200.0; }).split.Validate(), ConfigError,
                "crease_deg = 200 must lie between 0 and 180");
  EXPECT_THROWS(with([](auto* c) { c->split.window_m = 1.0; }).split.Validate(), ConfigError,
                "window_m = 1 must lie in 0.004 to 0.1");
}

TEST(Segment, RefusesAnUpThatIsNoDirection) {
  EXPECT_THROWS(Segment({}, Vector3d::Zero(), {}), InvalidArgument, "must be a direction");
}

}  // namespace
}  // namespace secondlook::perception

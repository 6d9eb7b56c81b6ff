#include "lib/planning/motion/plan_motion.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/motion/arm_rig.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The arm in a map, in whose frame it stands at the origin.
ArmCollision CollisionIn(const world::VoxelSpace& space, const VectorXd& start,
                         const ObstacleConfig& config = {}) {
  const kinematics::Chain arm = SimulatedArm();
  return {arm, Pose::Identity(),
          ObstaclesAround({-0.05, -0.1, 0.7}, ReachOf(arm), space, {}, arm.Body(start), config)};
}

PlannedMotion Plan(const ArmCollision& collision, const VectorXd& start, const VectorXd& goal,
                   std::uint64_t seed = 1, const MotionConfig& config = {}) {
  return PlanMotion(collision, JointsOf(collision.chain(), 2.5), start, goal, seed, config);
}

/// Checks a trajectory densely without FCL: the bodies against the centres of all occupied voxels,
/// against the floor, and the surfaces of links against other links not next to them.
class DenseCheck {
 public:
  DenseCheck(const kinematics::Chain& arm, std::vector<Vector3d> voxels_W)
      : arm_(arm), voxels_W_(std::move(voxels_W)) {
    const auto& links = arm_.model().links;
    for (std::size_t l = 0; l < links.size(); ++l) {
      for (const auto& part : links[l].body) {
        link_.push_back(static_cast<int>(l));
        surface_.push_back(geometry::MakeMesh(part.shape, 12, {0, 0, 0}).vertices);
      }
    }
  }

  /// The least distance from the arm to any voxel's centre and the floor [m].
  double ToObstacles(const VectorXd& q) const {
    const auto body = arm_.Body(q);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < body.size(); ++i) {
      if (!arm_.Moves(link_[i])) continue;
      const double radius = geometry::BoundingRadius(body[i].shape);
      const Pose X_SW = body[i].X_AS.inverse();
      for (const Vector3d& p_W : voxels_W_) {
        if ((p_W - body[i].X_AS.translation()).norm() > radius + 0.1) continue;
        least = std::min(least, geometry::Distance(body[i].shape, X_SW * p_W));
      }
      for (const auto& p_SV : surface_[i]) {
        least = std::min(least, (body[i].X_AS * p_SV.cast<double>()).z());
      }
    }
    return least;
  }

  /// The names of two links that meet, or nothing.
  std::string MeetingLinks(const VectorXd& q) const {
    const auto body = arm_.Body(q);
    for (std::size_t a = 0; a < body.size(); ++a) {
      for (std::size_t b = 0; b < body.size(); ++b) {
        if (MayTouch(link_[a], link_[b]) || MayTouch(link_[b], link_[a])) continue;
        const Pose X_BA = body[b].X_AS.inverse() * body[a].X_AS;
        for (const auto& p_AV : surface_[a]) {
          if (geometry::Distance(body[b].shape, X_BA * p_AV.cast<double>()) > 0.0) continue;
          return arm_.model().links[link_[a]].name + " and " + arm_.model().links[link_[b]].name;
        }
      }
    }
    return "";
  }

 private:
  /// At most one revolute joint on the way up from `link` to `above`.
  bool MayTouch(int link, int above) const {
    const auto& links = arm_.model().links;
    int joints = 0;
    for (int l = link; l >= 0; l = links[l].parent) {
      // The two may also hang rigidly on one link.
      int up = above;
      while (up > 0 && !links[up].joint.turns) up = links[up].parent;
      if (l == up) return joints <= 1;
      joints += links[l].joint.turns ? 1 : 0;
    }
    return false;
  }

  kinematics::Chain arm_;
  std::vector<Vector3d> voxels_W_;
  std::vector<int> link_;
  std::vector<std::vector<Eigen::Vector3f>> surface_;
};

const VectorXd kHome = Degrees({80, 45, 0, 112, 0, -105, 120});
const VectorXd kLeft = Degrees({60, 60, 0, -40, 0, 40, 0});
const VectorXd kRight = Degrees({-60, 60, 0, -40, 0, 40, 0});

TEST(ArmCollision, TheFoldedArmTouchesNothingAndStaysWithinItsBase) {
  const ArmCollision collision = CollisionIn(world::VoxelSpace(), kHome);
  EXPECT_EQ(collision.Touches(kHome), std::nullopt);
  const DenseCheck check(SimulatedArm(), {});
  EXPECT_EQ(check.MeetingLinks(kHome), "");
  for (const auto& part : SimulatedArm().Body(kHome)) {
    for (const auto& p_SV : geometry::MakeMesh(part.shape, 24, {0, 0, 0}).vertices) {
      const Vector3d p_B = part.X_AS * p_SV.cast<double>();
      EXPECT_LE(p_B.head<2>().norm(), 0.28);
      EXPECT_LE(p_B.z(), 1.32);
    }
  }
}

TEST(ArmCollision, NamesTheLinksThatMeet) {
  const ArmCollision collision = CollisionIn(FreeSpace(), kHome);
  // Folded down at the back, onto the mast.
  const auto touch = collision.Touches(Degrees({146, 20, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(touch);
  EXPECT_THAT(*touch, ::testing::StartsWith("link 'base' with link 'link_"));
}

TEST(ArmCollision, NamesWhatItMeetsAndWhere) {
  world::VoxelSpace space = FreeSpace();
  Occupy({Vector3d(0.4, -0.2, 0.6), Vector3d(0.5, 0.0, 0.8)}, &space);
  const ArmCollision collision = CollisionIn(space, kHome);
  const auto touch = collision.Touches(Degrees({0, 90, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(touch);
  EXPECT_THAT(*touch, ::testing::HasSubstr("with occupied space at (0.4"));
}

TEST(ArmCollision, AgreesWithTheDenseCheckInRandomPostures) {
  world::VoxelSpace space = FreeSpace();
  const auto voxels = Occupy({Vector3d(0.3, -0.4, 0.5), Vector3d(0.6, 0.2, 0.9)}, &space);
  const ArmCollision collision = CollisionIn(space, kHome);
  const DenseCheck check(SimulatedArm(), voxels);
  Rng rng(8);
  int free = 0;
  int touching = 0;
  for (int i = 0; i < 300; ++i) {
    VectorXd q(7);
    for (int j = 0; j < 7; ++j) {
      q[j] = rng.Uniform(collision.chain().joint(j).lower, collision.chain().joint(j).upper);
    }
    const double distance = check.ToObstacles(q);
    const bool meets = !check.MeetingLinks(q).empty();
    if (meets || distance < 0.02) {  // the clearance is 0.03
      EXPECT_FALSE(collision.Free(q));
      ++touching;
    } else if (collision.Free(q)) {
      ++free;
    }
    EXPECT_EQ(collision.Free(q), !collision.Touches(q).has_value());
  }
  EXPECT_GT(free, 30);
  EXPECT_GT(touching, 30);
}

TEST(PlanMotion, GoesStraightWhereNothingIsInTheWay) {
  const ArmCollision collision = CollisionIn(FreeSpace(), kLeft);
  const PlannedMotion motion = Plan(collision, kLeft, kRight);
  ASSERT_EQ(motion.outcome, MotionOutcome::kFound) << motion.reason;
  EXPECT_LE(motion.trajectory.knots.size(), 4U);
  EXPECT_EQ(motion.trajectory.knots.front().q, kLeft);
  EXPECT_EQ(motion.trajectory.knots.back().q, kRight);
}

TEST(PlanMotion, GoesAroundAPost) {
  world::VoxelSpace space = FreeSpace();
  const auto voxels = Occupy({Vector3d(0.42, -0.14, 0.0), Vector3d(0.48, -0.06, 1.05)}, &space);
  const ArmCollision collision = CollisionIn(space, kLeft);
  ASSERT_FALSE(StraightIsFree(collision, kLeft, kRight, 0.02));
  const PlannedMotion motion = Plan(collision, kLeft, kRight);
  ASSERT_EQ(motion.outcome, MotionOutcome::kFound) << motion.reason;
  EXPECT_EQ(motion.trajectory.knots.back().q, kRight);
  const DenseCheck check(SimulatedArm(), voxels);
  for (double t = 0.0; t < motion.trajectory.seconds(); t += 0.02) {
    ASSERT_GE(check.ToObstacles(hal::Sample(motion.trajectory, t).q), 0.02) << t;
  }
}

TEST(PlanMotion, SaysThatThereIsNoWay) {
  world::VoxelSpace space = FreeSpace();
  // Walls to both sides of the shoulder, up to a ceiling too low for the arm to stand up under:
  // what is left between them is wide enough for the upper arm, but not for the folded forearm.
  Occupy({Vector3d(0.09, -0.11, 0.0), Vector3d(1.0, -0.09, 1.3)}, &space);
  Occupy({Vector3d(-1.1, -0.11, 0.0), Vector3d(-0.19, -0.09, 1.3)}, &space);
  Occupy({Vector3d(-1.1, -1.1, 1.28), Vector3d(1.0, 1.0, 1.3)}, &space);
  const ArmCollision collision = CollisionIn(space, kLeft);
  MotionConfig config;
  config.iterations = 150;
  const PlannedMotion motion = Plan(collision, kLeft, kRight, 1, config);
  EXPECT_EQ(motion.outcome, MotionOutcome::kNoWay);
  EXPECT_EQ(motion.reason, "no way found in 150 iterations");
  EXPECT_TRUE(motion.trajectory.knots.empty());
}

TEST(PlanMotion, DoesNotBeginInACollisionNorEndInOne) {
  world::VoxelSpace space = FreeSpace();
  Occupy({Vector3d(0.25, 0.25, 0.6), Vector3d(0.45, 0.55, 1.0)}, &space);
  const ArmCollision collision = CollisionIn(space, kRight);
  const PlannedMotion into = Plan(collision, kRight, kLeft);
  EXPECT_EQ(into.outcome, MotionOutcome::kGoalInCollision);
  EXPECT_THAT(into.reason, ::testing::HasSubstr("the goal is in collision: link 'link_"));
  const PlannedMotion out = Plan(collision, kLeft, kRight);
  EXPECT_EQ(out.outcome, MotionOutcome::kStartInCollision);
  EXPECT_THAT(out.reason, ::testing::HasSubstr("the arm is in collision where it is: link 'link_"));
  EXPECT_TRUE(out.trajectory.knots.empty());
}

TEST(PlanMotion, KeepsOutOfUnknownSpaceUnlessItIsAllowed) {
  const world::VoxelSpace unknown;
  const PlannedMotion refused = Plan(CollisionIn(unknown, kHome), kHome, kLeft);
  EXPECT_EQ(refused.outcome, MotionOutcome::kGoalInCollision);
  EXPECT_THAT(refused.reason, ::testing::HasSubstr("with unknown space at"));
  ObstacleConfig config;
  config.avoid_unknown = false;
  const PlannedMotion allowed = Plan(CollisionIn(unknown, kHome, config), kHome, kLeft);
  EXPECT_EQ(allowed.outcome, MotionOutcome::kFound) << allowed.reason;
}

TEST(PlanMotion, NamesTheJointBeyondItsLimits) {
  const ArmCollision collision = CollisionIn(FreeSpace(), kHome);
  VectorXd beyond = kHome;
  beyond[3] = 2.2;
  const PlannedMotion motion = Plan(collision, kHome, beyond);
  EXPECT_EQ(motion.outcome, MotionOutcome::kOutOfLimits);
  EXPECT_EQ(motion.reason,
            "the goal has joint 'joint_4' at 126.05 deg; its limits are -120.00 to 120.00 deg");
}

TEST(PlanMotion, IsTheSameForTheSameSeedWhateverWasPlannedBefore) {
  world::VoxelSpace space = FreeSpace();
  Occupy({Vector3d(0.42, -0.14, 0.0), Vector3d(0.48, -0.06, 1.05)}, &space);
  const ArmCollision collision = CollisionIn(space, kLeft);
  const PlannedMotion first = Plan(collision, kLeft, kRight, 5);
  Plan(collision, kRight, kLeft, 6);
  const PlannedMotion again = Plan(CollisionIn(space, kLeft), kLeft, kRight, 5);
  ASSERT_EQ(first.trajectory.knots.size(), again.trajectory.knots.size());
  ASSERT_GT(first.trajectory.knots.size(), 4U);
  for (std::size_t i = 0; i < first.trajectory.knots.size(); ++i) {
    EXPECT_EQ(first.trajectory.knots[i].seconds, again.trajectory.knots[i].seconds);
    EXPECT_EQ(first.trajectory.knots[i].q, again.trajectory.knots[i].q);
  }
}

TEST(PlanMotion, NeverTouchesAnythingIn200RandomScenes) {
  const kinematics::Chain arm = SimulatedArm();
  const auto joints = JointsOf(arm, 2.5);
  const world::VoxelSpace empty = FreeSpace();
  int found = 0;
  int around = 0;
  MotionConfig config;
  config.iterations = 200;
  for (int scene = 0; scene < 200; ++scene) {
    Rng rng(ForkSeed(scene, "random scenes of the arm"));
    world::VoxelSpace space = empty;
    std::vector<Vector3d> voxels;
    for (int i = 0; i < 4; ++i) {
      const double angle = rng.Uniform(-3.1, 3.1);
      const double radius = rng.Uniform(0.35, 0.8);
      const Vector3d corner(radius * std::cos(angle), radius * std::sin(angle),
                            rng.Uniform(0.2, 1.2));
      const Vector3d size(rng.Uniform(.04, .2), rng.Uniform(.04, .2), rng.Uniform(.1, .4));
      const auto more = Occupy({corner, corner + size}, &space);
      voxels.insert(voxels.end(), more.begin(), more.end());
    }
    const auto draw = [&] {
      VectorXd q(7);
      for (int j = 0; j < 7; ++j) q[j] = rng.Uniform(arm.joint(j).lower, arm.joint(j).upper);
      return q;
    };
    const ArmCollision collision = CollisionIn(space, kHome);
    VectorXd start = draw();
    for (int i = 0; i < 200 && !collision.Free(start); ++i) start = draw();
    VectorXd goal = draw();
    for (int i = 0; i < 200 && !collision.Free(goal); ++i) goal = draw();
    const PlannedMotion motion = Plan(collision, start, goal, scene, config);
    if (motion.outcome != MotionOutcome::kFound) {
      EXPECT_FALSE(motion.reason.empty());
      continue;
    }
    ++found;
    around += motion.trajectory.knots.size() > 4;
    ASSERT_NO_THROW(hal::CheckTrajectory(motion.trajectory, "arm", joints, start));
    EXPECT_EQ(motion.trajectory.knots.back().q, goal);
    const DenseCheck check(arm, voxels);
    for (int step = 0; step <= 60; ++step) {
      const VectorXd q =
          hal::Sample(motion.trajectory, step / 60.0 * motion.trajectory.seconds()).q;
      // The clearance of 3 cm less half a step of 2 cm; voxels are boxes around their centres.
      ASSERT_GE(check.ToObstacles(q), 0.02) << "scene " << scene;
      ASSERT_EQ(check.MeetingLinks(q), "") << "scene " << scene;
    }
  }
  RecordProperty("found", found);
  RecordProperty("around", around);
  EXPECT_GT(found, 120);
  EXPECT_GT(around, 40);
}

TEST(PlanMotion, RefusesWhatIsNotValid) {
  const ArmCollision collision = CollisionIn(FreeSpace(), kHome);
  EXPECT_THROWS(Plan(collision, VectorXd::Zero(3), kLeft), InvalidArgument,
                "motion: the start has not 7 finite joint angles");
  VectorXd wrong = kLeft;
  wrong[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROWS(Plan(collision, kHome, wrong), InvalidArgument, "the goal has not 7 finite");
  MotionConfig config;
  config.step_m = 0.1;
  EXPECT_THROWS(Plan(collision, kHome, kLeft, 1, config), ConfigError,
                "step_m = 0.1 must be at most twice the least clearance, 0.01 m");
  config = {};
  config.speed_share = 0.0;
  EXPECT_THROWS(Plan(collision, kHome, kLeft, 1, config), ConfigError, "speed_share = 0 must lie");
  EXPECT_THROWS(ArmCollisionConfig{.clearance_m = -1.0}.Validate(), ConfigError,
                "clearance_m = -1 must lie in 0..1");
}

}  // namespace
}  // namespace secondlook::planning

#include "lib/perception/rival_turns.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/perception/synthetic_view.h"

namespace secondlook::perception {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

RecognitionModel Model(const geometry::Mesh& mesh) { return TrainModel({"thing", mesh, 1}); }

double AngleOf(const Pose& turn) {
  return RotationDistance(Eigen::Matrix3d::Identity(), turn.linear());
}

TEST(RivalTurns, TurnsAPlainBoxOnlyByTheSmallAngle) {
  const auto turns =
      RivalTurns(Model(geometry::MakeBox({0.1, 0.15, 0.2}, {0.5F, 0.5F, 0.5F})), 7.0 * kDegree);
  EXPECT_EQ(turns.size(), 6U);
  for (const Pose& turn : turns) EXPECT_NEAR(AngleOf(turn), 7.0 * kDegree, 1e-9);
}

TEST(RivalTurns, LeavesOutTurnsAboutTheAxisOfAPlainCan) {
  const auto turns =
      RivalTurns(Model(geometry::MakeCylinder(0.04, 0.11, 48, {0.5F, 0.5F, 0.5F})), 7.0 * kDegree);
  EXPECT_EQ(turns.size(), 4U);
  for (const Pose& turn : turns) {
    EXPECT_LT(turn.linear()(2, 2), 1.0 - 1e-6) << "a turn about z changes nothing";
  }
}

TEST(RivalTurns, TurnsAPrintedCanAllTheWayRound) {
  geometry::Mesh can = geometry::MakeCylinder(0.04, 0.11, 48, {1.0F, 1.0F, 1.0F});
  can.vertex_colors.clear();
  for (const Eigen::Vector3f& v : can.vertices) {
    can.vertex_colors.push_back(v.x() > 0.0F ? Eigen::Vector3f(1, 0, 0) : Eigen::Vector3f(0, 0, 1));
  }
  const auto turns = RivalTurns(Model(can), 7.0 * kDegree);
  const bool half_turn = std::any_of(turns.begin(), turns.end(), [](const Pose& turn) {
    return turn.linear()(2, 2) > 0.999 && AngleOf(turn) > 179.0 * kDegree;
  });
  EXPECT_TRUE(half_turn);
  EXPECT_GE(turns.size(), 4U + 23U);
}

/// A box of `size` with a coloured plate on one side (-y).
RecognitionModel Labelled(const Eigen::Vector3d& size) {
  return TrainModel(MakeBoxModel("box", size, {0.9F, 0.9F, 0.9F}, {0.1F, 0.2F, 0.8F}));
}

TEST(BoxTurns, OfABoxWithALabelAreItsHalfTurnsThatMoveTheLabel) {
  const std::vector<Pose> turns = BoxTurns(Labelled({0.08, 0.12, 0.2}));
  ASSERT_EQ(turns.size(), 2U);  // about x and z; about y the label stays
  for (const Pose& turn : turns) EXPECT_NEAR(turn.linear()(1, 1), -1.0, 1e-9);
}

TEST(BoxTurns, OfABrickThatIsNearlySquareAreItsQuarterTurnsToo) {
  const std::vector<Pose> turns = BoxTurns(Labelled({0.06, 0.064, 0.2}));
  // Of the eight turns of a square prism, two leave the label where it is.
  ASSERT_EQ(turns.size(), 6U);
  const Eigen::Vector3d middle_M(0.0, 0.0, 0.1);
  for (const Pose& turn : turns) EXPECT_LT((turn * middle_M - middle_M).norm(), 0.002);
}

TEST(BoxTurns, OfAPlainBoxAreNone) {
  EXPECT_TRUE(BoxTurns(Model(geometry::MakeBox({0.1, 0.15, 0.2}, {0.5F, 0.5F, 0.5F}))).empty());
}

TEST(ShareOfTurn, OfAHalfIsTheTurnWhenTakenTwiceAndKeepsTheCentre) {
  const Eigen::Vector3d center_M(0.1, 0.2, 0.3);
  const Pose turn = TurnAbout({center_M, Eigen::Vector3d(1.0, 2.0, -1.0).normalized()}, 0.4);
  const Pose half = ShareOfTurn(turn, center_M, 0.5);
  EXPECT_TRUE((half * half).isApprox(turn, 1e-9));
  EXPECT_LT((half * center_M - center_M).norm(), 1e-9);
  EXPECT_TRUE(ShareOfTurn(turn, center_M, -1.0).isApprox(turn.inverse(), 1e-9));
}

TEST(IsAtRest, OfABoxIsTrueOnAnySideAndFalseOnAnEdge) {
  const RecognitionModel box = Model(geometry::MakeBox({0.1, 0.15, 0.2}, {0.5F, 0.5F, 0.5F}));
  const auto rests_after = [&](double angle) {
    const Pose X_WM =
        ToPose(Pose2{1.0, 2.0, 0.5}) *
        TurnAbout({Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()}, angle * kDegree);
    return IsAtRest(box, X_WM, Eigen::Vector3d::UnitZ());
  };
  EXPECT_TRUE(rests_after(0.0));
  EXPECT_TRUE(rests_after(90.0));
  EXPECT_FALSE(rests_after(30.0));
}

TEST(LeavesItsRest, IsTrueOfATiltAndFalseOfATurnOnTheSpot) {
  const RecognitionModel box = Model(geometry::MakeBox({0.1, 0.15, 0.2}, {0.5F, 0.5F, 0.5F}));
  const Pose X_WM = ToPose(Pose2{1.0, 2.0, 0.5});
  const auto turn = [](const Eigen::Vector3d& axis) {
    return TurnAbout({Eigen::Vector3d::Zero(), axis}, 7.0 * kDegree);
  };
  EXPECT_TRUE(LeavesItsRest(box, X_WM, turn(Eigen::Vector3d::UnitX()), Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(LeavesItsRest(box, X_WM, turn(Eigen::Vector3d::UnitZ()), Eigen::Vector3d::UnitZ()));
  // Leaning on something already, it is not at rest to begin with.
  const Pose X_WL = X_WM * TurnAbout({Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()}, 0.4);
  EXPECT_FALSE(LeavesItsRest(box, X_WL, turn(Eigen::Vector3d::UnitY()), Eigen::Vector3d::UnitZ()));
}

}  // namespace
}  // namespace secondlook::perception

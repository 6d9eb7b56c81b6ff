#include "lib/perception/symmetry.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/perception/synthetic_view.h"

namespace secondlook::perception {
namespace {

constexpr double kPi = std::numbers::pi;
const Eigen::Vector3f kRed(0.8F, 0.15F, 0.1F);
const Eigen::Vector3f kWhite(0.9F, 0.9F, 0.9F);

TEST(FindSymmetry, ABoxOfThreeLengthsHasThreeHalfTurns) {
  const Symmetry symmetry = FindSymmetry(geometry::MakeBox({0.1, 0.15, 0.22}, kRed));
  EXPECT_EQ(symmetry.motions.size(), 4U);
  EXPECT_FALSE(symmetry.axis.has_value());
  for (const SymmetryMotion& motion : symmetry.motions) EXPECT_TRUE(motion.keeps_color);
}

TEST(FindSymmetry, ASquarePrismHasQuarterTurnsToo) {
  // The rotation group of a square prism (D4) has 8 elements.
  EXPECT_EQ(FindSymmetry(geometry::MakeBox({0.1, 0.1, 0.2}, kRed)).motions.size(), 8U);
}

TEST(FindSymmetry, AStarOfEightFinsHasEighthTurns) {
  // Four plates through one axis, 45 degrees apart, their upper half narrower: no flips.
  geometry::Mesh star;
  for (int k = 0; k < 4; ++k) {
    for (const double width : {0.1, 0.06}) {
      const geometry::Mesh plate = geometry::MakeBox({width, 0.002, 0.06}, kRed);
      const Eigen::Matrix3f R = RotationFromRollPitchYaw(0, 0, k * kPi / 4).cast<float>();
      const Eigen::Vector3f up(0.0F, 0.0F, width == 0.1 ? 0.03F : 0.09F);
      const auto first = static_cast<int>(star.vertices.size());
      for (const Eigen::Vector3f& v : plate.vertices) star.vertices.push_back(R * v + up);
      for (const Eigen::Vector3i& t : plate.triangles) {
        star.triangles.emplace_back(t.array() + first);
        star.triangle_material.push_back(0);
      }
      star.materials = plate.materials;
    }
  }
  const Symmetry symmetry = FindSymmetry(star);
  EXPECT_FALSE(symmetry.axis.has_value());
  EXPECT_EQ(symmetry.motions.size(), 8U);
}

TEST(FindSymmetry, ACylinderTurnsAboutItsAxisAndFlips) {
  const Symmetry symmetry = FindSymmetry(geometry::MakeCylinder(0.04, 0.12, 64, kRed));
  ASSERT_TRUE(symmetry.axis.has_value());
  EXPECT_GT(std::abs(symmetry.axis->direction.z()), 0.999);
  EXPECT_NEAR(symmetry.axis->point.head<2>().norm(), 0.0, 0.002);
  EXPECT_TRUE(symmetry.axis_keeps_color);
  EXPECT_EQ(symmetry.motions.size(), 2U);
}

TEST(FindSymmetry, PrintTakesTheSymmetryOfColourAndLeavesThatOfShape) {
  const Symmetry symmetry = FindSymmetry(MakeBoxModel("box", {0.1, 0.15, 0.22}, kWhite, kRed).mesh);
  ASSERT_EQ(symmetry.motions.size(), 4U);
  const auto kept = std::count_if(symmetry.motions.begin(), symmetry.motions.end(),
                                  [](const SymmetryMotion& m) { return m.keeps_color; });
  EXPECT_EQ(kept, 2);  // the identity, and the half turn about the label's normal
}

TEST(FindSymmetry, AnLHasNone) {
  const Symmetry symmetry = FindSymmetry(MakeEll("ell", kRed, kRed).mesh);
  // Its mirror plane is no rotation.
  EXPECT_EQ(symmetry.motions.size(), 1U);
  EXPECT_FALSE(symmetry.axis.has_value());
}

TEST(DistanceUpToSymmetry, IsZeroBetweenPosesThatTheSymmetryJoins) {
  const geometry::Mesh box = geometry::MakeBox({0.1, 0.15, 0.22}, kRed);
  const Symmetry symmetry = FindSymmetry(box);
  Rng rng(3);
  for (int i = 0; i < 20; ++i) {
    Pose X_CA = Pose::Identity();
    X_CA.linear() =
        RotationFromVector({rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-2, 2)});
    for (const SymmetryMotion& motion : symmetry.motions) {
      const PoseDistance d =
          DistanceUpToSymmetry(X_CA, X_CA * motion.X_MS, symmetry, Eigen::Vector3d::Zero(), true);
      EXPECT_NEAR(d.rotation, 0.0, 1e-6);
      EXPECT_NEAR(d.translation, 0.0, 0.003);
    }
  }
}

TEST(DistanceUpToSymmetry, ATurnedPrintCountsOnlyWithColour) {
  const Symmetry symmetry = FindSymmetry(MakeBoxModel("box", {0.1, 0.15, 0.22}, kWhite, kRed).mesh);
  const Pose X_CA = Pose::Identity();
  const Pose X_CB = TurnAbout({{0, 0, 0.11}, Eigen::Vector3d::UnitZ()}, kPi);
  const Eigen::Vector3d center(0, 0, 0.11);
  EXPECT_NEAR(DistanceUpToSymmetry(X_CA, X_CB, symmetry, center, false).rotation, 0.0, 1e-6);
  EXPECT_NEAR(DistanceUpToSymmetry(X_CA, X_CB, symmetry, center, true).rotation, kPi, 1e-6);
}

TEST(DistanceUpToSymmetry, AContinuousAxisLeavesItsTilt) {
  const Symmetry symmetry = FindSymmetry(geometry::MakeCylinder(0.04, 0.12, 64, kRed));
  Pose X_CB = Pose::Identity();
  X_CB.linear() = RotationFromRollPitchYaw(0.2, 0.0, 0.0) * RotationFromRollPitchYaw(0, 0, 1.3);
  const Eigen::Vector3d center(0, 0, 0.06);
  EXPECT_NEAR(DistanceUpToSymmetry(Pose::Identity(), X_CB, symmetry, center, true).rotation, 0.2,
              0.01);
}

}  // namespace
}  // namespace secondlook::perception

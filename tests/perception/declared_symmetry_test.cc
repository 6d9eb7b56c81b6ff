#include "lib/perception/declared_symmetry.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/perception/recognition_model.h"
#include "tests/perception/synthetic_view.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

const Eigen::Vector3f kRed(0.8F, 0.15F, 0.1F);
const Eigen::Vector3f kWhite(0.9F, 0.9F, 0.9F);
const Eigen::Vector3d kZ = Eigen::Vector3d::UnitZ();

/// The motions that no view tells from one another.
std::ptrdiff_t AlikeMotions(const Symmetry& symmetry) {
  return std::count_if(symmetry.motions.begin(), symmetry.motions.end(),
                       [](const SymmetryMotion& motion) { return motion.keeps_color; });
}

TEST(Declare, LetsPrintThatTellsHalfTurnsApartNotMatter) {
  // A box of three lengths has the identity and three half turns; its print leaves one of these.
  const geometry::Mesh box = MakeBoxModel("box", {0.1, 0.15, 0.22}, kWhite, kRed).mesh;
  Symmetry symmetry = FindSymmetry(box);
  ASSERT_EQ(AlikeMotions(symmetry), 2);
  Declare({{kZ, 2}}, box, &symmetry);
  EXPECT_EQ(symmetry.motions.size(), 4U);
  EXPECT_EQ(AlikeMotions(symmetry), 4);  // the products are alike, too
}

TEST(Declare, AnyTurnMakesAContinuousAxis) {
  // 12 corners: detection calls it steps, but the user does not care.
  const geometry::Mesh prism = geometry::MakeCylinder(0.04, 0.12, 12, kRed);
  Symmetry symmetry;
  symmetry.motions.push_back({Pose::Identity(), true});
  Declare({{kZ, 0}}, prism, &symmetry);
  ASSERT_TRUE(symmetry.axis.has_value());
  EXPECT_TRUE(symmetry.axis_keeps_color);
  EXPECT_NEAR(symmetry.axis->direction.dot(kZ), 1.0, 1e-9);
}

TEST(Declare, RefusesATurnThatTheShapeDoesNotHave) {
  const geometry::Mesh box = geometry::MakeBox({0.1, 0.15, 0.22}, kRed);
  Symmetry symmetry = FindSymmetry(box);
  EXPECT_THROWS(Declare({{kZ, 4}}, box, &symmetry), InvalidArgument,
                "its declared symmetry z:4 does not leave its shape: turned, 3 % of it lies 2");
  EXPECT_THROWS(TrainModel({"brick", box, 1, {}, {{kZ, 0}}}), InvalidArgument,
                "model 'brick': its declared symmetry z does not leave its shape");
}

TEST(Declare, NothingLeavesWhatWasFound) {
  const geometry::Mesh box = geometry::MakeBox({0.1, 0.15, 0.22}, kRed);
  Symmetry symmetry = FindSymmetry(box);
  Declare({}, box, &symmetry);
  EXPECT_EQ(symmetry.motions.size(), 4U);
  EXPECT_FALSE(symmetry.axis.has_value());
}

}  // namespace
}  // namespace secondlook::perception

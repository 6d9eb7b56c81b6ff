#include "lib/kinematics/box_of_moved.h"

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::kinematics {
namespace {

using Eigen::Vector3d;

TEST(BoxOfMoved, IsTheBoxAroundTheSurfacesOfAllLinksThatTheJointsMove) {
  const Chain arm(LoadUrdf("sim/robots/arm.urdf"), "flange");
  const std::vector<Link>& links = arm.model().links;
  Rng rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::VectorXd q(arm.size());
    for (double& angle : q) angle = rng.Uniform(-2.0, 2.0);
    const std::vector<Pose> X_BL = arm.LinkPoses(q);
    Eigen::AlignedBox3d seen_B;
    for (int l = 0; l < static_cast<int>(links.size()); ++l) {
      if (!arm.Moves(l)) continue;
      for (const geometry::PlacedShape& part : links[l].body) {
        for (const Eigen::Vector3f& p_S :
             geometry::MakeMesh(part.shape, 96, Eigen::Vector3f::Zero()).vertices) {
          seen_B.extend(Vector3d(X_BL[l] * part.X_AS * p_S.cast<double>()));
        }
      }
    }
    const Eigen::AlignedBox3d box_B = BoxOfMoved(arm, q);
    // 96 corners on a circle are short of it by 0.05 %.
    EXPECT_TRUE(box_B.min().isApprox(seen_B.min(), 1e-3)) << box_B.min() << seen_B.min();
    EXPECT_TRUE(box_B.max().isApprox(seen_B.max(), 1e-3)) << box_B.max() << seen_B.max();
    EXPECT_TRUE(box_B.contains(arm.TipPose(q).translation()));
  }
}

}  // namespace
}  // namespace secondlook::kinematics

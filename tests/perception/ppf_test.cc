#include "lib/perception/ppf.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/perception/synthetic_view.h"
#include "tests/support/expect_throws.h"

namespace secondlook::perception {
namespace {

const Eigen::Vector3f kGrey(0.5F, 0.5F, 0.5F);

Pose RandomPose(Rng* rng) {
  Pose X = Pose::Identity();
  X.linear() = RotationFromVector({rng->Uniform(-2, 2), rng->Uniform(-2, 2), rng->Uniform(-2, 2)});
  X.translation() << rng->Uniform(-0.3, 0.3), rng->Uniform(-0.3, 0.3), rng->Uniform(0.5, 1.5);
  return X;
}

TEST(VotePpf, FindsThePoseOfPointsOfItsOwnModel) {
  const world::ObjectModel ell = MakeEll("ell", kGrey, kGrey);
  const PpfModel model = TrainPpf(ell.mesh);
  int found = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    const Pose X_CM = RandomPose(&rng);
    // Other points than those trained, spread by a millimetre.
    std::vector<geometry::OrientedPoint> drawn;
    for (const geometry::MeshSample& s : geometry::SampleSurface(ell.mesh, 400, &rng)) {
      const Eigen::Vector3d p = X_CM * s.surface.point.cast<double>();
      const Eigen::Vector3d noise(rng.Gaussian(0.001), rng.Gaussian(0.001), rng.Gaussian(0.001));
      drawn.push_back({(p + noise).cast<float>(),
                       (X_CM.linear() * s.surface.normal.cast<double>()).cast<float>()});
    }
    Symmetry none;
    none.motions.push_back({Pose::Identity(), true});
    const Eigen::Vector3d center(0.02, 0, 0.07);
    const auto clusters = ClusterPeaks(VotePpf(model, drawn, 10), none, center, 0.02, 0.3);
    ASSERT_FALSE(clusters.empty());
    const PoseDistance d = DistanceUpToSymmetry(X_CM, clusters[0].X_CM, none, center, false);
    found += d.translation < 0.015 && d.rotation < 0.2 ? 1 : 0;
    for (std::size_t i = 1; i < clusters.size(); ++i) {
      EXPECT_LE(clusters[i].votes, clusters[i - 1].votes);
    }
  }
  EXPECT_GE(found, 9);
}

TEST(TrainPpf, TabulatesEveryPairOnceAndNoneInAPlane) {
  const PpfModel model = TrainPpf(geometry::MakeBox({0.1, 0.1, 0.1}, kGrey), 0.1);
  EXPECT_EQ(model.first.back(), model.entries.size());
  const std::size_t all = model.points.size() * (model.points.size() - 1);
  // Of two points of a cube, one in six pairs shares the face and is left out.
  EXPECT_NEAR(static_cast<double>(model.entries.size()) / static_cast<double>(all), 5.0 / 6.0,
              0.06);
  EXPECT_NEAR(model.diameter, 0.1 * std::sqrt(3.0), 1e-6);
}

TEST(TrainPpf, GivesTheSameTwice) {
  const geometry::Mesh mesh = MakeEll("ell", kGrey, kGrey).mesh;
  const PpfModel one = TrainPpf(mesh);
  const PpfModel two = TrainPpf(mesh);
  ASSERT_EQ(one.entries.size(), two.entries.size());
  for (std::size_t i = 0; i < one.entries.size(); ++i) {
    ASSERT_EQ(one.entries[i].reference, two.entries[i].reference);
    ASSERT_EQ(one.entries[i].turn, two.entries[i].turn);
  }
}

TEST(TrainPpf, RefusesASamplingThatIsNone) {
  const geometry::Mesh mesh = geometry::MakeBox({0.1, 0.1, 0.1}, kGrey);
  EXPECT_THROWS(TrainPpf(mesh, 0.0), InvalidArgument, "PPF sampling = 0; it must be in (0, 0.25]");
  EXPECT_THROWS(TrainPpf(mesh, 0.5), InvalidArgument, "PPF sampling = 0.5");
}

TEST(VotePpf, OfNoOrOnePointMakesNothing) {
  const PpfModel model = TrainPpf(geometry::MakeBox({0.1, 0.1, 0.1}, kGrey));
  EXPECT_TRUE(VotePpf(model, {}, 1).empty());
  EXPECT_TRUE(VotePpf(model, {{{0, 0, 1}, {0, 0, -1}}}, 1).empty());
}

}  // namespace
}  // namespace secondlook::perception

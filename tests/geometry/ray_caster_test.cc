#include "lib/geometry/ray_caster.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook::geometry {
namespace {

using Eigen::Vector3f;

Vector3f RandomVector(Rng* rng) {
  return {static_cast<float>(rng->Uniform(-1, 1)), static_cast<float>(rng->Uniform(-1, 1)),
          static_cast<float>(rng->Uniform(-1, 1))};
}

TEST(RayCaster, MeetsABoxWhereTheSlabTestSays) {
  const Vector3f half(0.1F, 0.2F, 0.3F);
  const Mesh box = MakeBox({0.2, 0.4, 0.6}, Vector3f::Ones());
  const RayCaster caster(box);
  Rng rng(1);
  std::vector<Ray> rays;
  for (int i = 0; i < 500; ++i) {
    const Vector3f from = 2.0F * RandomVector(&rng).normalized();
    rays.push_back({from, 0.4F * RandomVector(&rng) - from});
  }
  const std::vector<RayHit> hits = caster.Cast(rays);
  ASSERT_EQ(hits.size(), rays.size());
  int met = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Array3f a = (-half - rays[i].p_MO).array() / rays[i].direction_M.array();
    const Eigen::Array3f b = (half - rays[i].p_MO).array() / rays[i].direction_M.array();
    const float enter = a.min(b).maxCoeff();
    const float leave = a.max(b).minCoeff();
    if (std::abs(enter - leave) < 1e-4F) continue;  // grazes an edge
    ASSERT_EQ(hits[i].triangle >= 0, enter < leave) << i;
    if (enter > leave) continue;
    ++met;
    EXPECT_NEAR(hits[i].distance, enter, 1e-5) << i;
    // The weights give the same point, the normal looks back along the ray.
    Vector3f point = Vector3f::Zero();
    for (int k = 0; k < 3; ++k) {
      point += hits[i].weights[k] * box.vertices[box.triangles[hits[i].triangle][k]];
    }
    EXPECT_NEAR((point - rays[i].p_MO - enter * rays[i].direction_M).norm(), 0.0, 1e-5) << i;
    EXPECT_NEAR(hits[i].normal_M.norm(), 1.0, 1e-5);
    EXPECT_LT(hits[i].normal_M.dot(rays[i].direction_M), 0.0F);
  }
  EXPECT_GT(met, 100);
}

TEST(RayCaster, SeesASurfaceFromItsBackToo) {
  const RayCaster caster(MakeBox({1.0, 1.0, 1.0}, Vector3f::Ones()));
  const std::vector<RayHit> hits =
      caster.Cast(std::vector<Ray>{{Vector3f::Zero(), Vector3f(0.0F, 0.1F, 2.0F)}});
  EXPECT_GE(hits[0].triangle, 0);
  EXPECT_NEAR(hits[0].distance, 0.25, 1e-6);
}

TEST(RayCaster, LeavesTheProcessItsThreads) {
  const auto threads = [] {
    return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  };
  const auto before = threads();
  const RayCaster caster(MakeBox({1.0, 1.0, 1.0}, Vector3f::Ones()));
  EXPECT_EQ(threads(), before);
}

TEST(RayCaster, RefusesAMeshWithoutTriangles) {
  EXPECT_THROWS(RayCaster(Mesh{}), InvalidArgument, "no triangle");
}

}  // namespace
}  // namespace secondlook::geometry

#include "sim/line_scanner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lib/common/hash.h"
#include "lib/common/rng.h"
#include "sim/shaded_mesh.h"

namespace secondlook::sim {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kMaxStampSigmas = 3.0;

geometry::Mesh Together(const std::vector<Fixture>& fixtures) {
  geometry::Mesh all_W;
  for (const Fixture& fixture : fixtures) {
    const auto first = static_cast<int>(all_W.vertices.size());
    for (const Eigen::Vector3f& p_M : fixture.mesh.vertices) {
      all_W.vertices.emplace_back((fixture.X_WM * p_M.cast<double>()).cast<float>());
    }
    for (const Eigen::Vector3i& triangle : fixture.mesh.triangles) {
      all_W.triangles.emplace_back(triangle.array() + first);
    }
  }
  return all_W;
}

}  // namespace

hal::StriperInfo SimulatedStriper(const NoiseConfig& noise) {
  return {"striper",
          640,
          14.25 * kRadians,
          0.3,
          0.6,
          1.0 / ToSeconds(StriperDrive::kPeriod),
          std::max(noise.striper_range_sigma, 1e-6)};
}

LineScanner::LineScanner(const std::vector<Fixture>& fixtures, const NoiseConfig& noise,
                         std::uint64_t seed)
    : fixtures_(fixtures),
      noise_(noise),
      seed_(ForkSeed(seed, "striper")),
      info_(SimulatedStriper(noise)),
      caster_(Together(fixtures)) {
  int first = 0;
  for (const Fixture& fixture : fixtures) {
    first_.push_back(first);
    first += static_cast<int>(fixture.mesh.triangles.size());
  }
}

LineScanner::Surface LineScanner::At(const geometry::RayHit& hit,
                                     const geometry::Ray& ray_W) const {
  if (hit.triangle < 0) return {std::numeric_limits<double>::infinity()};
  const auto after = std::upper_bound(first_.begin(), first_.end(), hit.triangle);
  const auto index = static_cast<std::size_t>(std::distance(first_.begin(), after) - 1);
  const geometry::Mesh& mesh = fixtures_[index].mesh;
  const int triangle = hit.triangle - first_[index];
  const Eigen::Vector3f color =
      geometry::ColorAt(mesh, triangle, hit.weights).unaryExpr(&LinearFromSrgb);
  return {hit.distance, std::abs(hit.normal_M.dot(ray_W.direction_M)),
          color.dot(Eigen::Vector3f(0.2126F, 0.7152F, 0.0722F)),
          mesh.materials[mesh.triangle_material[triangle]].specular};
}

hal::ScanLine LineScanner::Measure(const Shot& shot) const {
  Rng rng(Fnv1a(shot.sequence, seed_));
  const double most = kMaxStampSigmas * noise_.stamp_sigma;
  const double late = std::clamp(rng.Gaussian(noise_.stamp_sigma), -most, most);
  hal::ScanLine line{
      std::min(shot.time + Seconds(late), shot.time + StriperDrive::kPeriod), shot.sequence, {}};
  std::vector<geometry::Ray> rays_W;
  for (int i = 0; i < info_.points; ++i) {
    rays_W.push_back(
        {shot.X_WL.translation().cast<float>(), (shot.X_WL.linear() * info_.Ray(i)).cast<float>()});
  }
  const double min_cosine = std::cos(noise_.striper_max_incidence_deg * kRadians);
  const std::vector<geometry::RayHit> hits = caster_.Cast(rays_W);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    // Each ray draws the same number of times, so that one surface does not shift the noise of
    // another.
    const double error = rng.Gaussian(noise_.striper_range_sigma);
    const double luck = rng.Uniform(0.0, 1.0);
    const Surface surface = At(hits[i], rays_W[i]);
    const double range = surface.range + error;
    const bool returns =
        surface.cos_incidence >= min_cosine && range >= info_.min_range &&
        range <= info_.max_range &&
        luck >= DarkShinyLoss(surface.luminance, surface.specular, surface.cos_incidence, noise_);
    line.ranges.push_back(returns ? static_cast<float>(range)
                                  : std::numeric_limits<float>::quiet_NaN());
  }
  return line;
}

}  // namespace secondlook::sim

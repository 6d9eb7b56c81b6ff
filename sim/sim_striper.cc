#include "sim/sim_striper.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "lib/common/error.h"
#include "lib/common/hash.h"
#include "lib/common/rng.h"
#include "lib/geometry/ray_caster.h"
#include "sim/shaded_mesh.h"

namespace secondlook::sim {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kMaxStampSigmas = 3.0;

/// What a ray meets.
struct Surface {
  double range{};  ///< [m]
  double cos_incidence{};
  double luminance{};  ///< Linear, of the material.
  double specular{};
};

}  // namespace

/// All that stands in the scene, as one mesh in W.
class SimStriper::Surroundings {
 public:
  explicit Surroundings(const std::vector<Fixture>& fixtures)
      : fixtures_(fixtures), caster_(Together(fixtures)) {
    int first = 0;
    for (const Fixture& fixture : fixtures) {
      first_.push_back(first);
      first += static_cast<int>(fixture.mesh.triangles.size());
    }
  }

  /// What each of the rays of unit direction meets; a range of infinity where nothing.
  std::vector<Surface> Meet(std::span<const geometry::Ray> rays_W) const {
    std::vector<Surface> surfaces;
    for (const geometry::RayHit& hit : caster_.Cast(rays_W)) {
      const geometry::Ray& ray = rays_W[surfaces.size()];
      surfaces.push_back(hit.triangle < 0 ? Surface{std::numeric_limits<double>::infinity()}
                                          : At(hit, ray));
    }
    return surfaces;
  }

 private:
  static geometry::Mesh Together(const std::vector<Fixture>& fixtures) {
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

  Surface At(const geometry::RayHit& hit, const geometry::Ray& ray) const {
    const auto after = std::upper_bound(first_.begin(), first_.end(), hit.triangle);
    const auto index = static_cast<std::size_t>(std::distance(first_.begin(), after) - 1);
    const geometry::Mesh& mesh = fixtures_[index].mesh;
    const int triangle = hit.triangle - first_[index];
    const Eigen::Vector3f color =
        geometry::ColorAt(mesh, triangle, hit.weights).unaryExpr(&LinearFromSrgb);
    const auto material = mesh.triangle_material.empty() ? 0 : mesh.triangle_material[triangle];
    return {hit.distance, std::abs(hit.normal_M.dot(ray.direction_M)),
            color.dot(Eigen::Vector3f(0.2126F, 0.7152F, 0.0722F)),
            mesh.materials[material].specular};
  }

  const std::vector<Fixture>& fixtures_;
  geometry::RayCaster caster_;
  std::vector<int> first_;  // triangle of each fixture
};

SimStriper::SimStriper(World* world, std::uint64_t seed)
    : world_(world),
      seed_(ForkSeed(seed, "striper")),
      info_{"striper",
            640,
            14.25 * kRadians,
            0.3,
            0.6,
            1.0 / ToSeconds(StriperDrive::kPeriod),
            std::max(world->noise().striper_range_sigma, 1e-6)} {}

SimStriper::~SimStriper() { world_->striper()->RequestOff(); }

void SimStriper::RequireThere() const {
  if (!gone_) return;
  Throw<DeviceError>("striper '{}': the device is lost; check its cable and restart (simulated)",
                     info_.name);
}

void SimStriper::On() {
  RequireThere();
  last_time_ = std::max(last_time_, world_->Now());
  world_->striper()->Light(world_->Now() + kAttended);
}

std::vector<hal::ScanLine> SimStriper::Take() {
  RequireThere();
  world_->striper()->Attend(world_->Now() + kAttended);
  if (!surroundings_) surroundings_ = std::make_unique<Surroundings>(world_->fixtures());
  std::vector<hal::ScanLine> lines;
  for (const Shot& shot : world_->striper()->Take()) lines.push_back(Measure(shot));
  return lines;
}

hal::ScanLine SimStriper::Measure(const Shot& shot) {
  const NoiseConfig& noise = world_->noise();
  Rng rng(Fnv1a(shot.sequence, seed_));
  const double late =
      std::clamp(rng.Gaussian(noise.stamp_sigma), -kMaxStampSigmas * noise.stamp_sigma,
                 kMaxStampSigmas * noise.stamp_sigma);
  const Time arrival = shot.time + StriperDrive::kPeriod;
  last_time_ = std::clamp(shot.time + Seconds(late), last_time_ + Duration(1),
                          std::max(arrival, last_time_ + Duration(1)));
  std::vector<geometry::Ray> rays_W;
  for (int i = 0; i < info_.points; ++i) {
    rays_W.push_back(
        {shot.X_WL.translation().cast<float>(), (shot.X_WL.linear() * info_.Ray(i)).cast<float>()});
  }
  const double min_cosine = std::cos(noise.striper_max_incidence_deg * kRadians);
  hal::ScanLine line{last_time_, shot.sequence, {}};
  for (const Surface& surface : surroundings_->Meet(rays_W)) {
    // Each ray draws the same number of times, so that one surface does not shift the noise of
    // another.
    const double error = rng.Gaussian(noise.striper_range_sigma);
    const double luck = rng.Uniform(0.0, 1.0);
    const double range = surface.range + error;
    const bool returns =
        surface.cos_incidence >= min_cosine && range >= info_.min_range &&
        range <= info_.max_range &&
        luck >= DarkShinyLoss(surface.luminance, surface.specular, surface.cos_incidence, noise);
    line.ranges.push_back(returns ? static_cast<float>(range)
                                  : std::numeric_limits<float>::quiet_NaN());
  }
  return line;
}

}  // namespace secondlook::sim

#pragma once

#include <cstdint>
#include <vector>

#include "lib/geometry/ray_caster.h"
#include "lib/hal/laser_striper.h"
#include "sim/fixtures.h"
#include "sim/noise.h"
#include "sim/striper_drive.h"

namespace secondlook::sim {

/// What a laser striper is like: 640 points over 14.25 degrees, from 0.3 to 0.6 m, 50 lines a
/// second (the ScanControl 2700 of Kriegel et al. 2013, Table I).
hal::StriperInfo SimulatedStriper(const NoiseConfig& noise);

/// Measures lines on all that stands in a scene. The noise of a line depends on the seed and its
/// sequence number alone.
class LineScanner {
 public:
  /// `fixtures` must outlive this.
  LineScanner(const std::vector<Fixture>& fixtures, const NoiseConfig& noise, std::uint64_t seed);

  const hal::StriperInfo& info() const { return info_; }

  /// The line that is seen from where the laser truly was. Its stamp is off, but never so late that
  /// it had not arrived.
  hal::ScanLine Measure(const Shot& shot) const;

 private:
  /// What a ray meets.
  struct Surface {
    double range{};  ///< [m]; infinite: nothing.
    double cos_incidence{};
    double luminance{};  ///< Linear, of the material.
    double specular{};
  };

  Surface At(const geometry::RayHit& hit, const geometry::Ray& ray_W) const;

  const std::vector<Fixture>& fixtures_;
  NoiseConfig noise_;
  std::uint64_t seed_;
  hal::StriperInfo info_;
  geometry::RayCaster caster_;  // of all together, in W
  std::vector<int> first_;      // triangle of each fixture
};

}  // namespace secondlook::sim

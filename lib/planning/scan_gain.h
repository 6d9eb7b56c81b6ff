#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/geometry/camera_model.h"
#include "lib/planning/boundary_search.h"
#include "lib/world/brick_grid.h"
#include "lib/world/support_plane.h"
#include "lib/world/surface_volume.h"

namespace secondlook::planning {

struct ScanGainConfig {
  double lambda{0.5};         ///< Of borders against density in the quality (Kriegel 2013, Eq. 1).
  double quality_scans{8.0};  ///< n_q: after so many quality counts more than exploration (Eq. 3).
  double max_range_m{1.5};    ///< Rays end there.
  int stride{3};  ///< Every stride-th ray of every stride-th row stands for those beside.
  double trend_decay_m{0.03};    ///< A trend is worth 1/e so far from the point that it estimates.
  double max_incidence_deg{70};  ///< What would be seen flatter is not thought to be measured.
  double unknown_m{0.04};        ///< What lies behind more unknown space is probably hidden…
  double unknown_survival{0.5};  ///< …and counts so much (nothing is known: even odds).

  template <class A>
  void Serialize(A* a) {
    a->Visit("lambda", &lambda);
    a->Visit("quality_scans", &quality_scans);
    a->Visit("max_range_m", &max_range_m);
    a->Visit("stride", &stride);
    a->Visit("trend_decay_m", &trend_decay_m);
    a->Visit("max_incidence_deg", &max_incidence_deg);
    a->Visit("unknown_m", &unknown_m);
    a->Visit("unknown_survival", &unknown_survival);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// What a simulated measurement from one pose meets.
struct ScanGain {
  double entropy{};      ///< Of all voxels that its rays pass or end in, each time [bit].
  double quality{1.0};   ///< q_s (Eq. 1): of the surface that they meet; 1 when they meet none.
  double new_surface{};  ///< Surface that it would show for the first time, as expected [m^2].
};

/// The voxel space and what is known of a surface in it, laid out for the rays of many candidates:
/// a flat array that fits a processor's cache, of which a ray reads one number a voxel. Rays end in
/// occupied voxels and are not followed out of the grid. Threading: Measure() from any number of
/// threads.
class ScanGainField {
 public:
  /// b_i of Eq. 1 is taken as the share of mesh edges in a voxel that are *no* border, so that both
  /// terms are 1 where the surface is good and 1 - q_s (Eq. 2) asks for what is not; voxels without
  /// mesh say nothing of quality. New surface is expected in the voxels that are unknown, near to a
  /// trend and facing the sensor as the trend does: each by the chance that a ray gets there, past
  /// trends before it and through other unknown space, and that the surface is there.
  /// @throws ConfigError when `config` is not valid.
  ScanGainField(const world::BrickGrid& grid, const world::PartialMesh& surface,
                const std::vector<SurfaceTrend>& trends, const world::SupportPlane& plane_W,
                const ScanGainConfig& config = {});

  ScanGain Measure(const geometry::CameraModel& camera, const Pose& X_WC) const;

 private:
  /// A voxel: its entropy in units of 1 / kBit bit; whether rays end in it; whether it has a note.
  using Cell = std::uint16_t;
  static constexpr Cell kBit = (1 << 14) - 1;
  static constexpr Cell kEnd = 1 << 14;
  static constexpr Cell kNoted = 1 << 15;
  struct Trend {
    Eigen::Vector3f normal_W;
    float chance{};  ///< That the voxel holds surface.
  };

  ScanGainConfig config_;
  double voxel_;
  Eigen::Vector3d low_W_;
  Eigen::Vector3i size_;
  std::vector<Cell> cells_;
  std::vector<std::int32_t> notes_;  ///< Index of a quality; of a trend its complement, < 0.
  std::vector<float> qualities_;
  std::vector<Trend> trends_;
};

/// ω(n_s) of Eq. 3: the weight of quality against exploration after `scans`.
double QualityWeight(int scans, const ScanGainConfig& config);

/// f_utility (Eq. 2) of each candidate after `scans`. e_p is the entropy as a share of the largest
/// among the candidates: the paper does not say how it brings it to the scale of 1 - q_s.
std::vector<double> KriegelUtilities(const std::vector<ScanGain>& gains, int scans,
                                     const ScanGainConfig& config);

}  // namespace secondlook::planning

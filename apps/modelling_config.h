#pragma once

#include <string>

#include "lib/common/error.h"
#include "lib/planning/boundary_search.h"
#include "lib/planning/scan_gain.h"
#include "lib/world/surface_volume.h"

namespace secondlook::apps {

/// By what the next scan of a thing is chosen.
enum class ScanStrategy {
  kNewSurface,  ///< Most new surface, in the currency of all looks, a second: the default.
  kKriegel,     ///< f_utility (Kriegel 2013, Eq. 2).
  kRandom,      ///< Baseline: any.
  kFixedStep,   ///< Baseline: 45 degrees on round the thing from the last scan.
};

/// Parses "new surface", "Kriegel", "random" or "fixed step".
/// @throws ConfigError naming `text` and what is expected.
ScanStrategy ParseScanStrategy(const std::string& text);

/// How things that are in no database are modelled (Kriegel 2013). Of the sensor: `surface`, whose
/// voxels are as wide as the depth camera's pixels are apart two metres off, and `stands_m`, two of
/// its sigma at one metre. Of whoever gives the task: `coverage`, `scans` and `largest_m`. Chosen
/// by hand: the rest.
struct ModellingConfig {
  world::SurfaceConfig surface{.voxel_m = 0.004};
  planning::BoundarySearchConfig borders{.footing_m = 0.014};
  planning::ScanGainConfig gain{.max_range_m = 2.5, .stride = 1};
  std::string strategy{"new surface"};
  double coverage{0.95};  ///< A model is done when so much is seen of what the support leaves free…
  double worthwhile{0.02};      ///< …or no scan is expected to add this share of what is seen…
  int scans{12};                ///< …or after so many views more than there were.
  double least_coverage{0.5};   ///< A model that shows less is not kept.
  double largest_m{0.5};        ///< Things with a longer edge are not modelled.
  double around_m{0.06};        ///< Of the support and what stands beside is registered to, too.
  double stands_m{0.006};       ///< What is lower than this may be the support.
  double detail_m{0.005};       ///< Of the mesh that it is recognised by.
  double view_m{0.004};         ///< How well views are registered to the map…
  double view_rad{0.006};       ///< …and about each axis.
  int recognition_failures{6};  ///< After so many views in vain a thing is not recognised anew…
                                ///< until its model is done.

  template <class A>
  void Serialize(A* a) {
    a->Visit("surface", &surface);
    a->Visit("borders", &borders);
    a->Visit("gain", &gain);
    a->Visit("strategy", &strategy);
    a->Visit("coverage", &coverage);
    a->Visit("worthwhile", &worthwhile);
    a->Visit("scans", &scans);
    a->Visit("least_coverage", &least_coverage);
    a->Visit("largest_m", &largest_m);
    a->Visit("around_m", &around_m);
    a->Visit("stands_m", &stands_m);
    a->Visit("detail_m", &detail_m);
    a->Visit("view_m", &view_m);
    a->Visit("view_rad", &view_rad);
    a->Visit("recognition_failures", &recognition_failures);
  }

  /// @throws ConfigError naming the value.
  void Validate() const;
};

}  // namespace secondlook::apps

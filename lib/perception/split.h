#pragma once

#include <vector>

#include <Eigen/Core>

namespace secondlook::perception {

/// Where things that touch are told apart.
struct SplitConfig {
  double crease_deg = 50.0;  ///< A surface that folds inwards by more over twice `window_m`…
  double window_m = 0.016;   ///< …is two things; at least 6 sigma of the depth.
  double min_part_area_m2 = 0.0025;  ///< A smaller part belongs to the thing it touches…
  double min_part_width_m = 0.03;    ///< …and so does a narrower one: a handle.

  template <class A>
  void Serialize(A* a) {
    a->Visit("crease_deg", &crease_deg);
    a->Visit("window_m", &window_m);
    a->Visit("min_part_area_m2", &min_part_area_m2);
    a->Visit("min_part_width_m", &min_part_width_m);
  }

  /// @throws ConfigError naming the value that is out of range.
  void Validate() const;
};

/// Cuts a cluster where its surface folds inwards sharply: things are mostly convex, and where two
/// touch there is a crease (Stein et al., Object Partitioning using Local Convexity, CVPR 2014). A
/// bowl's inside is concave too, but bends slowly.
/// @return a label from 0 for each point [m, camera frame]; all 0 when there is nothing to cut.
std::vector<int> SplitAtCreases(const std::vector<Eigen::Vector3d>& points_C,
                                const SplitConfig& config);

}  // namespace secondlook::perception

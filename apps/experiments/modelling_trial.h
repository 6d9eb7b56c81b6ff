#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/experiments/free_camera.h"
#include "sim/scene.h"

namespace secondlook::apps {

/// Ways to choose the next scan. All but the first two have the candidates of Boundary Search;
/// where that finds none, and for "ours" always, views all around stand beside them.
inline const std::vector<std::string> kScanPlanners{"random views",  "uniform ring", "entropy only",
                                                    "boundary only", "Kriegel",      "ours"};

/// A model after some scans.
struct ModelledScan {
  double seconds{};    ///< Of robot time from the start.
  double reached{};    ///< The true share of the reachable surface that the model has, and…
  double whole{};      ///< …of all of it.
  double estimated{};  ///< ĉ_m (Kriegel 2013, Eq. 6).
  double estimated_reached{};  ///< Coverage::Reachable().
  double rms{};      ///< Distance of the model's vertices from the truth, once aligned [m].
  double density{};  ///< Relative point density, the mean over the vertices.
  double gain{};     ///< Share of its surface that "ours" expected of this scan; 0 for the others.
  std::string refused;  ///< Why its registration was refused; empty: it was not.
};

/// An object by itself on a table, scanned by the depth camera of the design wherever a planner
/// says. The camera's poses have the errors of an arm and of its hand-eye calibration.
class ModellingTrial {
 public:
  /// @throws ConfigError for a mesh that cannot be read.
  ModellingTrial(sim::SceneObject object, std::uint64_t seed);

  /// The share of the mesh's surface that any of 2,000 poses around it sees that keep clear of the
  /// table.
  double reachable() const { return reachable_share_; }

  /// Up to `scans` scans as `planner` says, from the same first view; fewer when it has no next.
  /// The same seed and planner give the same result.
  /// @throws InvalidArgument for a planner that is none of kScanPlanners.
  std::vector<ModelledScan> Follow(const std::string& planner, int scans);

 private:
  /// Points of the true surface.
  struct Truth {
    std::vector<Eigen::Vector3d> points_W;
    std::vector<Eigen::Vector3d> normals_W;
    std::vector<char> reachable;  ///< Of each.
  };

  std::uint64_t seed_;
  FreeCamera camera_;
  Eigen::Vector3d middle_W_;  ///< Of the table, a little above it: where the robot looks.
  Truth truth_;
  double reachable_share_{};
};

}  // namespace secondlook::apps

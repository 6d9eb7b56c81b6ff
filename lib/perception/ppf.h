#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lib/common/pose.h"
#include "lib/geometry/mesh.h"
#include "lib/geometry/sampling.h"
#include "lib/perception/symmetry.h"

namespace secondlook::perception {

/// A model's point pairs by their feature (Drost et al. 2010; Kriegel 2013, Eq. 4). The feature of
/// two oriented points is (|d|, angle(n1, d), angle(n2, d), angle(n1, n2)) with d = m2 - m1, true
/// angles, cut into cells of `spacing` and 12 degrees. The table is flat: the pairs of cell k are
/// entries [first[k], first[k + 1]).
struct PpfModel {
  /// A pair by its first point and the angle about that point's normal to its second.
  struct Entry {
    std::uint16_t reference;  ///< Index into `points`.
    std::uint16_t turn;       ///< [rad] 65536 / (2 pi), so that differences wrap around.
  };
  double diameter{};                            ///< Of the model [m].
  double spacing{};                             ///< Between its points [m].
  std::vector<geometry::OrientedPoint> points;  ///< In M.
  std::vector<std::uint32_t> first;             ///< One more than there are cells.
  std::vector<Entry> entries;
};

/// How many cells a table has whose points are drawn at `sampling`.
std::size_t PpfCellCount(double sampling);

/// Draws points at `sampling` (share of the diameter, in (0, 0.25]) from `mesh` and tabulates their
/// pairs. Pairs that lie in one plane are left out: they say next to nothing and would be most of
/// the votes. @pre !mesh.empty(). @throws InvalidArgument for another sampling.
PpfModel TrainPpf(const geometry::Mesh& mesh, double sampling = 0.05);

/// A pose the votes speak for.
struct PosePeak {
  Pose X_CM{Pose::Identity()};
  int votes{};
};

/// Lets every `stride`-th of `scene_C` (oriented points in C at about the model's spacing) pair
/// with all points nearer than the model's diameter and vote for a point of the model and a turn
/// about the normal. A pair looks into the neighbouring cells too where it lies near a border, and
/// votes once for each (point, turn). Returns each reference point's highest peak and those within
/// 90 % of it, at most three a point, in the order of the scene.
std::vector<PosePeak> VotePpf(const PpfModel& model,
                              const std::vector<geometry::OrientedPoint>& scene_C, int stride);

/// Gathers peaks whose poses are within `distance` [m] and `angle` [rad] up to the symmetry of
/// shape: each joins the nearest of the clusters, which are seeded in the order of falling votes.
/// Returns the seeds with the votes of their clusters, falling.
std::vector<PosePeak> ClusterPeaks(std::vector<PosePeak> peaks, const Symmetry& symmetry,
                                   const Eigen::Vector3d& center_M, double distance, double angle);

}  // namespace secondlook::perception

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/geometry/mesh.h"
#include "lib/perception/ppf.h"
#include "lib/perception/symmetry.h"
#include "lib/world/object_database.h"
#include "lib/world/support_plane.h"

namespace secondlook::perception {

/// A point of a model's surface, in M.
struct ModelPoint {
  Eigen::Vector3f point;   ///< [m]
  Eigen::Vector3f normal;  ///< Unit, outward.
  Eigen::Vector3f color;   ///< RGB in [0, 1], the mean of a patch of about 1 % of the diameter.
};

/// All that recognition prepares from one object of the database: a cache, keyed by `hash`.
struct RecognitionModel {
  std::string name;
  std::uint64_t hash{};                               ///< Of the object it was made from.
  geometry::Mesh mesh;                                ///< In M [m].
  double diameter{};                                  ///< geometry::Diameter(mesh) [m].
  Eigen::Vector3d center_M{Eigen::Vector3d::Zero()};  ///< Mean of the surface [m].
  double area{};                                      ///< Of the surface [m^2].
  /// Drawn evenly by area, in random order: any prefix covers the whole.
  std::vector<ModelPoint> points;
  std::vector<Eigen::Vector3f> hull;  ///< Extreme vertices: no other touches a plane [m].
  /// Directions in M that point down when the model rests on a plane: its centre is lowest there
  /// among the directions around. The most stable first.
  std::vector<Eigen::Vector3d> resting_M;
  PpfModel ppf;
  Symmetry symmetry;
};

/// Prepares `object`. Deterministic. @pre the mesh is not empty.
RecognitionModel TrainModel(const world::ObjectModel& object);

/// Prepares every object of `database`, in its order.
std::vector<RecognitionModel> TrainModels(const world::ObjectDatabase& database);

/// The lowest height of the model at X_CM above the plane n . p = d of C [m].
double LowestHeight(const RecognitionModel& model, const Pose& X_CM,
                    const world::SupportPlane& plane_C);

}  // namespace secondlook::perception

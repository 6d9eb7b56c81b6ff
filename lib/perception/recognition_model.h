#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

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
  static constexpr int kPoints = 1600;  ///< How many `points` there are.

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

/// Prepares `object`. Deterministic. The mesh may be wound the wrong way, in whole or in part.
/// @throws InvalidArgument naming the object: a mesh without a triangle or without area, a vertex
/// that is not finite, or a declared symmetry that its shape does not have.
RecognitionModel TrainModel(const world::ObjectModel& object);

/// Prepares every object of `database`, in its order. What was trained from an object that lies in
/// a folder is kept in a file beside that (TrainingFile()) and read from there the next time; a
/// file that does not fit the object or is damaged is warned about and made anew, and one that
/// cannot be written is warned about. @throws InvalidArgument as TrainModel does.
std::vector<RecognitionModel> TrainModels(const world::ObjectDatabase& database);

/// The one of `models` that is called `name`; null when none is.
const RecognitionModel* FindModel(const std::vector<RecognitionModel>& models,
                                  const std::string& name);

/// The box in A that the model at X_AM fills [m].
Eigen::AlignedBox3d BoxOf(const RecognitionModel& model, const Pose& X_AM);

/// The lowest height of the model at X_CM above the plane n . p = d of C [m].
double LowestHeight(const RecognitionModel& model, const Pose& X_CM,
                    const world::SupportPlane& plane_C);

}  // namespace secondlook::perception

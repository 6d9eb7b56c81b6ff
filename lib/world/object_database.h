#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/time.h"
#include "lib/geometry/mesh.h"

namespace secondlook::world {

/// Turns about a line through the middle of an object's bounding box that leave it as it is, by the
/// word of the user: what print or a seam may tell apart does not matter.
struct DeclaredSymmetry {
  Eigen::Vector3d direction_M{Eigen::Vector3d::Zero()};  ///< Of the line. Unit.
  int fold{};  ///< So many equal steps make a whole turn, >= 2; 0: any turn.
};

/// Parses "z" (any turn about the z axis of M), "z:4" (quarter turns), "0,1,1:2" (half turns about
/// that direction). @throws InvalidArgument naming `text` and what is expected.
DeclaredSymmetry ParseSymmetry(const std::string& text);

/// As ParseSymmetry() reads it.
std::string Text(const DeclaredSymmetry& symmetry);

/// Where a model comes from that was made by scanning an object.
struct Provenance {
  std::string sensor;  ///< What scanned it, e.g. "striper".
  int scans{};         ///< That it rests on, > 0.
  double coverage{};   ///< Share of the surface that can be seen which they show, in [0, 1].
  Time finished{};     ///< When it was stored, by the robot's clock.
};

/// Its time as a date, "2026-03-01T12:34:56Z", or "after 83 s of simulated time", which has none.
std::string DateOf(const Provenance& provenance);

/// One known object.
struct ObjectModel {
  std::string name;
  geometry::Mesh mesh;  ///< Model frame M [m].
  /// Of the mesh, material and texture files and the declared symmetries; caches are keyed by it.
  std::uint64_t hash{};
  std::filesystem::path folder{};  ///< Where it was read from; empty: nowhere.
  std::vector<DeclaredSymmetry> symmetries{};
  std::optional<Provenance> provenance{};  ///< Empty: its mesh was given.
};

/// The sub-folders of `folder` that hold a model, by name; those that AddModel has not finished are
/// not among them.
/// @throws ConfigError when the folder is missing or holds none.
std::vector<std::filesystem::path> ModelFolders(const std::filesystem::path& folder);

/// Reads the model in `folder`, one of ModelFolders().
/// @throws ConfigError naming the file: format other than 1, a mesh that LoadMesh refuses, or a
/// file that no longer has the hash it was added with.
ObjectModel ReadModel(const std::filesystem::path& folder);

/// The mesh with all its detail of the model in `folder`: of one that was scanned more than it is
/// recognised by. @throws ConfigError as ReadModel() does.
geometry::Mesh ReadFullMesh(const std::filesystem::path& folder);

/// The objects the robot knows. On disk: a folder with one sub-folder per object that holds
/// `model.yaml` {format: 1, name, mesh, unit, hash, symmetries, scanned} and the mesh file with
/// what it refers to. That of a scanned object also holds `full/mesh.obj`.
class ObjectDatabase {
 public:
  ObjectDatabase() = default;

  /// Reads every object of `folder`, in the order of their names.
  /// @throws ConfigError as ModelFolders and ReadModel do, and for two objects of one name.
  static ObjectDatabase Load(const std::filesystem::path& folder);

  /// A database of `models`, as tests use it. @throws InvalidArgument for two of one name.
  explicit ObjectDatabase(std::vector<ObjectModel> models);

  /// Adds one more. @throws InvalidArgument when there is one of its name.
  void Add(ObjectModel model);

  const std::vector<ObjectModel>& models() const { return models_; }

  /// The object called `name`, or null.
  const ObjectModel* Find(const std::string& name) const;

 private:
  std::vector<ObjectModel> models_;
};

/// Adds the mesh of `mesh_file`, whose unit is `unit`, as `name` to the database in `folder` (made
/// when missing). The object is written whole to a temporary folder and renamed.
/// @throws ConfigError for a name that is taken or is no plain file name, or when LoadMesh refuses.
void AddModel(const std::filesystem::path& mesh_file, geometry::LengthUnit unit,
              const std::string& name, const std::filesystem::path& folder,
              const std::vector<DeclaredSymmetry>& symmetries = {});

/// An object that was scanned.
struct ScannedModel {
  std::string name;
  geometry::Mesh full;  ///< As it was scanned, in M [m].
  geometry::Mesh mesh;  ///< The same with the detail that recognition needs.
  Provenance provenance;
};

/// Adds `model` to the database in `folder`, as AddModel() does: whole or not at all.
/// @throws InvalidArgument for a mesh without triangles or a provenance out of range; ConfigError
/// for a name that is taken or is no plain file name, or when it cannot be written, e.g. on a full
/// disk: then nothing is left of it.
void StoreModel(const ScannedModel& model, const std::filesystem::path& folder);

/// The first of "PREFIX_1", "PREFIX_2" … that no model in `folder` has, which need not exist.
std::string UnusedName(const std::string& prefix, const std::filesystem::path& folder);

/// Removes `name` from the database in `folder`. @throws ConfigError when there is none.
void RemoveModel(const std::string& name, const std::filesystem::path& folder);

}  // namespace secondlook::world

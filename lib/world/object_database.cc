#include "lib/world/object_database.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <ctime>
#include <system_error>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/hash.h"
#include "lib/common/numbers.h"
#include "lib/common/yaml_reader.h"

namespace secondlook::world {
namespace {

namespace fs = std::filesystem;

constexpr int kFormat = 1;
constexpr const char* kMetadata = "model.yaml";
constexpr const char* kMesh = "mesh.obj";
constexpr const char* kFull = "full";
constexpr int kMostFold = 24;
/// 2000-01-01: a clock that shows less counts from the robot's start, as a simulated one does.
constexpr std::chrono::seconds kFirstDate{946'684'800};

/// Provenance as model.yaml has it.
struct ScannedText {
  std::string sensor;
  int scans{};
  double coverage{};
  std::string date;
  std::uint64_t time_ns{};
  std::string full_hash;

  template <class A>
  void Serialize(A* a) {
    a->Visit("sensor", &sensor);
    a->Visit("scans", &scans);
    a->Visit("coverage", &coverage);
    a->Visit("date", &date);
    a->Visit("time_ns", &time_ns);
    a->Visit("full_hash", &full_hash);
  }
};

/// The content of model.yaml.
struct Metadata {
  int format{};
  std::string name;
  std::string mesh;
  std::string unit;
  std::string hash;
  std::vector<std::string> symmetries;
  std::optional<ScannedText> scanned;

  template <class A>
  void Serialize(A* a) {
    a->Visit("format", &format);
    a->Visit("name", &name);
    a->Visit("mesh", &mesh);
    a->Visit("unit", &unit);
    a->Visit("hash", &hash);
    a->Visit("symmetries", &symmetries);
    a->Visit("scanned", &scanned);
  }
};

/// The hash of the mesh file and then, by name, of all that lies beside it except model.yaml.
std::uint64_t HashOf(const fs::path& folder, const std::string& mesh) {
  std::vector<std::string> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && name != kMetadata && name != mesh) others.push_back(name);
  }
  std::sort(others.begin(), others.end());
  std::uint64_t hash = Fnv1a(ReadFile(folder / mesh));
  for (const std::string& other : others) hash = Fnv1a(ReadFile(folder / other), hash);
  return hash;
}

Metadata ReadMetadata(const fs::path& file) {
  YAML::Node node;
  try {
    node = YAML::Load(ReadFile(file));
  } catch (const YAML::Exception& e) {
    Throw<ConfigError>("{}:{}:{}: {}", file.string(), e.mark.line + 1, e.mark.column + 1, e.msg);
  }
  // The format is looked at first: another one may have keys that this program does not know.
  const YAML::Node format = node.IsMap() ? node["format"] : YAML::Node();
  if (!format || !format.IsScalar() || format.Scalar() != std::to_string(kFormat)) {
    Throw<ConfigError>(
        "{}: format {}; this program reads format {}: add the model anew", file.string(),
        format && format.IsScalar() ? format.Scalar() : std::string("missing"), kFormat);
  }
  Metadata metadata;
  YamlReader(node, file.string(), "").Read(&metadata);
  return metadata;
}

std::string MetadataText(const std::string& name, std::uint64_t hash,
                         const std::vector<DeclaredSymmetry>& symmetries) {
  std::string text =
      fmt::format("format: {}\nname: \"{}\"\nmesh: mesh.obj\nunit: m\nhash: \"{}\"\n", kFormat,
                  name, HexDigits(hash));
  if (!symmetries.empty()) text += "symmetries:\n";
  for (const DeclaredSymmetry& symmetry : symmetries) {
    text += fmt::format("  - \"{}\"\n", Text(symmetry));
  }
  return text;
}

void SortByName(std::vector<ObjectModel>* models) {
  std::sort(models->begin(), models->end(),
            [](const ObjectModel& a, const ObjectModel& b) { return a.name < b.name; });
}

/// The name that two of the sorted `models` share, or null.
const std::string* SharedName(const std::vector<ObjectModel>& models) {
  for (std::size_t i = 1; i < models.size(); ++i) {
    if (models[i].name == models[i - 1].name) return &models[i].name;
  }
  return nullptr;
}

/// True for the name of something that lies in a folder, and in no other.
bool IsPlain(const std::string& name) {
  return !name.empty() && name.front() != '.' &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
         });
}

void CheckName(const std::string& name) {
  if (name == "unknown") {
    throw ConfigError(
        "model name 'unknown' is what an object is called that no model fits; choose another");
  }
  if (!IsPlain(name)) {
    Throw<ConfigError>(
        "model name '{}' is no plain file name: use letters, digits, '_', '-' and '.', and do not "
        "begin with '.'",
        name);
  }
}

std::string ScannedLines(const Provenance& provenance, std::uint64_t full_hash) {
  return fmt::format(
      "scanned:\n  sensor: \"{}\"\n  scans: {}\n  coverage: {}\n  date: \"{}\"\n  time_ns: {}\n  "
      "full_hash: \"{}\"\n",
      provenance.sensor, provenance.scans, provenance.coverage, DateOf(provenance),
      provenance.finished.time_since_epoch().count(), HexDigits(full_hash));
}

void CheckUntaken(const std::string& name, const fs::path& folder) {
  CheckName(name);
  if (!fs::exists(folder / name)) return;
  Throw<ConfigError>(
      "{}: there is a model of this name already; remove it first or choose another name",
      (folder / name).string());
}

/// Makes the model's folder: `write` fills one that nobody reads, which is then renamed. Nothing
/// stays of it when that throws.
template <class Write>
void MakeWhole(const std::string& name, const fs::path& folder, const Write& write) {
  MakeWritableFolder(folder);
  const fs::path unfinished = folder / ("." + name + ".unfinished");
  std::error_code error;
  fs::remove_all(unfinished, error);
  try {
    MakeWritableFolder(unfinished);
    write(unfinished);
    fs::rename(unfinished, folder / name, error);
    if (error) {
      Throw<ConfigError>("{}: cannot be made: {}", (folder / name).string(), error.message());
    }
  } catch (...) {
    fs::remove_all(unfinished, error);
    throw;
  }
}

void CheckScanned(const ScannedModel& model) {
  if (model.full.empty() || model.mesh.empty()) {
    Throw<InvalidArgument>("model '{}': a scanned mesh has no triangle", model.name);
  }
  const Provenance& p = model.provenance;
  const bool plain = std::all_of(p.sensor.begin(), p.sensor.end(), [](unsigned char c) {
    return std::isprint(c) != 0 && c != '"' && c != '\\';
  });
  if (p.sensor.empty() || !plain || p.scans < 1 || !(p.coverage >= 0.0 && p.coverage <= 1.0) ||
      p.finished < Time{}) {
    Throw<InvalidArgument>(
        "model '{}': made from {} scans by '{}' with a coverage of {}; it needs a sensor, a scan "
        "and a coverage in 0..1",
        model.name, p.scans, p.sensor, p.coverage);
  }
}

}  // namespace

DeclaredSymmetry ParseSymmetry(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string axis = text.substr(0, colon);
  const bool letter = axis.size() == 1 && axis[0] >= 'x' && axis[0] <= 'z';
  const std::vector<double> direction = ParseNumbers(axis).value_or(std::vector<double>{});
  DeclaredSymmetry symmetry;
  if (letter) symmetry.direction_M = Eigen::Vector3d::Unit(axis[0] - 'x');
  if (direction.size() == 3) symmetry.direction_M = {direction[0], direction[1], direction[2]};
  bool valid = symmetry.direction_M.norm() > 1e-9;
  if (colon != std::string::npos) {
    const double fold = ParseNumber(text.substr(colon + 1)).value_or(0.0);
    valid = valid && fold >= 2.0 && fold <= kMostFold && fold == std::floor(fold);
    if (valid) symmetry.fold = static_cast<int>(fold);
  }
  if (!valid) {
    Throw<InvalidArgument>(
        "symmetry '{}': give an axis (x, y, z, or a direction such as 0,1,1) for any turn about "
        "it, "
        "or with the steps of a whole turn, from 2 to {}, such as z:4",
        text, kMostFold);
  }
  symmetry.direction_M.normalize();
  return symmetry;
}

std::string Text(const DeclaredSymmetry& symmetry) {
  const Eigen::Vector3d& d = symmetry.direction_M;
  std::string text = fmt::format("{},{},{}", d.x(), d.y(), d.z());
  for (int i = 0; i < 3; ++i) {
    if (d == Eigen::Vector3d::Unit(i)) text = std::string(1, static_cast<char>('x' + i));
  }
  return symmetry.fold == 0 ? text : fmt::format("{}:{}", text, symmetry.fold);
}

std::string DateOf(const Provenance& provenance) {
  const auto since = provenance.finished.time_since_epoch();
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since).count();
  if (since < kFirstDate) return fmt::format("after {} s of simulated time", seconds);
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

std::vector<fs::path> ModelFolders(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    Throw<ConfigError>("{}: no such folder of models", folder.string());
  }
  std::vector<fs::path> folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool unfinished = entry.path().filename().string().starts_with('.');
    if (!unfinished && entry.is_directory() && fs::exists(entry.path() / kMetadata)) {
      folders.push_back(entry.path());
    }
  }
  if (folders.empty()) {
    Throw<ConfigError>(
        "{}: no models: there is no sub-folder with a model.yaml; add one with 'secondlook model "
        "add'",
        folder.string());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

ObjectModel ReadModel(const fs::path& folder) {
  const fs::path file = folder / kMetadata;
  const Metadata metadata = ReadMetadata(file);
  if (metadata.name.empty() || metadata.mesh.empty()) {
    Throw<ConfigError>("{}: name and mesh must both be given", file.string());
  }
  if (!IsPlain(metadata.name) || !IsPlain(metadata.mesh)) {
    Throw<ConfigError>(
        "{}: name '{}' and mesh '{}' must be plain file names: letters, digits, '_', '-' and '.', "
        "not '.' at the beginning",
        file.string(), metadata.name, metadata.mesh);
  }
  geometry::LengthUnit unit{};
  try {
    unit = geometry::ParseLengthUnit(metadata.unit);
  } catch (const InvalidArgument& e) {
    Throw<ConfigError>("{}: unit: {}", file.string(), e.what());
  }
  const std::uint64_t hash = HashOf(folder, metadata.mesh);
  if (HexDigits(hash) != metadata.hash) {
    Throw<ConfigError>(
        "{}: the files of '{}' have hash {} but were added with {}: they have changed; remove the "
        "model and add it anew",
        file.string(), metadata.name, HexDigits(hash), metadata.hash);
  }
  ObjectModel model{metadata.name, geometry::LoadMesh(folder / metadata.mesh, unit), hash, folder};
  for (const std::string& symmetry : metadata.symmetries) {
    try {
      model.symmetries.push_back(ParseSymmetry(symmetry));
    } catch (const InvalidArgument& e) {
      Throw<ConfigError>("{}: {}", file.string(), e.what());
    }
    model.hash = Fnv1a(symmetry, model.hash);
  }
  if (metadata.scanned) {
    const ScannedText& scanned = *metadata.scanned;
    model.provenance = Provenance{scanned.sensor, scanned.scans, scanned.coverage,
                                  Time(Duration(static_cast<Duration::rep>(scanned.time_ns)))};
  }
  return model;
}

geometry::Mesh ReadFullMesh(const fs::path& folder) {
  const Metadata metadata = ReadMetadata(folder / kMetadata);
  if (!metadata.scanned) return ReadModel(folder).mesh;
  const std::uint64_t hash = HashOf(folder / kFull, kMesh);
  if (HexDigits(hash) != metadata.scanned->full_hash) {
    Throw<ConfigError>(
        "{}: its files have hash {} but were stored with {}: they have changed; remove the model "
        "and scan the object anew",
        (folder / kFull).string(), HexDigits(hash), metadata.scanned->full_hash);
  }
  return geometry::LoadMesh(folder / kFull / kMesh, geometry::LengthUnit::kMetre);
}

ObjectDatabase::ObjectDatabase(std::vector<ObjectModel> models) : models_(std::move(models)) {
  SortByName(&models_);
  if (const std::string* name = SharedName(models_)) {
    Throw<InvalidArgument>("two objects are named '{}'", *name);
  }
}

ObjectDatabase ObjectDatabase::Load(const fs::path& folder) {
  ObjectDatabase database;
  for (const fs::path& model : ModelFolders(folder)) database.models_.push_back(ReadModel(model));
  SortByName(&database.models_);
  if (const std::string* name = SharedName(database.models_)) {
    Throw<ConfigError>("{}: two objects are named '{}': remove one", folder.string(), *name);
  }
  return database;
}

void ObjectDatabase::Add(ObjectModel model) {
  if (Find(model.name) != nullptr) Throw<InvalidArgument>("two objects are named '{}'", model.name);
  models_.push_back(std::move(model));
  SortByName(&models_);
}

const ObjectModel* ObjectDatabase::Find(const std::string& name) const {
  const auto found = std::find_if(models_.begin(), models_.end(),
                                  [&](const ObjectModel& model) { return model.name == name; });
  return found == models_.end() ? nullptr : &*found;
}

void AddModel(const fs::path& mesh_file, geometry::LengthUnit unit, const std::string& name,
              const fs::path& folder, const std::vector<DeclaredSymmetry>& symmetries) {
  CheckUntaken(name, folder);
  const geometry::Mesh mesh = geometry::LoadMesh(mesh_file, unit);
  MakeWhole(name, folder, [&](const fs::path& unfinished) {
    geometry::SaveObj(mesh, unfinished);
    WriteFile(unfinished / kMetadata, MetadataText(name, HashOf(unfinished, kMesh), symmetries));
  });
}

void StoreModel(const ScannedModel& model, const fs::path& folder) {
  CheckScanned(model);
  CheckUntaken(model.name, folder);
  MakeWhole(model.name, folder, [&](const fs::path& unfinished) {
    geometry::SaveObj(model.mesh, unfinished);
    geometry::SaveObj(model.full, unfinished / kFull);
    WriteFile(unfinished / kMetadata,
              MetadataText(model.name, HashOf(unfinished, kMesh), {}) +
                  ScannedLines(model.provenance, HashOf(unfinished / kFull, kMesh)));
  });
}

std::string UnusedName(const std::string& prefix, const fs::path& folder) {
  for (int i = 1;; ++i) {
    std::string name = fmt::format("{}_{}", prefix, i);
    if (!fs::exists(folder / name)) return name;
  }
}

void RemoveModel(const std::string& name, const fs::path& folder) {
  CheckName(name);
  const fs::path target = folder / name;
  if (!fs::exists(target / kMetadata)) {
    Throw<ConfigError>("{}: there is no model named '{}'", folder.string(), name);
  }
  std::error_code error;
  fs::remove_all(target, error);
  if (error) Throw<ConfigError>("{}: cannot be removed: {}", target.string(), error.message());
}

}  // namespace secondlook::world

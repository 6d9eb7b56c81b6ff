#include "lib/perception/training_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/hash.h"

namespace secondlook::perception {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "files are written as memory is");

constexpr std::string_view kMagic = "SLTRAIN\n";
/// To be raised whenever the layout changes, or what TrainModel() makes of a mesh.
constexpr std::uint32_t kVersion = 1;
constexpr std::uintmax_t kMostBytes = 50'000'000;
constexpr std::size_t kHead = 8 + sizeof(kVersion) + 3 * sizeof(std::uint64_t);

class Writer {
 public:
  template <class T>
  void Put(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }

  template <class T>
  void PutAll(const std::vector<T>& values) {
    Put(static_cast<std::uint32_t>(values.size()));
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(std::string_view bytes, const fs::path& file) : bytes_(bytes), file_(file) {}

  template <class T>
  T Get() {
    T value;
    std::memcpy(static_cast<void*>(&value), Take(1, sizeof(T)).data(), sizeof(T));
    return value;
  }

  template <class T>
  std::vector<T> GetAll() {
    const auto count = Get<std::uint32_t>();
    const std::string_view taken = Take(count, sizeof(T));
    std::vector<T> values(count);
    if (count > 0) std::memcpy(static_cast<void*>(values.data()), taken.data(), taken.size());
    return values;
  }

  std::size_t left() const { return bytes_.size(); }

 private:
  /// The next `count` values of `size` bytes, which must be there.
  std::string_view Take(std::size_t count, std::size_t size) {
    if (count > bytes_.size() / size) {
      Throw<ConfigError>(
          "{}: is damaged: {} values of {} bytes are to follow, but {} bytes are left",
          file_.string(), count, size, bytes_.size());
    }
    const std::string_view taken = bytes_.substr(0, count * size);
    bytes_.remove_prefix(taken.size());
    return taken;
  }

  std::string_view bytes_;
  const fs::path& file_;
};

void PutPpf(const PpfModel& ppf, Writer* out) {
  out->Put(ppf.diameter);
  out->Put(ppf.spacing);
  out->PutAll(ppf.points);
  out->PutAll(ppf.first);
  out->PutAll(ppf.entries);
}

PpfModel GetPpf(Reader* in) {
  PpfModel ppf;
  ppf.diameter = in->Get<double>();
  ppf.spacing = in->Get<double>();
  ppf.points = in->GetAll<geometry::OrientedPoint>();
  ppf.first = in->GetAll<std::uint32_t>();
  ppf.entries = in->GetAll<PpfModel::Entry>();
  return ppf;
}

void PutSymmetry(const Symmetry& symmetry, Writer* out) {
  out->Put(static_cast<std::uint32_t>(symmetry.motions.size()));
  for (const SymmetryMotion& motion : symmetry.motions) {
    out->Put(motion.X_MS.matrix());
    out->Put(static_cast<std::uint8_t>(motion.keeps_color));
  }
  out->Put(static_cast<std::uint8_t>(symmetry.axis.has_value()));
  const Axis axis = symmetry.axis.value_or(Axis{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  out->Put(axis.point);
  out->Put(axis.direction);
  out->Put(static_cast<std::uint8_t>(symmetry.axis_keeps_color));
}

Symmetry GetSymmetry(Reader* in) {
  Symmetry symmetry;
  const auto motions = in->Get<std::uint32_t>();
  for (std::uint32_t i = 0; i < motions; ++i) {
    SymmetryMotion motion;
    motion.X_MS.matrix() = in->Get<Eigen::Matrix4d>();
    motion.keeps_color = in->Get<std::uint8_t>() != 0;
    symmetry.motions.push_back(motion);
  }
  const bool turns = in->Get<std::uint8_t>() != 0;
  const auto point = in->Get<Eigen::Vector3d>();
  const auto direction = in->Get<Eigen::Vector3d>();
  if (turns) symmetry.axis = Axis{point, direction};
  symmetry.axis_keeps_color = in->Get<std::uint8_t>() != 0;
  return symmetry;
}

std::string PayloadOf(const RecognitionModel& model) {
  Writer out;
  out.Put(model.diameter);
  out.Put(model.center_M);
  out.Put(model.area);
  out.PutAll(model.points);
  out.PutAll(model.hull);
  out.PutAll(model.resting_M);
  PutPpf(model.ppf, &out);
  PutSymmetry(model.symmetry, &out);
  return out.bytes();
}

/// What is wrong with the values read; empty: nothing is.
std::string_view Flaw(const RecognitionModel& model) {
  const PpfModel& ppf = model.ppf;
  if (model.points.size() != RecognitionModel::kPoints) return "another number of surface points";
  if (model.hull.empty()) return "no extreme vertices";
  if (model.symmetry.motions.empty()) return "no identity among the symmetries";
  if (!(model.diameter > 0.0 && model.area > 0.0 && ppf.diameter > 0.0 && ppf.spacing > 0.0)) {
    return "a size that is not positive";
  }
  if (ppf.first.size() != PpfCellCount(ppf.spacing / ppf.diameter) + 1 || ppf.first.front() != 0 ||
      ppf.first.back() != ppf.entries.size() ||
      !std::is_sorted(ppf.first.begin(), ppf.first.end())) {
    return "cells of point pairs that do not follow each other";
  }
  const bool inside = std::all_of(
      ppf.entries.begin(), ppf.entries.end(),
      [&](const PpfModel::Entry& entry) { return entry.reference < ppf.points.size(); });
  return inside ? "" : "a point pair of a point that there is not";
}

}  // namespace

fs::path TrainingFile(const fs::path& folder) {
  fs::path file = folder;
  file += ".recognition";
  return file;
}

void SaveTraining(const RecognitionModel& model, const fs::path& file) {
  const std::string payload = PayloadOf(model);
  if (kHead + payload.size() > kMostBytes) {
    Throw<ConfigError>("{}: would take {} bytes (at most {})", file.string(),
                       kHead + payload.size(), kMostBytes);
  }
  Writer head;
  head.Put(kVersion);
  head.Put(model.hash);
  head.Put(std::uint64_t{payload.size()});
  head.Put(Fnv1a(payload));
  WriteFile(file, std::string(kMagic) + head.bytes() + payload);
}

RecognitionModel LoadTraining(const world::ObjectModel& object, const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) Throw<ConfigError>("{}: cannot be read: {}", file.string(), error.message());
  if (size > kMostBytes) {
    Throw<ConfigError>("{}: has {} bytes (at most {}): no training file is so large", file.string(),
                       size, kMostBytes);
  }
  const std::string bytes = ReadFile(file);
  if (!bytes.starts_with(kMagic)) Throw<ConfigError>("{}: is no training file", file.string());
  if (bytes.size() < kHead) {
    Throw<ConfigError>("{}: is truncated: {} bytes are less than its head", file.string(),
                       bytes.size());
  }
  Reader head(std::string_view(bytes).substr(kMagic.size()), file);
  const auto version = head.Get<std::uint32_t>();
  if (version != kVersion) {
    Throw<ConfigError>("{}: is of version {}; this program reads version {}", file.string(),
                       version, kVersion);
  }
  const auto hash = head.Get<std::uint64_t>();
  if (hash != object.hash) {
    Throw<ConfigError>("{}: was trained from an object with hash {}, and '{}' has hash {}",
                       file.string(), HexDigits(hash), object.name, HexDigits(object.hash));
  }
  const auto length = head.Get<std::uint64_t>();
  const auto checksum = head.Get<std::uint64_t>();
  const std::string_view payload = std::string_view(bytes).substr(kHead);
  if (payload.size() != length) {
    Throw<ConfigError>("{}: is truncated: it holds {} of {} bytes", file.string(), payload.size(),
                       length);
  }
  if (Fnv1a(payload) != checksum) {
    Throw<ConfigError>("{}: is damaged: its checksum is not right", file.string());
  }
  Reader in(payload, file);
  RecognitionModel model;
  model.name = object.name;
  model.hash = object.hash;
  model.mesh = object.mesh;
  model.diameter = in.Get<double>();
  model.center_M = in.Get<Eigen::Vector3d>();
  model.area = in.Get<double>();
  model.points = in.GetAll<ModelPoint>();
  model.hull = in.GetAll<Eigen::Vector3f>();
  model.resting_M = in.GetAll<Eigen::Vector3d>();
  model.ppf = GetPpf(&in);
  model.symmetry = GetSymmetry(&in);
  if (in.left() > 0) {
    Throw<ConfigError>("{}: is damaged: {} bytes are left over", file.string(), in.left());
  }
  if (const std::string_view flaw = Flaw(model); !flaw.empty()) {
    Throw<ConfigError>("{}: is damaged: it has {}", file.string(), flaw);
  }
  return model;
}

}  // namespace secondlook::perception

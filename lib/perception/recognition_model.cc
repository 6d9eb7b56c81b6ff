#include "lib/perception/recognition_model.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <utility>

#include <spdlog/spdlog.h>

#include "lib/common/error.h"
#include "lib/common/parallel.h"
#include "lib/common/rng.h"
#include "lib/geometry/orient.h"
#include "lib/geometry/sampling.h"
#include "lib/perception/declared_symmetry.h"
#include "lib/perception/training_file.h"

namespace secondlook::perception {
namespace {

constexpr int kPatch = 4;  // drawn points whose colours make one
constexpr int kMaxResting = 10;
/// Coarser than the 0.05 of the literature: what hypotheses are lost to it the resting poses give
/// back, at a quarter of the votes.
constexpr double kPpfSampling = 0.07;

double AreaOf(const geometry::Mesh& mesh) {
  double area = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3f& a = mesh.vertices[t[0]];
    area += 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
  }
  return area;
}

/// The mean colour around a point of a triangle, over a square of half-width `radius` [m] laid into
/// the triangle's plane and clamped to the triangle.
Eigen::Vector3f PatchColor(const geometry::Mesh& mesh, const geometry::MeshSample& sample,
                           float radius, Rng* rng) {
  const Eigen::Vector3i& t = mesh.triangles[static_cast<std::size_t>(sample.triangle)];
  const float edge = std::max((mesh.vertices[t[1]] - mesh.vertices[t[0]]).norm(),
                              (mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm());
  const float reach = std::min(radius / std::max(edge, 1e-6F), 0.5F);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (int i = 0; i < kPatch; ++i) {
    Eigen::Vector3f w = sample.weights;
    w[1] = std::clamp(w[1] + reach * static_cast<float>(rng->Uniform(-1.0, 1.0)), 0.0F, 1.0F);
    w[2] =
        std::clamp(w[2] + reach * static_cast<float>(rng->Uniform(-1.0, 1.0)), 0.0F, 1.0F - w[1]);
    w[0] = 1.0F - w[1] - w[2];
    sum += geometry::ColorAt(mesh, sample.triangle, w);
  }
  return sum / static_cast<float>(kPatch);
}

/// How high the centre lies above the lowest point when `down` points down.
double CenterHeight(const std::vector<Eigen::Vector3f>& vertices, const Eigen::Vector3d& center,
                    const Eigen::Vector3d& down) {
  const Eigen::Vector3f d = down.cast<float>();
  float lowest = -std::numeric_limits<float>::max();
  for (const Eigen::Vector3f& v : vertices) lowest = std::max(lowest, d.dot(v));
  return lowest - down.dot(center);
}

/// Extreme vertices: those that are the farthest in one of many directions. Others touch no plane.
std::vector<Eigen::Vector3f> HullPoints(const std::vector<Eigen::Vector3f>& vertices,
                                        const std::vector<Eigen::Vector3d>& directions) {
  std::vector<std::size_t> kept;
  for (const Eigen::Vector3d& direction : directions) {
    const Eigen::Vector3f d = direction.cast<float>();
    std::size_t best = 0;
    for (std::size_t i = 1; i < vertices.size(); ++i) {
      if (d.dot(vertices[i]) > d.dot(vertices[best])) best = i;
    }
    kept.push_back(best);
  }
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  std::vector<Eigen::Vector3f> points;
  for (const std::size_t i : kept) points.push_back(vertices[i]);
  return points;
}

/// Directions spread evenly over the sphere (a Fibonacci lattice).
std::vector<Eigen::Vector3d> SphereDirections(int count) {
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count;
    const double r = std::sqrt(1.0 - z * z);
    directions.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return directions;
}

/// True when the symmetry of the shape takes one direction to the other.
bool SameDirection(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Symmetry& symmetry) {
  constexpr double kSame = 0.97;  // cosine of 14 degrees
  for (const SymmetryMotion& motion : symmetry.motions) {
    const Eigen::Vector3d turned = motion.X_MS.linear() * b;
    if (symmetry.axis) {
      const double along_a = std::acos(std::clamp(symmetry.axis->direction.dot(a), -1.0, 1.0));
      const double along_b = std::acos(std::clamp(symmetry.axis->direction.dot(turned), -1.0, 1.0));
      if (std::abs(along_a - along_b) < std::acos(kSame)) return true;
    } else if (a.dot(turned) > kSame) {
      return true;
    }
  }
  return false;
}

/// A direction that points down, and how high the centre is then [m].
struct Rest {
  Eigen::Vector3d down;
  double height;
};

/// Rolls downhill by ever smaller steps, each in the best of `headings` directions.
Rest RollDown(Rest rest, const std::vector<Eigen::Vector3f>& hull, const Eigen::Vector3d& center,
              double first_step, int headings, int most_rounds) {
  for (double step = first_step; step > 0.004; step *= 0.5) {
    for (int round = 0; round < most_rounds; ++round) {
      const Eigen::Vector3d side = rest.down.unitOrthogonal();
      const Eigen::Vector3d other = rest.down.cross(side);
      Rest best = rest;
      for (int k = 0; k < headings; ++k) {
        const double angle = 2.0 * std::numbers::pi * k / headings;
        const Eigen::Vector3d down =
            (rest.down + step * (std::cos(angle) * side + std::sin(angle) * other)).normalized();
        const double height = CenterHeight(hull, center, down);
        if (height < best.height) best = {down, height};
      }
      if (best.height >= rest.height) break;
      rest = best;
    }
  }
  return rest;
}

/// The lowest of those that the symmetry joins, lowest first.
std::vector<Rest> Distinct(std::vector<Rest> rests, const Symmetry& symmetry) {
  std::stable_sort(rests.begin(), rests.end(),
                   [](const Rest& a, const Rest& b) { return a.height < b.height; });
  std::vector<Rest> distinct;
  for (const Rest& rest : rests) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Rest& other) {
      return SameDirection(other.down, rest.down, symmetry);
    });
    if (!known) distinct.push_back(rest);
  }
  return distinct;
}

std::vector<Eigen::Vector3d> RestingDirections(const std::vector<Eigen::Vector3f>& hull,
                                               const Eigen::Vector3d& center,
                                               const Symmetry& symmetry) {
  std::vector<Rest> rests;
  for (const Eigen::Vector3d& start : SphereDirections(100)) {
    rests.push_back(RollDown({start, CenterHeight(hull, center, start)}, hull, center, 0.2, 8, 6));
  }
  rests = Distinct(std::move(rests), symmetry);
  // Where two edges make a valley, few headings lead along it, and what looked like a rest is none.
  for (Rest& rest : rests) rest = RollDown(rest, hull, center, 0.05, 64, 40);
  std::vector<Eigen::Vector3d> directions;
  for (const Rest& rest : Distinct(std::move(rests), symmetry)) {
    directions.push_back(rest.down);
    if (directions.size() == kMaxResting) break;
  }
  return directions;
}

void CheckMesh(const world::ObjectModel& object) {
  if (object.mesh.empty()) {
    Throw<InvalidArgument>("model '{}': its mesh has no triangle", object.name);
  }
  const auto& vertices = object.mesh.vertices;
  const auto bad = std::find_if(vertices.begin(), vertices.end(),
                                [](const Eigen::Vector3f& v) { return !v.allFinite(); });
  if (bad != vertices.end()) {
    Throw<InvalidArgument>("model '{}': vertex {} of {} is not finite", object.name,
                           bad - vertices.begin(), vertices.size());
  }
}

/// `*not_kept` becomes the reason why the training could not be written, if so.
RecognitionModel LoadOrTrain(const world::ObjectModel& object, std::string* not_kept) {
  if (object.folder.empty()) return TrainModel(object);
  const std::filesystem::path file = TrainingFile(object.folder);
  if (std::filesystem::exists(file)) {
    try {
      return LoadTraining(object, file);
    } catch (const ConfigError& error) {
      spdlog::warn("{}; '{}' is trained anew", error.what(), object.name);
    }
  }
  RecognitionModel model = TrainModel(object);
  try {
    SaveTraining(model, file);
  } catch (const ConfigError& error) {
    *not_kept = error.what();
  }
  return model;
}

}  // namespace

RecognitionModel TrainModel(const world::ObjectModel& object) {
  constexpr int kPoints = RecognitionModel::kPoints;
  CheckMesh(object);
  RecognitionModel model;
  model.name = object.name;
  model.hash = object.hash;
  model.mesh = object.mesh;
  model.diameter = geometry::Diameter(object.mesh);
  model.area = AreaOf(object.mesh);
  if (!(model.area > 0.0))
    Throw<InvalidArgument>("model '{}': its surface has no area", object.name);
  geometry::Mesh outward = object.mesh;
  geometry::OrientOutward(&outward);
  Rng rng(1);
  for (const geometry::MeshSample& sample : geometry::SampleSurface(outward, kPoints, &rng)) {
    model.points.push_back(
        {sample.surface.point, sample.surface.normal,
         PatchColor(model.mesh, sample, static_cast<float>(0.01 * model.diameter), &rng)});
    model.center_M += sample.surface.point.cast<double>() / kPoints;
  }
  for (int i = kPoints - 1; i > 0; --i) {
    std::swap(model.points[static_cast<std::size_t>(i)],
              model.points[static_cast<std::size_t>(rng.Index(i + 1))]);
  }
  model.symmetry = FindSymmetry(model.mesh);
  try {
    Declare(object.symmetries, model.mesh, &model.symmetry);
  } catch (const InvalidArgument& e) {
    Throw<InvalidArgument>("model '{}': {}", object.name, e.what());
  }
  model.hull = HullPoints(model.mesh.vertices, SphereDirections(400));
  model.resting_M = RestingDirections(model.hull, model.center_M, model.symmetry);
  model.ppf = TrainPpf(outward, kPpfSampling);
  return model;
}

std::vector<RecognitionModel> TrainModels(const world::ObjectDatabase& database) {
  std::vector<RecognitionModel> models(database.models().size());
  std::vector<std::string> not_kept(models.size());
  ParallelFor(static_cast<int>(models.size()), [&](int i) {
    const auto index = static_cast<std::size_t>(i);
    models[index] = LoadOrTrain(database.models()[index], &not_kept[index]);
  });
  const auto first = std::find_if(not_kept.begin(), not_kept.end(),
                                  [](const std::string& reason) { return !reason.empty(); });
  if (first != not_kept.end()) {
    spdlog::warn("{}; what is trained is not kept, and is made anew each time", *first);
  }
  return models;
}

const RecognitionModel* FindModel(const std::vector<RecognitionModel>& models,
                                  const std::string& name) {
  const auto found = std::find_if(models.begin(), models.end(), [&](const RecognitionModel& model) {
    return model.name == name;
  });
  return found == models.end() ? nullptr : &*found;
}

Eigen::AlignedBox3d BoxOf(const RecognitionModel& model, const Pose& X_AM) {
  Eigen::AlignedBox3d box_A;
  for (const Eigen::Vector3f& p_M : model.hull) box_A.extend(X_AM * p_M.cast<double>());
  return box_A;
}

double LowestHeight(const RecognitionModel& model, const Pose& X_CM,
                    const world::SupportPlane& plane_C) {
  const Eigen::Vector3f up_M = (X_CM.linear().transpose() * plane_C.normal_A).cast<float>();
  float lowest = std::numeric_limits<float>::max();
  for (const Eigen::Vector3f& v : model.hull) lowest = std::min(lowest, up_M.dot(v));
  return lowest + plane_C.HeightOf(X_CM.translation());
}

}  // namespace secondlook::perception

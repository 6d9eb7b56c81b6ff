// What it takes to prepare a model for recognition, one thread: the table of its point pairs at two
// samplings, beside the table one would write first (a hash map of vectors), and everything that
// recognition needs, trained or read from its file. First the gate: both tables hold the same pairs
// in every cell; the status is 1 when they don't.
//   train_models [--benchmark_…]        from the root of the repository
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <unordered_map>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "lib/perception/ppf.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/training_file.h"
#include "lib/world/object_database.h"

namespace secondlook::bench {
namespace {

using geometry::OrientedPoint;

constexpr const char* kModels[] = {"tea_pot", "power_drill", "mug"};
constexpr int kAngleBins = 15;
constexpr double kCoplanar_rad = 0.12;

const world::ObjectDatabase& TheDatabase() {
  static const world::ObjectDatabase database = world::ObjectDatabase::Load("sim/models");
  return database;
}

const world::ObjectModel& TheObject(std::int64_t index) {
  return *TheDatabase().Find(kModels[static_cast<std::size_t>(index)]);
}

/// The pairs of a model by the cell of their feature, written down as the paper says it.
class PlainTable {
 public:
  struct Entry {
    int reference;
    double turn;  // [rad]
  };

  PlainTable(const std::vector<OrientedPoint>& points, double spacing, int distance_bins) {
    for (int r = 0; r < std::ssize(points); ++r) {
      for (int i = 0; i < std::ssize(points); ++i) {
        if (i != r) Add(points, r, i, spacing, distance_bins);
      }
    }
  }

  std::size_t CountIn(int cell) const {
    const auto found = cells_.find(cell);
    return found == cells_.end() ? 0 : found->second.size();
  }

 private:
  void Add(const std::vector<OrientedPoint>& points, int r, int i, double spacing, int bins) {
    const OrientedPoint& a = points[static_cast<std::size_t>(r)];
    const OrientedPoint& b = points[static_cast<std::size_t>(i)];
    const Eigen::Vector3f d = b.point - a.point;
    const double first = Angle(a.normal, d);
    const double second = Angle(b.normal, d);
    const double between = Angle(a.normal, b.normal);
    const double quarter = std::numbers::pi / 2;
    if (std::abs(first - quarter) < kCoplanar_rad && std::abs(second - quarter) < kCoplanar_rad &&
        between < kCoplanar_rad) {
      return;
    }
    const auto bin = [](double angle) {
      return std::clamp(static_cast<int>(angle * kAngleBins / std::numbers::pi), 0, kAngleBins - 1);
    };
    const int distance = std::min(static_cast<int>(d.norm() / spacing), bins - 1);
    const int cell =
        ((distance * kAngleBins + bin(first)) * kAngleBins + bin(second)) * kAngleBins +
        bin(between);
    const Eigen::Vector3f p =
        Eigen::Quaternionf::FromTwoVectors(a.normal, Eigen::Vector3f::UnitX()) * d;
    cells_[cell].push_back({r, std::atan2(-p.z(), p.y())});
  }

  static double Angle(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    return std::acos(std::clamp(a.dot(b) / std::max(a.norm() * b.norm(), 1e-12F), -1.0F, 1.0F));
  }

  std::unordered_map<int, std::vector<Entry>> cells_;
};

int DistanceBins(const perception::PpfModel& model) {
  return static_cast<int>((model.first.size() - 1) / (kAngleBins * kAngleBins * kAngleBins));
}

PlainTable MakePlainTable(const perception::PpfModel& model) {
  return {model.points, model.spacing, DistanceBins(model)};
}

/// The share of pairs that both tables have in the same cell; rounding moves a few at the borders.
double Agreement(const perception::PpfModel& model) {
  const PlainTable plain = MakePlainTable(model);
  std::size_t same = 0;
  for (std::size_t cell = 0; cell + 1 < model.first.size(); ++cell) {
    const std::size_t ours = model.first[cell + 1] - model.first[cell];
    same += std::min(ours, plain.CountIn(static_cast<int>(cell)));
  }
  return static_cast<double>(same) / static_cast<double>(model.entries.size());
}

double SamplingOf(const benchmark::State& state) {
  return 1e-3 * static_cast<double>(state.range(1));
}

void TrainTable(benchmark::State& state) {
  const geometry::Mesh& mesh = TheObject(state.range(0)).mesh;
  std::size_t pairs = 0;
  for (auto _ : state) {
    pairs = perception::TrainPpf(mesh, SamplingOf(state)).entries.size();
    benchmark::DoNotOptimize(pairs);
  }
  state.SetLabel(kModels[state.range(0)]);
  state.counters["pairs"] = static_cast<double>(pairs);
}

/// On points that are drawn already.
void TrainPlainTable(benchmark::State& state) {
  const auto model = perception::TrainPpf(TheObject(state.range(0)).mesh, SamplingOf(state));
  for (auto _ : state) benchmark::DoNotOptimize(MakePlainTable(model));
  state.SetLabel(kModels[state.range(0)]);
}

void TrainAll(benchmark::State& state) {
  const world::ObjectModel& object = TheObject(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(perception::TrainModel(object));
  state.SetLabel(kModels[state.range(0)]);
}

void ReadFromFile(benchmark::State& state) {
  const world::ObjectModel& object = TheObject(state.range(0));
  const auto file = std::filesystem::temp_directory_path() / "secondlook_train_models.recognition";
  perception::SaveTraining(perception::TrainModel(object), file);
  for (auto _ : state) benchmark::DoNotOptimize(perception::LoadTraining(object, file));
  state.counters["MB"] = static_cast<double>(std::filesystem::file_size(file)) / 1e6;
  state.SetLabel(kModels[state.range(0)]);
  std::filesystem::remove(file);
}

const std::vector<std::vector<std::int64_t>> kEach{{0, 1, 2}, {50, 25}};
BENCHMARK(TrainTable)->ArgsProduct(kEach)->Unit(benchmark::kMillisecond);
BENCHMARK(TrainPlainTable)->ArgsProduct(kEach)->Unit(benchmark::kMillisecond);
BENCHMARK(TrainAll)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);
BENCHMARK(ReadFromFile)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace secondlook::bench

int main(int argc, char** argv) {
  using secondlook::bench::Agreement;
  for (std::int64_t i = 0; i < 3; ++i) {
    const double share =
        Agreement(secondlook::perception::TrainPpf(secondlook::bench::TheObject(i).mesh, 0.05));
    fmt::print("{}: {:.3f} % of the pairs in the same cell\n", secondlook::bench::kModels[i],
               100.0 * share);
    if (share < 0.999) return EXIT_FAILURE;
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return EXIT_SUCCESS;
}

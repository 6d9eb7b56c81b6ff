// From a cluster to a verified pose with ten models in the database, one thread: the whole chain,
// against OpenCV's PPF3DDetector and its ICP on the top 5 of each of the ten, on the same clouds at
// the same sampling. First the gate: ours must be right (10 mm, 5 degrees up to symmetry) on at
// least as many of the clusters as the peer; the status is 1 when it is not.
//   cluster_to_pose [--benchmark_…]
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <opencv2/core/utility.hpp>

#include "apps/experiments/clutter.h"
#include "apps/experiments/ppf_peer.h"
#include "apps/experiments/random_scene.h"
#include "lib/common/parallel.h"
#include "lib/perception/hypothesise.h"
#include "lib/perception/recognise.h"

namespace secondlook::bench {
namespace {

constexpr const char* kFolder = "sim/models";
constexpr int kClusters = 12;
constexpr int kPeerPoses = 5;
const std::vector<std::string> kNames{"bottle",     "connector",   "mug",      "oat_box",
                                      "oil_filter", "power_drill", "soup_can", "tea_pot",
                                      "valve",      "screwdriver"};

const world::ObjectDatabase& TheDatabase() {
  static const world::ObjectDatabase database = [] {
    const auto all = world::ObjectDatabase::Load(kFolder);
    std::vector<world::ObjectModel> ten;
    for (const std::string& name : kNames) ten.push_back(*all.Find(name));
    return world::ObjectDatabase(std::move(ten));
  }();
  return database;
}

const std::vector<perception::RecognitionModel>& TheModels() {
  static const auto models = perception::TrainModels(TheDatabase());
  return models;
}

const std::vector<apps::PpfPeer>& ThePeers() {
  static const std::vector<apps::PpfPeer> peers(TheModels().begin(), TheModels().end());
  return peers;
}

const std::vector<apps::ClutteredThing>& TheThings() {
  static const std::vector<apps::ClutteredThing> things = [] {
    std::vector<sim::SceneObject> objects;
    for (const sim::SceneObject& object : apps::LoadRepertoire(kFolder, "").known) {
      if (TheDatabase().Find(object.name) != nullptr) objects.push_back(object);
    }
    std::vector<apps::ClutteredThing> drawn;
    for (std::uint64_t seed = 1; drawn.size() < kClusters; ++seed) {
      Rng rng(seed);
      apps::ClutteredThing thing =
          apps::DrawClutteredThing(apps::DrawObjects(objects, 7, &rng), seed);
      if (!thing.cluster.pixels.empty()) drawn.push_back(std::move(thing));
    }
    return drawn;
  }();
  return things;
}

bool Right(const apps::ClutteredThing& thing, const std::string& name, const Pose& X_CM) {
  if (name != thing.name) return false;
  const perception::RecognitionModel* model = perception::FindModel(TheModels(), name);
  const auto error =
      perception::DistanceUpToSymmetry(thing.X_CM, X_CM, model->symmetry, model->center_M, false);
  return error.translation < 0.010 && error.rotation < 5.0 * std::numbers::pi / 180.0;
}

bool OursIsRight(const apps::ClutteredThing& thing) {
  const auto detections = perception::Recognise(thing.view, {thing.cluster}, TheModels(), {});
  const auto& hypotheses = detections.front().hypotheses;
  return !hypotheses.empty() && Right(thing, hypotheses.front().model, hypotheses.front().X_CM);
}

/// Chooses by the residual of its ICP.
bool PeerIsRight(const apps::ClutteredThing& thing) {
  const auto cloud_C = perception::OrientCluster(thing.view, 0, thing.cluster);
  double least = INFINITY;
  bool right = false;
  for (std::size_t m = 0; m < TheModels().size(); ++m) {
    for (const apps::PeerPose& pose : ThePeers()[m].Match(cloud_C, kPeerPoses)) {
      if (pose.residual >= least) continue;
      least = pose.residual;
      right = Right(thing, TheModels()[m].name, pose.X_CM);
    }
  }
  return right;
}

bool Agree() {
  int ours = 0;
  int peer = 0;
  for (const apps::ClutteredThing& thing : TheThings()) {
    ours += OursIsRight(thing) ? 1 : 0;
    peer += PeerIsRight(thing) ? 1 : 0;
  }
  fmt::print("right of {} clusters, 10 models: ours {}, the peer {}\n", kClusters, ours, peer);
  return ours >= peer;
}

void OursFromClusterToPose(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(OursIsRight(TheThings()[i++ % kClusters]));
}
BENCHMARK(OursFromClusterToPose)->Iterations(3 * kClusters)->Unit(benchmark::kMillisecond);

void PeerFromClusterToPose(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(PeerIsRight(TheThings()[i++ % kClusters]));
}
BENCHMARK(PeerFromClusterToPose)->Iterations(kClusters)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace secondlook::bench

int main(int argc, char** argv) {
  const secondlook::ThreadLimit one(1);
  cv::setNumThreads(1);
  spdlog::set_level(spdlog::level::err);
  benchmark::Initialize(&argc, argv);
  if (!secondlook::bench::Agree()) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

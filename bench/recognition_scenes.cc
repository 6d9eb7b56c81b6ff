// How well single views are recognised: random tables of the project's objects, drawn with the
// simulated camera's errors, each recognised from scratch. Prints recall by visible fraction,
// wrong verifications and processor time.
//   recognition_scenes [scenes] [seed] [features.csv]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "lib/common/pose.h"
#include "lib/common/rng.h"
#include "lib/perception/recognise.h"
#include "lib/perception/segment.h"
#include "lib/world/object_database.h"
#include "sim/noise.h"
#include "sim/renderer.h"

namespace secondlook {
namespace {

using perception::RecognitionModel;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kTableHeight = 0.75;

struct Thing {
  std::string name;
  int model{-1};  // index of the model; -1: not in the database
  int mesh{};
  Pose X_WM{Pose::Identity()};
  double radius{};
};

struct Tally {
  int objects{};
  int right{};
};

struct Totals {
  std::map<int, Tally> by_visibility;  // key: 0 = 10-20 %, 1 = 20-50 %, 2 = over 50 %
  std::map<std::string, Tally> by_name;
  int verified{};
  int wrong{};
  int clusters{};
  double seconds{};
};

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

class Bench {
 public:
  Bench(const std::string& models, const std::string& unfamiliar)
      : database_(world::ObjectDatabase::Load(models)) {
    const double start = CpuSeconds();
    trained_ = perception::TrainModels(database_);
    fmt::print("training: {:.3f} s of processor time a model\n",
               (CpuSeconds() - start) / static_cast<double>(trained_.size()));
    const bool strangers = std::filesystem::exists(unfamiliar);
    if (strangers) strangers_ = world::ObjectDatabase::Load(unfamiliar);
  }

  void Run(std::uint64_t seed, Totals* totals, std::ofstream* features) {
    Rng rng(ForkSeed(seed, "scene"));
    const geometry::CameraModel camera{640, 480, 577.0, 577.0, 319.5, 239.5};
    sim::Lighting lighting;
    lighting.lights.push_back(sim::Light{{rng.Uniform(-1, 1), rng.Uniform(-1, 1), 2.5}});
    sim::Renderer renderer(camera, lighting);
    std::vector<Thing> things = Place(&renderer, &rng);
    const geometry::Mesh table = geometry::MakeBox({1.2, 0.8, 0.03}, {0.62F, 0.47F, 0.32F});
    const geometry::Mesh floor = geometry::MakeBox({6.0, 6.0, 0.02}, {0.5F, 0.5F, 0.5F});
    std::vector<sim::Instance> instances;
    Pose X_WT = Pose::Identity();
    X_WT.translation().z() = kTableHeight - 0.015;
    instances.push_back({renderer.AddMesh(table), X_WT, 1000});
    instances.push_back({renderer.AddMesh(floor), Pose::Identity(), 1001});
    for (std::size_t i = 0; i < things.size(); ++i) {
      instances.push_back({things[i].mesh, things[i].X_WM, static_cast<int>(i) + 1});
    }
    const double azimuth = rng.Uniform(0, 2 * std::numbers::pi);
    const double elevation = rng.Uniform(25, 50) * kDegree;
    const double range = rng.Uniform(0.9, 1.6);
    const Eigen::Vector3d target(rng.Uniform(-0.15, 0.15), rng.Uniform(-0.1, 0.1),
                                 kTableHeight + 0.05);
    const Eigen::Vector3d eye =
        target + range * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                         std::cos(elevation) * std::sin(azimuth),
                                         std::sin(elevation));
    const Pose X_WC = LookAt(eye, target);
    const sim::Render clean = renderer.Draw(X_WC, instances);
    const cv::Mat depth = sim::DepthNoise(clean, camera, {}, {}, &rng);
    const cv::Mat color = sim::ColorNoise(clean, {}, &rng);

    const Eigen::Vector3d up_C = X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
    const perception::SegmentConfig segment_config;
    const auto segmentation =
        perception::Segment(geometry::Deproject(depth, camera), up_C, segment_config);
    if (!segmentation.plane_C) {
      fmt::print("seed {}: {}\n", seed, segmentation.reason);
      return;
    }
    const double segmented = CpuSeconds();
    const perception::View view =
        perception::MakeView(color, depth, camera, *segmentation.plane_C, segmentation.clusters);
    const perception::RecogniseConfig config;
    const auto detections = perception::Recognise(view, segmentation.clusters, trained_, config);
    const auto choices = perception::ChooseHypotheses(detections, config);
    totals->seconds += CpuSeconds() - segmented;
    totals->clusters += static_cast<int>(detections.size());

    Judge(seed, things, clean, renderer, X_WC, detections, choices, totals, features);
  }

 private:
  std::vector<Thing> Place(sim::Renderer* renderer, Rng* rng) {
    std::vector<Thing> things;
    for (int tries = 0; tries < 200 && things.size() < 7; ++tries) {
      Thing thing;
      const bool stranger = !strangers_.models().empty() && rng->Uniform(0, 1) < 0.15;
      const auto& models = stranger ? strangers_.models() : database_.models();
      const int index = rng->Index(static_cast<int>(models.size()));
      const world::ObjectModel& object = models[static_cast<std::size_t>(index)];
      thing.name = object.name;
      thing.model = stranger ? -1 : index;
      const Eigen::AlignedBox3d box = geometry::Bounds(object.mesh);
      thing.radius = 0.5 * box.sizes().head<2>().norm();
      const Eigen::Vector2d at(rng->Uniform(-0.45, 0.45), rng->Uniform(-0.3, 0.3));
      thing.X_WM.linear() = RotationFromRollPitchYaw(0, 0, rng->Uniform(0, 2 * std::numbers::pi));
      thing.X_WM.translation() << at - (thing.X_WM.linear() * box.center()).head<2>(),
          kTableHeight - box.min().z();
      const bool free = std::all_of(things.begin(), things.end(), [&](const Thing& other) {
        const Eigen::Vector2d there = CenterOf(other);
        return other.name != thing.name &&
               (there - at).norm() > 0.75 * (other.radius + thing.radius) + 0.03;
      });
      if (!free) continue;
      thing.mesh = renderer->AddMesh(object.mesh);
      centers_[thing.name] = box.center();
      things.push_back(thing);
    }
    return things;
  }

  Eigen::Vector2d CenterOf(const Thing& thing) const {
    return (thing.X_WM * centers_.at(thing.name)).head<2>();
  }

  void Judge(std::uint64_t seed, const std::vector<Thing>& things, const sim::Render& clean,
             sim::Renderer& renderer, const Pose& X_WC,
             const std::vector<world::Detection>& detections,
             const std::vector<perception::Choice>& choices, Totals* totals,
             std::ofstream* features) {
    // Which thing each cluster shows.
    std::vector<int> thing_of;
    for (const world::Detection& detection : detections) {
      std::map<int, int> votes;
      for (const int pixel : detection.cluster.pixels) {
        ++votes[clean.id.at<std::uint16_t>(pixel / clean.id.cols, pixel % clean.id.cols)];
      }
      int best = 0;
      for (const auto& [id, count] : votes) {
        if (best == 0 || count > votes[best]) best = id;
      }
      thing_of.push_back(best >= 1 && best <= static_cast<int>(things.size()) ? best - 1 : -1);
    }
    const auto error_of = [&](int thing, const world::Hypothesis& h) -> std::string {
      if (thing < 0) return "-";
      const Thing& t = things[static_cast<std::size_t>(thing)];
      if (t.model < 0 || t.name != h.model) return "-";
      const RecognitionModel& model = trained_[static_cast<std::size_t>(t.model)];
      const auto d = perception::DistanceUpToSymmetry(X_WC.inverse() * t.X_WM, h.X_CM,
                                                      model.symmetry, model.center_M, true);
      return fmt::format("{:.1f}mm {:.1f}deg", 1000 * d.translation, d.rotation / kDegree);
    };
    const auto correct = [&](int thing, const world::Hypothesis& h) {
      if (thing < 0) return false;
      const Thing& t = things[static_cast<std::size_t>(thing)];
      if (t.model < 0 || t.name != h.model) return false;
      const RecognitionModel& model = trained_[static_cast<std::size_t>(t.model)];
      const auto d = perception::DistanceUpToSymmetry(X_WC.inverse() * t.X_WM, h.X_CM,
                                                      model.symmetry, model.center_M, true);
      return d.translation < 0.010 && d.rotation < 5 * kDegree;
    };
    std::vector<bool> recognised(things.size(), false);
    for (std::size_t c = 0; c < detections.size(); ++c) {
      const auto& hypotheses = detections[c].hypotheses;
      if (features->is_open()) {
        for (std::size_t k = 0; k < hypotheses.size(); ++k) {
          const auto& v = hypotheses[k].verification;
          *features << fmt::format(
              "{},{},{},{},{},{},{},{},{},{},{},{:.4f},{:.4f},{:.4f},{},{},{}\n", seed, c,
              thing_of[c] < 0 ? "none" : things[thing_of[c]].name, hypotheses[k].model,
              correct(thing_of[c], hypotheses[k]) ? 1 : 0, v.accepted ? 1 : 0, v.rendered,
              v.visible, v.matching, v.see_through, v.cluster, v.quality, v.color_agreement,
              hypotheses[k].score, static_cast<int>(k) == choices[c].hypothesis ? 1 : 0,
              error_of(thing_of[c], hypotheses[k]), v.reason);
        }
      }
      if (choices[c].hypothesis < 0) continue;
      const auto& h = hypotheses[static_cast<std::size_t>(choices[c].hypothesis)];
      ++totals->verified;
      if (correct(thing_of[c], h)) {
        recognised[static_cast<std::size_t>(thing_of[c])] = true;
      } else {
        ++totals->wrong;
        std::string pose;
        if (thing_of[c] >= 0 && things[thing_of[c]].name == h.model) {
          const Thing& t = things[static_cast<std::size_t>(thing_of[c])];
          const RecognitionModel& model = trained_[static_cast<std::size_t>(t.model)];
          const auto d = perception::DistanceUpToSymmetry(X_WC.inverse() * t.X_WM, h.X_CM,
                                                          model.symmetry, model.center_M, true);
          pose = fmt::format(" off by {:.0f} mm {:.0f} deg", 1000 * d.translation,
                             d.rotation / kDegree);
        }
        fmt::print(
            "seed {}: cluster {} of {} verified wrongly as {}{} (score {:.3f}, colour "
            "{:.2f}, q {:.2f}, visible {:.2f}, {} px)\n",
            seed, c, thing_of[c] < 0 ? "nothing" : things[thing_of[c]].name, h.model, pose, h.score,
            h.verification.color_agreement, h.verification.quality, h.verification.visible_fraction,
            h.verification.visible);
      }
    }
    for (std::size_t i = 0; i < things.size(); ++i) {
      if (things[i].model < 0) continue;
      const sim::Render alone =
          renderer.Draw(X_WC, {{things[i].mesh, things[i].X_WM, static_cast<int>(i) + 1}});
      int whole = 0;
      int visible = 0;
      for (int p = 0; p < clean.id.rows * clean.id.cols; ++p) {
        const int y = p / clean.id.cols;
        const int x = p % clean.id.cols;
        whole += alone.id.at<std::uint16_t>(y, x) == i + 1 ? 1 : 0;
        visible += clean.id.at<std::uint16_t>(y, x) == i + 1 ? 1 : 0;
      }
      if (whole == 0 || visible < 0.1 * whole) continue;
      const double fraction = 1.0 * visible / whole;
      const int bin = fraction > 0.5 ? 2 : fraction > 0.2 ? 1 : 0;
      for (Tally* tally : {&totals->by_visibility[bin], &totals->by_name[things[i].name]}) {
        ++tally->objects;
        tally->right += recognised[i] ? 1 : 0;
      }
    }
  }

  world::ObjectDatabase database_;
  world::ObjectDatabase strangers_;
  std::vector<RecognitionModel> trained_;
  std::map<std::string, Eigen::Vector3d> centers_;
};

int Main(int argc, char** argv) {
  const int scenes = argc > 1 ? std::atoi(argv[1]) : 20;
  const int seed = argc > 2 ? std::atoi(argv[2]) : 0;
  std::ofstream features;
  if (argc > 3) features.open(argv[3]);
  Bench bench("sim/models", "sim/unfamiliar");
  Totals totals;
  for (int i = 0; i < scenes; ++i) {
    bench.Run(static_cast<std::uint64_t>(seed + i), &totals, &features);
  }
  const char* const bins[] = {"10-20 %", "20-50 %", "> 50 %"};
  for (const auto& [bin, tally] : totals.by_visibility) {
    fmt::print("visible {:8}: {:4} of {:4} right = {:.1f} %\n", bins[bin], tally.right,
               tally.objects, 100.0 * tally.right / tally.objects);
  }
  for (const auto& [name, tally] : totals.by_name) {
    fmt::print("  {:16} {:3} of {:3}\n", name, tally.right, tally.objects);
  }
  fmt::print("verified {} of them wrong {} = {:.1f} %\n", totals.verified, totals.wrong,
             100.0 * totals.wrong / std::max(1, totals.verified));
  fmt::print("{:.3f} s of processor time a cluster ({} clusters)\n",
             totals.seconds / std::max(1, totals.clusters), totals.clusters);
  return 0;
}

}  // namespace
}  // namespace secondlook

int main(int argc, char** argv) { return secondlook::Main(argc, argv); }

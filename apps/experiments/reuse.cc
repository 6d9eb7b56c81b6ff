// Models that explorations have made, recognised on other tables.

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/exploration_trial.h"
#include "apps/experiments/free_camera.h"
#include "apps/experiments/random_scene.h"
#include "apps/experiments/single_view.h"
#include "lib/common/rng.h"
#include "lib/perception/recognition_model.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

constexpr double kHalf = 0.5;        ///< What shows so much of itself counts.
constexpr double kSamePlace = 0.05;  ///< A hypothesis so near to a thing's middle is of it [m].

/// The scene's thing whose middle is where `hypothesis` of `model` has its own; -1 for none.
int ThingAt(const world::Hypothesis& hypothesis, const perception::RecognitionModel& model,
            const Pose& X_WC, const std::vector<sim::PlacedObject>& things) {
  const Vector3d center_W = X_WC * hypothesis.X_CM * geometry::Bounds(model.mesh).center();
  int nearest = -1;
  double distance = kSamePlace;
  for (int i = 0; i < static_cast<int>(things.size()); ++i) {
    const Vector3d thing_W = things[i].X_WM * geometry::Bounds(things[i].mesh).center();
    if ((thing_W - center_W).norm() >= distance) continue;
    distance = (thing_W - center_W).norm();
    nearest = i;
  }
  return nearest;
}

/// What one view of another table shows of what was modelled.
Json View(FreeCamera* camera, const Pose& X_WC,
          const std::vector<perception::RecognitionModel>& models,
          const std::map<std::string, std::string>& truth_of) {
  const Photo photo = camera->Take(X_WC);
  const std::vector<sim::PlacedObject>& things = camera->world().objects();
  std::vector<std::string> called(things.size());
  int elsewhere = 0;
  for (const world::Hypothesis& hypothesis : Chosen(Detect(photo, camera->info().model, models))) {
    const perception::RecognitionModel& model = *perception::FindModel(models, hypothesis.model);
    const int thing = ThingAt(hypothesis, model, photo.X_WC, things);
    const auto truth = truth_of.find(hypothesis.model);
    if (thing >= 0) {
      called[thing] = truth == truth_of.end() ? hypothesis.model : truth->second;
    } else {
      ++elsewhere;
    }
  }
  const std::vector<double> visible = camera->VisibleShares(photo);
  Json json{{"elsewhere", elsewhere}, {"things", Json::array()}};
  for (std::size_t i = 0; i < things.size(); ++i) {
    const bool made = std::any_of(truth_of.begin(), truth_of.end(), [&](const auto& model) {
      return model.second == things[i].name;
    });
    json["things"].push_back({{"truth", things[i].name},
                              {"made", made},
                              {"visible", visible[i]},
                              {"called", called[i]}});
  }
  return json;
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  int half_visible = 0;
  int right = 0;
  int named = 0;
  int confused = 0;
  for (const Json& trial : trials) {
    for (const Json& view : trial.at("views")) {
      for (const Json& thing : view.at("things")) {
        const bool called = thing.at("called") != "";
        const bool truly = thing.at("called") == thing.at("truth");
        if (called) ++named;
        if (called && !truly) ++confused;
        if (!thing.at("made").get<bool>() || thing.at("visible") < kHalf) continue;
        ++half_visible;
        if (truly) ++right;
      }
    }
  }
  return {{"models made, recognised where half visible", Proportion(right, half_visible)},
          {"things taken for others, of all recognised", Proportion(confused, named)}};
}

}  // namespace

void RunReuseExperiment(const ExperimentOptions& options) {
  spdlog::set_level(spdlog::level::err);
  RunTrials(
      "reuse", options,
      [&](int t) {
        const HalfKnownTable table = DrawHalfKnownTable(options, t);
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("reuse {}", t));
        const Explored explored = Explore(table, "new surface", seed);
        world::ObjectDatabase database = table.database;
        std::map<std::string, std::string> truth_of;
        for (const MadeModel& made : explored.models) {
          database.Add(made.model);
          truth_of[made.model.name] = made.truth;
        }
        const std::vector<perception::RecognitionModel> models = perception::TrainModels(database);
        Json result{{"exploration", explored.result}, {"views", Json::array()}};
        Rng rng(ForkSeed(seed, "views"));
        for (int v = 0; v < options.views; ++v) {
          const sim::Scene scene = DrawCrowdedTable(table.scene.objects, &rng);
          FreeCamera camera(scene, ForkSeed(seed, fmt::format("view {}", v)));
          result["views"].push_back(View(&camera, DrawView(scene.table, &rng), models, truth_of));
        }
        return result;
      },
      Summarise);
}

}  // namespace secondlook::apps

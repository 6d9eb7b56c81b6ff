#include "apps/experiments/experiment.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <string>

#include "apps/commands/commands.h"
#include "lib/common/error.h"

namespace secondlook::apps {
namespace {

struct Experiment {
  const char* name;
  void (*run)(const ExperimentOptions&);
  int trials;  // unless told
  int views;   // of each, likewise; 0: not asked for
};

constexpr Experiment kExperiments[] = {
    {"missions", RunMissionsExperiment, 50, 0},
    {"ppf-peers", RunPpfPeersExperiment, 100, 0},
    {"recognition", RunRecognitionExperiment, 10, 48},
    {"real-frames", RunRealFramesExperiment, 1000000, 0},  // all that there are
    {"nbv-dataset", RunNbvDatasetExperiment, 1000000, 0},  // likewise
    {"ds-fusion", RunDsFusionExperiment, 65, 0},
    {"pose-averaging", RunPoseAveragingExperiment, 3, 20},
    {"segmentation", RunSegmentationExperiment, 0, 0},  // 50 views, or all clouds that there are
    {"unobstructed", RunUnobstructedExperiment, 200, 0},
    {"confirmation", RunConfirmationExperiment, 200, 0},
    {"occlusion", RunOcclusionExperiment, 200, 0},
    {"ambiguity", RunAmbiguityExperiment, 200, 0},
    {"rejection", RunRejectionExperiment, 200, 0},
    {"reachability", RunReachabilityExperiment, 1000, 0},
    {"moving-obstacles", RunMovingObstaclesExperiment, 200, 0},
    {"recognised-objects", RunRecognisedObjectsExperiment, 200, 0},
    {"search", RunSearchExperiment, 200, 0},
    {"one-budget", RunOneBudgetExperiment, 100, 0},
    {"sensors", RunSensorsExperiment, 25, 0},
    {"modelling", RunModellingExperiment, 50, 0},
    {"exploration", RunExplorationExperiment, 100, 0},
    {"reuse", RunReuseExperiment, 20, 12},
    {"faults", RunFaultsExperiment, 300, 0},
};

/// The names of all, in words.
std::string Names() {
  std::string names;
  for (const Experiment& e : kExperiments)
    names += (names.empty() ? "" : ", ") + std::string(e.name);
  return names;
}

struct Options {
  std::string name;
  int trials{};  // 0: as many as the experiment usually has
  int views{};
  std::string shard = "1/1";
  ExperimentOptions experiment;
};

void Run(Options options) {
  ExperimentOptions& experiment = options.experiment;
  char rest = 0;
  if (std::sscanf(options.shard.c_str(), "%d/%d%c", &experiment.shard, &experiment.shards, &rest) !=
          2 ||
      experiment.shard < 1 || experiment.shard > experiment.shards) {
    Throw<InvalidArgument>("--shard {}: must be i/n with 1 <= i <= n, e.g. 1/4", options.shard);
  }
  const auto* const known =
      std::find_if(std::begin(kExperiments), std::end(kExperiments),
                   [&](const Experiment& e) { return options.name == e.name; });
  if (known == std::end(kExperiments)) {
    Throw<InvalidArgument>("there is no experiment '{}'; known: {}", options.name, Names());
  }
  experiment.trials = options.trials > 0 ? options.trials : known->trials;
  experiment.views = options.views > 0 ? options.views : known->views;
  try {
    known->run(experiment);
  } catch (const nlohmann::json::exception& error) {
    Throw<ConfigError>("{}: its trials cannot be read, so they cannot be resumed: {}",
                       experiment.json, error.what());
  }
}

}  // namespace

void AddExperiment(CLI::App* app, int*) {
  CLI::App* command = app->add_subcommand("experiment", "Measures: " + Names());
  const auto options = std::make_shared<Options>();  // outlives this function in the callback
  ExperimentOptions& experiment = options->experiment;
  experiment.models = "sim/models";
  experiment.unfamiliar = "sim/unfamiliar";
  command->add_option("name", options->name, "Which experiment")->required();
  command->add_option("--trials", options->trials, "How many")->check(CLI::Range(1, 1000000));
  command->add_option("--views", options->views, "Views of each, where it takes views of a scene")
      ->check(CLI::Range(1, 10000));
  command->add_option("--seed", experiment.seed, "Of everything that is drawn");
  command->add_option("--shard", options->shard, "i/n: only every n-th trial, from the i-th");
  command->add_flag("--resume", experiment.resume, "Go on where the --json file ends");
  command->add_option("--scene", experiment.scene, "Scene file, instead of random scenes");
  command->add_option("--models", experiment.models, "Folder of the known objects");
  command->add_option("--unfamiliar", experiment.unfamiliar, "Folder of the unknown objects");
  command->add_option("--data", experiment.data, "Folder of recorded data");
  command->add_option("--classifier", experiment.classifier, "Model file of a classifier");
  command->add_flag("--mirror", experiment.mirror, "Recorded sets are mirrored by chance");
  command->add_option("--report", experiment.report, "Folder for each trial's scene and result");
  command->add_option("--json", experiment.json, "Result as JSON; - is standard output");
  command->add_option("--threads", experiment.threads, "Trials side by side")
      ->check(CLI::Range(1, 256));
  command->callback([options] { Run(*options); });
}

}  // namespace secondlook::apps

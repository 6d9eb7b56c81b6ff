#include "apps/experiments/experiment.h"

#include <cstdio>
#include <memory>
#include <string>

#include "apps/commands/commands.h"
#include "lib/common/error.h"

namespace secondlook::apps {
namespace {

struct Options {
  std::string name;
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
  try {
    if (options.name == "missions") {
      RunMissionsExperiment(experiment);
    } else if (options.name == "real-frames") {
      RunRealFramesExperiment(experiment);
    } else {
      Throw<InvalidArgument>("there is no experiment '{}'; known: missions, real-frames",
                             options.name);
    }
  } catch (const nlohmann::json::exception& error) {
    Throw<ConfigError>("{}: its trials cannot be read, so they cannot be resumed: {}",
                       experiment.json, error.what());
  }
}

}  // namespace

void AddExperiment(CLI::App* app, int*) {
  CLI::App* command = app->add_subcommand("experiment", "Measures: missions, real-frames");
  const auto options = std::make_shared<Options>();  // outlives this function in the callback
  ExperimentOptions& experiment = options->experiment;
  experiment.models = "sim/models";
  experiment.unfamiliar = "sim/unfamiliar";
  command->add_option("name", options->name, "Which experiment")->required();
  command->add_option("--trials", experiment.trials, "How many")->check(CLI::Range(1, 1000000));
  command->add_option("--seed", experiment.seed, "Of everything that is drawn");
  command->add_option("--shard", options->shard, "i/n: only every n-th trial, from the i-th");
  command->add_flag("--resume", experiment.resume, "Go on where the --json file ends");
  command->add_option("--scene", experiment.scene, "Scene file, instead of random scenes");
  command->add_option("--models", experiment.models, "Folder of the known objects");
  command->add_option("--unfamiliar", experiment.unfamiliar, "Folder of the unknown objects");
  command->add_option("--data", experiment.data, "Folder of recorded data");
  command->add_option("--report", experiment.report, "Folder for each trial's scene and result");
  command->add_option("--json", experiment.json, "Result as JSON; - is standard output");
  command->add_option("--threads", experiment.threads, "Trials side by side")
      ->check(CLI::Range(1, 256));
  command->callback([options] { Run(*options); });
}

}  // namespace secondlook::apps

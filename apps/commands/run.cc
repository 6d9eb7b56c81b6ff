#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/appearance.h"
#include "apps/commands/commands.h"
#include "apps/commands/mission_status.h"
#include "apps/device_health.h"
#include "apps/executive.h"
#include "apps/make_robot.h"
#include "apps/mission.h"
#include "apps/mission_log.h"
#include "apps/mission_message.h"
#include "apps/model_watch.h"
#include "apps/publisher.h"
#include "apps/report.h"
#include "apps/run_config.h"
#include "apps/stop_signal.h"
#include "apps/story.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/parallel.h"
#include "lib/hal/guard.h"
#include "lib/hal/tap.h"
#include "lib/transport/lcm_bus.h"
#include "lib/transport/outbox.h"
#include "lib/world/object_database.h"

namespace secondlook::apps {
namespace {

struct RunOptions {
  std::string config;
  std::vector<std::string> overrides;
  std::string report;
  std::string log;
  double log_split_mb{1000.0};
  std::string lcm_url{transport::kDefaultLcmUrl};
  bool plan_only{};
  bool remote_tasks{};
};

double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void PrintPlan(const std::optional<TakenLook>& plan) {
  if (!plan) {
    fmt::print("\nno look is needed or possible\n");
    return;
  }
  fmt::print("\nnext look: {} for object {}: {}\n", plan->look.kind, plan->look.target,
             plan->look.reason);
}

/// The bus; null for "none".
std::unique_ptr<transport::LcmBus> OpenBus(const std::string& url, bool remote_tasks) {
  if (transport::ReachesBeyondThisHost(url)) {
    spdlog::warn("{} reaches beyond this host: everybody there can see this mission, stop it{}",
                 url, remote_tasks ? " and give it tasks" : "; --remote-tasks takes tasks, too");
  }
  return url == "none" ? nullptr : std::make_unique<transport::LcmBus>(url);
}

/// @throws ConfigError when `safety` rests on what others say over LCM, and nobody can.
void RequireCommander(const SafetyConfig& safety, const RunOptions& options,
                      const transport::LcmBus* bus) {
  if (!safety.NeedsCommander()) return;
  if (bus == nullptr || !bus->unreachable().empty()) {
    Throw<ConfigError>(
        "safety.heartbeat_seconds, safety.confirm and safety.wait_after_stop need LCM, which "
        "nobody can speak to this mission by: {}",
        bus == nullptr ? "--lcm-url is none" : bus->unreachable());
  }
  if (safety.wait_after_stop && !options.log.empty()) {
    Throw<ConfigError>(
        "a mission that goes on after a stop cannot be recorded: leave out --log, or set "
        "safety.wait_after_stop to false");
  }
}

/// Gives the mission the task that has come in, if one has. A wrong one changes nothing. `log` may
/// be null.
void PassOnTask(Executive* executive, MissionLog* log, Mission* mission) {
  const std::optional<world::Task> task = executive->TakeTask();
  if (!task) return;
  try {
    mission->SetTask(*task);
    if (log != nullptr) log->Task(*task);
    spdlog::info("the task is another one from here on");
  } catch (const ConfigError& error) {
    executive->RejectTask(error.what());
  }
}

/// Gives the mission the models that have been added to its database. `log` may be null.
void PassOnModels(ModelWatch* watch, MissionLog* log, world::ObjectDatabase* database,
                  Mission* mission) {
  for (world::ObjectModel& model : watch->Take()) {
    mission->Learn(model);
    if (log != nullptr) log->NewModel(model);
    spdlog::info("model '{}' is known from here on", model.name);
    database->Add(std::move(model));
  }
}

/// Adds a model that the mission has made to `database` and, unless it is "", to `folder`. Returns
/// why it could not be stored there.
std::string Keep(const world::ScannedModel& model, const std::string& folder,
                 world::ObjectDatabase* database) try {
  database->Add(AsModel(model));
  if (!folder.empty()) world::StoreModel(model, folder);
  return "";
} catch (const ConfigError& error) {
  return error.what();
}

int Run(const RunOptions& options) {
  CatchStopSignals();
  const RunConfig config = LoadRunConfig(options.config, options.overrides);
  if (!options.report.empty()) MakeWritableFolder(options.report);
  const std::unique_ptr<transport::LcmBus> bus = OpenBus(options.lcm_url, options.remote_tasks);
  RequireCommander(config.safety, options, bus.get());
  transport::Outbox outbox(Executive::kOutboxBytes);
  std::vector<transport::Sink*> sinks;
  if (bus && bus->unreachable().empty()) sinks.push_back(&outbox);
  Story story;
  if (!options.report.empty()) sinks.push_back(&story);
  const ThreadLimit threads(config.threads);
  auto database = LoadDatabase(config);
  ModelWatch watch(config.models, database);
  RequireKnownClasses(config.task, database);
  const auto classifier = LoadMissionClassifier(config.classifier, database);
  std::optional<MissionLog> log;
  if (!options.log.empty()) log.emplace(options.log, options.log_split_mb);
  hal::Guard guard(config.safety.limits);
  ReadyRobot ready = MakeRobot(config.robot, config.seed);
  ready.robot = guard.Protect(std::move(ready.robot), BoxOfArm(ready));
  if (log) {
    log->Begin(config, database, options.plan_only, &ready);
    sinks.push_back(&*log);
  }
  DeviceHealth health(ready.robot);
  hal::Robot robot = hal::Tap(std::move(ready.robot), &health);
  Publisher publisher(sinks);
  Executive executive({bus.get(), &outbox, &robot, &publisher, &health,
                       [&] { return log ? log->state() : ""; },
                       options.remote_tasks || !transport::ReachesBeyondThisHost(options.lcm_url),
                       &guard, config.safety});
  StopRequest stop = [&] { return executive.StopRequested(); };
  if (log) stop = log->Recorded(std::move(stop), StopSignal);
  Mission mission(config.mission, config.task, database, ready.calibration, config.seed, stop,
                  &publisher, &robot);
  if (ready.hand) mission.KnowArm(*ready.hand);
  mission.KeepWithin(config.safety.limits);
  if (config.safety.confirm) {
    mission.LetConfirm([&](const world::Look&) { executive.WaitForConfirmation(); });
  }
  if (classifier) mission.KnowClassifier(*classifier);
  mission.LetKeep(
      [&](const world::ScannedModel& model) { return Keep(model, config.learned, &database); });
  const second_look::mission_t start = DescribeStart(config, database, robot.clock->Now());
  publisher.Mission(start);
  Progress progress = Progress::kMore;
  const auto finish = [&] {
    publisher.Mission(DescribeEnd(start, mission.record(), progress, robot.clock->Now()));
    PrintSummary(mission, ProcessorSeconds());
    if (log) fmt::print("{}\n", log->Close());
    if (options.report.empty()) return;
    WriteReport(config, mission, story, options.report);
    fmt::print("the result lies in {}\n", options.report);
  };
  try {
    if (options.plan_only) {
      PrintPlan(mission.Plan());
      progress = stop() ? Progress::kStopped : Progress::kSettled;
    } else {
      while (progress == Progress::kMore) {
        PassOnModels(&watch, log ? &*log : nullptr, &database, &mission);
        PassOnTask(&executive, log ? &*log : nullptr, &mission);
        progress = mission.Step();
        if (progress != Progress::kStopped || !config.safety.wait_after_stop) continue;
        if (!executive.WaitUntilCleared()) continue;
        mission.Resume();
        progress = Progress::kMore;
      }
    }
  } catch (const Error&) {
    robot.Stop();
    progress = Progress::kFailed;
    finish();  // what was learned until then is not lost
    throw;
  } catch (...) {  // a fault of ours: nothing that it has touched is to be relied on
    robot.Stop();
    throw;
  }
  finish();
  return StatusOf(progress, StopSignal());
}

}  // namespace

void AddRun(CLI::App* app, int* status) {
  CLI::App* run = app->add_subcommand("run", "Runs a mission");
  const auto options = std::make_shared<RunOptions>();  // outlives this function in the callback
  run->add_option("--config", options->config, "Configuration, YAML")->required();
  run->add_option("--set", options->overrides, "KEY=VALUE, over the configuration; may be repeated")
      ->expected(1)
      ->take_all();
  run->add_option("--report", options->report,
                  "Folder for report.html, mission.json, config and pictures");
  run->add_option("--log", options->log, "File to record the mission in, for replay");
  run->add_option("--log-split-mb", options->log_split_mb, "Begin FILE.01, … at so many MB")
      ->capture_default_str();
  run->add_option("--lcm-url", options->lcm_url, "LCM network to speak on; 'none' for none")
      ->capture_default_str();
  run->add_flag("--remote-tasks", options->remote_tasks,
                "Take tasks from beyond this host, when --lcm-url reaches there");
  run->add_flag("--plan-only", options->plan_only, "Look once, say what would be done, don't move");
  run->callback([options, status] { *status = Run(*options); });
}

}  // namespace secondlook::apps

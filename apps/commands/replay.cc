#include <cstdint>
#include <ctime>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/appearance.h"
#include "apps/commands/commands.h"
#include "apps/commands/mission_status.h"
#include "apps/decision_check.h"
#include "apps/follow.h"
#include "apps/mission.h"
#include "apps/mission_log.h"
#include "apps/mission_message.h"
#include "apps/publisher.h"
#include "apps/report.h"
#include "apps/run_config.h"
#include "apps/stop_signal.h"
#include "apps/story.h"
#include "apps/to_message.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/hash.h"
#include "lib/common/parallel.h"
#include "lib/common/version.h"
#include "lib/hal/replay/playback.h"
#include "lib/hal/replay/recording.h"
#include "lib/transport/channels.h"
#include "lib/world/object_database.h"

namespace secondlook::apps {
namespace {

struct ReplayOptions {
  std::string log;
  std::string report;
  bool follow{};
};

/// Lets the playback go on to the next segment when the mission sets out for a look.
class Advance : public transport::Sink {
 public:
  explicit Advance(hal::Playback* playback) : playback_(playback) {}
  void Post(const transport::Message& message) override {
    if (message.channel == transport::channel::kLook) playback_->NextLook();
  }

 private:
  hal::Playback* playback_;
};

/// The models that the recorded mission got on its way, with their hashes.
std::map<std::string, std::uint64_t> NewModels(const hal::Recording& recording) {
  std::map<std::string, std::uint64_t> models;
  for (const hal::Segment& segment : recording.segments) {
    for (const second_look::rec_model_t& model : segment.models) {
      models[model.name] = static_cast<std::uint64_t>(model.hash);
    }
  }
  return models;
}

/// The models that lie on disk now, without those that missions have made since the recording: they
/// are made anew, in the same way.
world::ObjectDatabase OnDisk(const hal::Recording& recording, const RunConfig& config) {
  std::set<std::string> recorded;
  for (const second_look::rec_model_t& model : recording.start.models) recorded.insert(model.name);
  const auto given = world::ObjectDatabase::Load(config.models);
  const world::ObjectDatabase all = LoadDatabase(config);
  std::vector<world::ObjectModel> models;
  for (const world::ObjectModel& model : all.models()) {
    if (given.Find(model.name) != nullptr || recorded.contains(model.name)) models.push_back(model);
  }
  return world::ObjectDatabase(std::move(models));
}

/// What the recorded mission began with, of what lies on disk now.
world::ObjectDatabase AtTheStart(const hal::Recording& recording,
                                 const world::ObjectDatabase& on_disk) {
  const std::map<std::string, std::uint64_t> later = NewModels(recording);
  std::vector<world::ObjectModel> models;
  for (const world::ObjectModel& model : on_disk.models()) {
    if (!later.contains(model.name)) models.push_back(model);
  }
  return world::ObjectDatabase(std::move(models));
}

/// Says beforehand what may make this mission decide otherwise than the recorded one.
void WarnOfWhatDiffers(const hal::Recording& recording, const world::ObjectDatabase& database) {
  for (const std::string& warning : recording.warnings) spdlog::warn("{}", warning);
  if (recording.start.version != kVersion) {
    spdlog::warn("recorded by version {}, replayed by version {}: it may decide otherwise",
                 recording.start.version, kVersion);
  }
  std::map<std::string, std::uint64_t> recorded = NewModels(recording);
  for (const second_look::rec_model_t& model : recording.start.models) {
    recorded[model.name] = static_cast<std::uint64_t>(model.hash);
  }
  for (const world::ObjectModel& model : database.models()) {
    const auto found = recorded.find(model.name);
    if (found == recorded.end()) {
      spdlog::warn("model '{}' was not in the recorded mission's database", model.name);
      continue;
    }
    if (found->second != model.hash) {
      spdlog::warn("model '{}' has changed since the recording: its hash was {} and is {}",
                   model.name, HexDigits(found->second), HexDigits(model.hash));
    }
    recorded.erase(found);
  }
  for (const auto& [name, hash] : recorded) {
    spdlog::warn("model '{}' of the recorded mission is no longer in the database", name);
  }
}

/// A mission that is fed from a recording, and how it compares with the recorded one.
class Replayed {
 public:
  /// `on_disk` is the whole database; the mission begins with what the recorded one began with.
  Replayed(const hal::Recording& recording, const RunConfig& config,
           const world::ObjectDatabase& on_disk, bool follow)
      : recording_(recording),
        on_disk_(on_disk),
        database_(AtTheStart(recording, on_disk)),
        classifier_(LoadMissionClassifier(config.classifier, database_)),
        check_(recording),
        playback_(recording),
        advance_(&playback_),
        robot_(playback_.MakeRobot()),
        publisher_({&check_, &advance_, &story_}),
        mission_(
            config.mission, config.task, database_, recording.robot.calibration, config.seed,
            [this, follow] { return StopAsked(follow); }, &publisher_, &robot_),
        start_(DescribeStart(config, database_, robot_.clock->Now())) {
    if (recording.robot.arm) mission_.KnowArm(recording.robot.arm->hand);
    mission_.KeepWithin(config.safety.limits);
    if (classifier_) mission_.KnowClassifier(*classifier_);
    mission_.LetKeep([this](const world::ScannedModel& model) {
      database_.Add(AsModel(model));
      return "";
    });
    if (follow) mission_.LetChoose(FollowLooks(recording, &check_));
  }

  /// Runs to the end of the mission, of the recording, or to the first difference that counts.
  /// @throws what the recorded devices threw.
  void Run() {
    try {
      publisher_.Mission(start_);
      if (recording_.start.plan_only != 0) {
        mission_.Plan();
        progress_ = playback_.AskStop() ? Progress::kStopped : Progress::kSettled;
      }
      while (progress_ == Progress::kMore) Step();
    } catch (const hal::EndOfRecording& end) {
      spdlog::warn("{}", end.what());
      cut_short_ = true;
    } catch (const DeviceError&) {
      progress_ = Progress::kFailed;
      TellEnd();
      throw;
    }
    if (!cut_short_) TellEnd();
  }

  const Mission& mission() const { return mission_; }
  const DecisionCheck& check() const { return check_; }
  const Story& story() const { return story_; }

  /// The exit status of a mission that went this way.
  int Status() const {
    if (!check_.differences().empty()) return kOtherDecision;
    if (cut_short_) return kUnsettled;
    return StatusOf(progress_, StopSignal() != 0 ? StopSignal() : playback_.stop_signal());
  }

 private:
  bool StopAsked(bool follow) {
    const bool decided_otherwise = !follow && !check_.differences().empty();
    return StopSignal() != 0 || decided_otherwise || playback_.AskStop();
  }

  void Step() {
    for (const second_look::rec_model_t& model : playback_.models()) Learn(model.name);
    for (const second_look::task_t& task : playback_.tasks()) mission_.SetTask(FromMessage(task));
    progress_ = mission_.Step();
  }

  /// As the recorded mission learned it, when the folder holds it still.
  void Learn(const std::string& name) {
    const world::ObjectModel* model = on_disk_.Find(name);
    if (model == nullptr || database_.Find(name) != nullptr) return;
    mission_.Learn(*model);
    database_.Add(*model);
  }

  void TellEnd() {
    publisher_.Mission(DescribeEnd(start_, mission_.record(), progress_, robot_.clock->Now()));
  }

  const hal::Recording& recording_;
  const world::ObjectDatabase& on_disk_;
  world::ObjectDatabase database_;                      // what the mission knows
  std::unique_ptr<perception::Classifier> classifier_;  // null: none
  DecisionCheck check_;
  hal::Playback playback_;
  Advance advance_;
  hal::Robot robot_;
  Story story_;
  Publisher publisher_;
  Mission mission_;
  second_look::mission_t start_;
  Progress progress_{Progress::kMore};
  bool cut_short_{};
};

void PrintVerdict(const DecisionCheck& check, bool follow) {
  const std::vector<Difference>& differences = check.differences();
  if (differences.empty()) {
    fmt::print("the same decisions as in the recording: {} messages compared\n", check.compared());
    return;
  }
  spdlog::error("another decision than in the recording: {}", ToText(differences.front()));
  if (!follow) return;
  fmt::print("\n{} differences from the recording:\n", differences.size());
  for (const Difference& difference : differences) fmt::print("{}\n", ToText(difference));
}

int Replay(const ReplayOptions& options) {
  CatchStopSignals();
  const hal::Recording recording = hal::Recording::Load(options.log);
  const RunConfig config =
      ParseRunConfig(recording.start.config, options.log + " (its configuration)");
  if (!options.report.empty()) MakeWritableFolder(options.report);
  const ThreadLimit threads(config.threads);
  const world::ObjectDatabase database = OnDisk(recording, config);
  RequireKnownClasses(config.task, database);
  WarnOfWhatDiffers(recording, database);
  Replayed replayed(recording, config, database, options.follow);
  const auto finish = [&] {
    PrintSummary(replayed.mission(), static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
    PrintVerdict(replayed.check(), options.follow);
    if (options.report.empty()) return;
    WriteReport(config, replayed.mission(), replayed.story(), options.report);
    fmt::print("the result lies in {}\n", options.report);
  };
  try {
    replayed.Run();
  } catch (const DeviceError&) {
    finish();
    if (!replayed.check().differences().empty()) return kOtherDecision;
    throw;
  } catch (
      const ProtocolError&) {  // what is damaged is the recording, so it says nothing of decisions
    finish();
    throw;
  }
  finish();
  return replayed.Status();
}

}  // namespace

void AddReplay(CLI::App* app, int* status) {
  CLI::App* replay =
      app->add_subcommand("replay", "Runs a recorded mission again and compares its decisions");
  const auto options = std::make_shared<ReplayOptions>();  // outlives this function in the callback
  replay->add_option("--log", options->log, "Recording, as run --log leaves it")->required();
  replay->add_option("--report", options->report,
                     "Folder for report.html, mission.json, config and pictures");
  replay->add_flag("--follow", options->follow,
                   "Go on along the recorded looks where the mission would take others");
  replay->callback([options, status] { *status = Replay(*options); });
}

}  // namespace secondlook::apps

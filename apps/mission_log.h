#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "apps/drive.h"
#include "apps/make_robot.h"
#include "apps/run_config.h"
#include "lib/hal/replay/recorder.h"
#include "lib/transport/log_sink.h"
#include "lib/world/object_database.h"

namespace secondlook::apps {

/// The recording of a mission (docs/recording.md): all that comes in at the devices, and beside it
/// what the mission tells, when this is one of its publisher's sinks.
/// Threading: Post(), state() and Close() from any thread, the rest from the mission's.
class MissionLog : public transport::Sink {
 public:
  /// Begins the log `file`, in parts of at most `part_mb` [MB].
  /// @throws ConfigError when it cannot be written, or for parts of less than 1 MB.
  MissionLog(const std::filesystem::path& file, double part_mb);

  /// Records what the mission begins with, and from now on what the devices of `ready` answer.
  /// This must outlive the robot.
  void Begin(const RunConfig& config, const world::ObjectDatabase& database, bool plan_only,
             ReadyRobot* ready);

  /// `stop`, with its first yes recorded. `signal` says which signal has asked for it, or 0.
  StopRequest Recorded(StopRequest stop, std::function<int()> signal);

  /// The mission has got this task.
  void Task(const world::Task& task);
  /// The mission has got this model.
  void NewModel(const world::ObjectModel& model);

  void Post(const transport::Message& message) override { log_.Post(message); }

  /// The file that is being written, or why the recording has ended.
  std::string state() const { return log_.state(); }

  /// Writes what waits, and says where the recording lies and whether it is whole.
  std::string Close();

 private:
  std::filesystem::path file_;
  transport::LogSink log_;
  hal::Recorder recorder_{&log_};
};

/// A model, as a recording names it.
second_look::rec_model_t ToRecorded(const world::ObjectModel& model);

/// The models of `database`, likewise.
std::vector<second_look::rec_model_t> ModelsOf(const world::ObjectDatabase& database);

}  // namespace secondlook::apps

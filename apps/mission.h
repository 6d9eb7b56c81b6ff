#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/capture.h"
#include "apps/drive.h"
#include "apps/exploration.h"
#include "apps/look_planner.h"
#include "apps/mission_config.h"
#include "apps/publisher.h"
#include "apps/scene_understanding.h"
#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "lib/hal/robot.h"
#include "lib/kinematics/head.h"
#include "lib/perception/register_view.h"
#include "lib/world/look.h"
#include "lib/world/object_database.h"
#include "lib/world/scene_belief.h"
#include "lib/world/task.h"
#include "lib/world/voxel_space.h"

namespace secondlook::apps {

/// How a step of the mission ended.
enum class Progress {
  kMore,         ///< Step on.
  kSettled,      ///< Nothing is open.
  kBudgetSpent,  ///< Something is open, but looks, seconds or metres are spent.
  kNoLook,       ///< Something is open, but no look can help.
  kStopped,      ///< Asked to stop; the robot stands still.
  kFailed,       ///< A device is lost.
};

/// One look as it was taken.
struct TakenLook {
  world::Look look;
  std::vector<world::Look> candidates;  ///< All it was chosen from, itself included.
  std::string outcome;                  ///< "reached", or why not.
};

/// What a mission has done so far.
struct MissionRecord {
  std::vector<TakenLook> looks;
  double compute_seconds{};             ///< Robot time charged for thinking.
  double motion_seconds{};              ///< Robot time spent moving.
  double total_seconds{};               ///< Robot time since the start.
  double metres{};                      ///< Driven, by localisation.
  std::string end;                      ///< Why it ended, in words; empty while it runs.
  std::vector<ModelledThing> modelled;  ///< What was, or could not be.
};

/// Is given each model that the mission has made, to keep it. Returns why it could not; empty when
/// it could.
using ModelKeeper = std::function<std::string(const world::ScannedModel& model)>;

/// Has the last word on each look. It is given the mission's own choice, or none and why the
/// mission would end, and returns the look to take, or none to end here.
using LookChooser =
    std::function<std::optional<TakenLook>(std::optional<TakenLook> own, const std::string& end)>;

/// The cycle: grab, observe, match and fuse, ask what is open, choose a look, take it.
/// All its knowledge comes through the robot's devices.
class Mission {
 public:
  /// `database`, `publisher` and `robot` must outlive this. `database` may grow (Learn). `stop` is
  /// asked often, from the mission's thread. What happens is told to `publisher`; it changes
  /// nothing.
  /// @throws ConfigError when `config` holds a value that is not valid.
  Mission(const MissionConfig& config, const world::Task& task,
          const world::ObjectDatabase& database, const kinematics::HeadCalibration& calibration,
          std::uint64_t seed, StopRequest stop, Publisher* publisher, hal::Robot* robot);

  /// One turn of the cycle. Not to be called again once it has returned anything but kMore.
  /// @throws DeviceError when a device is lost, ProtocolError when it answers nonsense. The robot
  /// stands still then, and record() says how the mission ended.
  Progress Step();

  /// The first half of a turn: looks, understands and says which look to take next; nothing moves.
  /// Empty when the mission ends here.
  /// @throws DeviceError when a device is lost.
  std::optional<TakenLook> Plan();

  /// The robot has this arm: what a view shows of it, or of the rest of the robot, is no
  /// measurement, and it takes looks itself when the camera in its hand measures depth. To be
  /// called before the first step, while it is folded.
  /// @throws ConfigError when it is not within the cylinder that the base drives as.
  void KnowArm(const kinematics::EyeInHand& hand);

  /// What each thing looks like is asked of `classifier`, which must outlive this, too. To be
  /// called before the first step.
  void KnowClassifier(const perception::Classifier& classifier) {
    scene_.KnowClassifier(classifier);
    planner_.KnowClassifier(classifier);
  }

  /// What is wanted from the next step on.
  /// @throws ConfigError when `task` is not valid or wants a class that is not in the database.
  void SetTask(const world::Task& task);

  /// Knows `model`, which has been added to the database, from the next frame on. What was called
  /// unknown may be it, so it is open again.
  void Learn(const world::ObjectModel& model);

  /// Goes on after it was stopped: Step() may be called again. The look that was stopped is not
  /// taken again unless it is chosen again. @pre it has ended with kStopped.
  void Resume();

  /// Before each look is taken `confirm` is called, which may wait; when it returns the look is
  /// taken, unless the mission is to stop.
  void LetConfirm(std::function<void(const world::Look& look)> confirm) {
    confirm_ = std::move(confirm);
  }

  /// Base and arm are to stay within their workspaces: looks for which they would leave them are
  /// refused. To be called after KnowArm().
  /// @throws ConfigError when the arm is not within its own.
  void KeepWithin(const hal::GuardConfig& limits) { planner_.KeepWithin(limits); }

  /// Models that it makes are given to `keep`; without, they are known in this mission alone.
  void LetKeep(ModelKeeper keep) { keep_ = std::move(keep); }

  /// Lets `choose` decide on each look from now on.
  void LetChoose(LookChooser choose) { choose_ = std::move(choose); }

  const world::Task& task() const { return task_; }
  const world::SceneBelief& belief() const { return scene_.belief(); }
  const MissionRecord& record() const { return record_; }

 private:
  /// Where the base stands, by a view that was registered there.
  struct Footing {
    Pose X_RegisteredMeasured;  // from where localisation has it
    Eigen::Vector3d p_WC;       // of that view
    perception::PoseCovariance covariance;
  };

  Stance Standing() const;
  const hal::CameraInfo& Eye() const;
  std::optional<Capture> Grab();
  void RequireDepth(const Capture& capture);
  void Understand(Capture capture);
  TakenLook ScoreLooks(const Question& question);
  Question WhatIsOpen() const;
  Question WhatToAsk(bool stuck);
  void Know(ModelledThing thing);
  bool AllWantedFound() const;
  bool Matters(const world::ObjectBelief& object) const;
  bool GoOnWithoutArm(const DeviceError& error);
  std::optional<TakenLook> SearchForTable();
  std::optional<TakenLook> Choose(bool stuck = false);
  std::optional<TakenLook> Overruled(std::optional<TakenLook> own);
  Progress Act(TakenLook look);
  Eigen::Vector2d WhatStopped(const world::Look& look, const DriveOutcome& outcome) const;
  void End(Progress progress, std::string why);
  void Charge(double seconds);
  void TellView(const Capture& capture, const std::string& reason);
  void TellMotion(int phase, const std::string& reason, double metres);
  double SecondsSince(Time start) const;
  std::string BudgetSpent() const;

  MissionConfig config_;
  world::Task task_;
  const world::ObjectDatabase& database_;
  hal::Robot* robot_;
  Publisher* publisher_;
  kinematics::HeadCalibration calibration_;
  StopRequest stop_;
  LookChooser choose_;
  std::function<void(const world::Look&)> confirm_;
  std::uint64_t seed_;
  Rng rng_;
  Capturer capturer_;
  SceneUnderstanding scene_;
  LookPlanner planner_;
  std::optional<Exploration> exploration_;  // empty: what is unknown stays so
  ModelKeeper keep_;
  std::map<int, std::string> told_;            // last logged reason, by object
  world::LookWay eye_{world::LookWay::kHead};  // the camera of the next view
  bool arm_known_{};                           // and not lost
  std::string without_;                        // what it goes on without, and why
  std::optional<Footing> footing_;             // while the base stands there
  int blind_frames_{};                         // without any depth, in a row
  int searched_{};                             // head poses tried in vain
  int explored_{};                             // looks at hidden space that got there
  int vain_{};                                 // … and that did not
  std::vector<StageTime> stages_;              // of this step
  Time start_;
  Progress progress_{Progress::kMore};
  MissionRecord record_;
};

}  // namespace secondlook::apps

#include <algorithm>
#include <array>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/commands/commands.h"
#include "apps/commands/mission_status.h"
#include "apps/executive.h"
#include "apps/experiments/experiment.h"
#include "apps/experiments/mission_trial.h"
#include "apps/experiments/random_scene.h"
#include "apps/make_robot.h"
#include "apps/mission.h"
#include "apps/mission_json.h"
#include "apps/mission_log.h"
#include "lib/common/error.h"
#include "lib/hal/guard.h"
#include "lib/hal/tap.h"
#include "lib/transport/channels.h"
#include "lib/world/object_database.h"
#include "sim/faulty_robot.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;

/// As in RunMissionTrial().
constexpr int kMaxSteps = 100;
/// A mission that is over its budget ends with the look that it is on [s].
constexpr double kLastLook = 120.0;
/// One robot in so many has an arm.
constexpr int kArmEvery = 4;
/// Faults begin in the first so many seconds …
constexpr double kLatestBegin = 60.0;
/// … and half of them end again after so many at most.
constexpr double kLongest = 40.0;
/// So many messages nobody understands come in whenever the mission asks whether to stop.
constexpr int kMessages = 50;

/// What can go wrong around the robot, beside its devices.
enum class Trouble { kNone, kFlood, kWrongFingerprints, kDiskFull, kStop };

constexpr std::array kTroubles{Trouble::kFlood, Trouble::kWrongFingerprints, Trouble::kDiskFull,
                               Trouble::kStop};

const char* ToString(Trouble trouble) {
  switch (trouble) {
    case Trouble::kNone:
      return "none";
    case Trouble::kFlood:
      return "LCM flood";
    case Trouble::kWrongFingerprints:
      return "LCM wrong fingerprints";
    case Trouble::kDiskFull:
      return "disk full";
    case Trouble::kStop:
      return "stop";
  }
  return "";
}

/// All that goes wrong in one mission.
struct Plight {
  bool with_arm{};
  std::vector<sim::Fault> faults;
  std::vector<Trouble> troubles;
  Time stop_at{};  ///< Of the trouble kStop.

  bool Has(Trouble trouble) const {
    return std::find(troubles.begin(), troubles.end(), trouble) != troubles.end();
  }
};

/// One to three faults of all that there are, each as likely as the others.
Plight DrawPlight(Rng* rng) {
  Plight plight;
  plight.with_arm = rng->Index(kArmEvery) == 0;
  const std::vector<sim::Fault> pool = sim::AllFaults(plight.with_arm);
  const int count = 1 + rng->Index(3);
  plight.stop_at = Time(Seconds(rng->Uniform(0.0, kLatestBegin)));
  for (int i = 0; i < count; ++i) {
    const int drawn = rng->Index(static_cast<int>(pool.size() + kTroubles.size()));
    if (drawn >= static_cast<int>(pool.size())) {
      plight.troubles.push_back(kTroubles[static_cast<std::size_t>(drawn) - pool.size()]);
      continue;
    }
    sim::Fault fault = pool[static_cast<std::size_t>(drawn)];
    fault.from = Time(Seconds(rng->Uniform(0.0, kLatestBegin)));
    if (rng->Index(2) == 0) fault.until = fault.from + Seconds(rng->Uniform(1.0, kLongest));
    plight.faults.push_back(fault);
  }
  return plight;
}

/// Counts the motions that reach the devices although nothing may move.
class Witness : public hal::RobotListener {
 public:
  explicit Witness(const hal::Guard* guard) : guard_(guard) {}

  void OnBaseStart(const hal::BasePath& /*path*/) override { Count(); }
  void OnHeadStart(const hal::PanTiltAngles& /*target*/) override { Count(); }
  void OnArmStart(const hal::JointTrajectory& /*trajectory*/) override { Count(); }

  /// The mission has ended: nothing may move from now on.
  void Ended() { ended_ = true; }
  int motions_after_stop() const { return motions_; }

 private:
  void Count() {
    if (ended_ || guard_->holds()) ++motions_;
  }

  const hal::Guard* guard_;
  bool ended_{};
  int motions_{};
};

/// True when the robot truly moves, a while after all was to stand still.
bool StillMoves(sim::World* world) {
  const auto step = [world](Duration time) {
    for (const Time end = world->Now() + time; world->Now() < end;) world->Step();
    return world->StateAt(world->Now());
  };
  const sim::WorldState before = step(Seconds(4.0));
  const sim::WorldState after = step(Seconds(0.5));
  const bool base = std::hypot(after.X_WB.x - before.X_WB.x, after.X_WB.y - before.X_WB.y) > 1e-6;
  const bool head = std::abs(after.head.pan - before.head.pan) > 1e-6 ||
                    std::abs(after.head.tilt - before.head.tilt) > 1e-6;
  const bool arm = before.arm.size() > 0 && (after.arm - before.arm).norm() > 1e-6;
  return base || head || arm;
}

/// Why the end and the report of a mission do not say what was; empty when they do.
std::string Untruth(const Mission& mission, Progress progress, bool stop_requested, bool lost,
                    int status) {
  const std::string& end = mission.record().end;
  if (end.empty()) return "it does not say why it has ended";
  if ((progress == Progress::kFailed) != lost) return "a lost device and its end do not agree";
  if (progress == Progress::kStopped && !stop_requested) return "nobody has stopped it";
  const bool all_settled =
      std::all_of(mission.belief().objects.begin(), mission.belief().objects.end(),
                  [](const world::ObjectBelief& object) { return object.Settled(); });
  if (progress == Progress::kSettled && !all_settled) return "it is settled with objects open";
  const int right = lost ? kDeviceFailed : progress == Progress::kSettled ? kDone : kUnsettled;
  if (status != right) return fmt::format("its status is {} instead of {}", status, right);
  const Json report = Json::parse(ToJson(mission.belief(), mission.record(), 0).dump());
  const auto believed =
      std::count_if(mission.belief().objects.begin(), mission.belief().objects.end(),
                    [](const world::ObjectBelief& object) {
                      return object.state != world::ObjectState::kRejected;
                    });
  if (std::ssize(report.at("objects")) != believed) {
    return "its report has other objects than it believes in";
  }
  return "";
}

/// Messages that nobody understands, on the channels that are listened to.
void Flood(transport::LcmBus* bus, bool wrong_fingerprints, Rng* rng) {
  for (int i = 0; i < kMessages; ++i) {
    std::vector<std::uint8_t> bytes(
        wrong_fingerprints ? 64 : static_cast<std::size_t>(rng->Index(2'000)));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(rng->Bits());
    bus->Publish({i % 2 == 0 ? transport::channel::kTask : transport::channel::kCommand, 0,
                  std::move(bytes)});
  }
}

Json Judged(const Mission& mission, const sim::World& world) {
  Json verdicts = Json::array();
  for (const Verdict& verdict : Judge(mission, world)) verdicts.push_back(ToJson(verdict));
  return verdicts;
}

/// One mission of the default robot, with or without an arm, in this plight, with all that `run`
/// puts around it. It is judged at its end, and where it is at `by_then` [s of robot time].
Json RunInPlight(const sim::Scene& scene, const world::ObjectDatabase& database, std::uint64_t seed,
                 const Plight& plight, double by_then = std::numeric_limits<double>::infinity()) {
  sim::SimConfig sim_config;
  if (plight.with_arm) sim_config.arm.emplace().urdf = "sim/robots/arm.urdf";
  sim::SimulatedRobot simulated = sim::MakeSimulatedRobot(scene, sim_config, seed);
  hal::Guard guard({});
  Witness witness(&guard);
  ReadyRobot ready{std::move(simulated.world), {}, simulated.calibration, simulated.hand};
  ready.robot = guard.Protect(
      hal::Tap(sim::WithFaults(std::move(simulated.robot), plight.faults, seed), &witness));

  transport::LcmBus bus("memq://");
  transport::Outbox outbox(Executive::kOutboxBytes);
  std::vector<transport::Sink*> sinks{&outbox};
  std::optional<MissionLog> log;
  if (plight.Has(Trouble::kDiskFull)) {
    log.emplace("/dev/full", 1.0);
    log->Begin(RunConfig{}, database, false, &ready);
    sinks.push_back(&*log);
  }
  DeviceHealth health(ready.robot);
  hal::Robot robot = hal::Tap(std::move(ready.robot), &health);
  Publisher publisher(sinks);
  Executive executive({&bus, &outbox, &robot, &publisher, &health, {}, true, &guard, {}});
  Rng rng(ForkSeed(seed, "trouble"));
  bool stop_requested = false;
  StopRequest stop = [&] {
    if (plight.Has(Trouble::kFlood)) Flood(&bus, false, &rng);
    if (plight.Has(Trouble::kWrongFingerprints)) Flood(&bus, true, &rng);
    if (plight.Has(Trouble::kStop) && robot.clock->Now() >= plight.stop_at && !stop_requested) {
      stop_requested = true;
      guard.Hold("a stop at a random moment");
      robot.Stop();
    }
    return stop_requested || executive.StopRequested();
  };
  if (log) stop = log->Recorded(std::move(stop), [] { return 0; });
  Mission mission({}, {}, database, ready.calibration, seed, stop, &publisher, &robot);
  if (ready.hand) mission.KnowArm(*ready.hand);

  Progress progress = Progress::kMore;
  bool lost = false;
  std::string crash;
  Json trial;
  try {
    for (int step = 0; step < kMaxSteps && progress == Progress::kMore; ++step) {
      progress = mission.Step();
      if (!trial.contains("verdicts_by_then") && mission.record().total_seconds >= by_then) {
        trial["verdicts_by_then"] = Judged(mission, *ready.world);
      }
    }
  } catch (const DeviceError& error) {
    lost = true;
  } catch (const ProtocolError& error) {
    lost = true;
  } catch (const std::exception& error) {
    crash = error.what();
  }
  if (lost) progress = Progress::kFailed;
  witness.Ended();
  const int status = lost ? kDeviceFailed : StatusOf(progress, 0);
  trial["end"] = ToString(progress);
  trial["why"] = mission.record().end;
  trial["status"] = status;
  trial["crash"] = crash;
  trial["stopped_by_executive"] = executive.StopRequested();
  trial["hangs"] = progress == Progress::kMore ||
                   mission.record().total_seconds > mission.task().budget.seconds + kLastLook;
  trial["untruth"] = crash.empty() ? Untruth(mission, progress, stop(), lost, status) : crash;
  trial["motions_after_stop"] = witness.motions_after_stop();
  trial["still_moves"] = StillMoves(ready.world.get());
  trial["looks"] = mission.record().looks.size();
  trial["robot_seconds"] = mission.record().total_seconds;
  trial["collisions"] = ready.world->collisions().size();
  trial["verdicts"] = Judged(mission, *ready.world);
  // It has ended before: no more than this was ever verified.
  if (!trial.contains("verdicts_by_then")) trial["verdicts_by_then"] = trial.at("verdicts");
  return trial;
}

int CountVerdicts(const Json& mission, const char* kind, const char* when = "verdicts") {
  const Json& verdicts = mission.at(when);
  return static_cast<int>(std::count_if(verdicts.begin(), verdicts.end(), [&](const Json& verdict) {
    return verdict.at("verdict") == kind;
  }));
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  const int count = static_cast<int>(trials.size());
  const auto missions = [&](const auto& predicate) {
    return Proportion(static_cast<int>(std::count_if(
                          trials.begin(), trials.end(),
                          [&](const Json& trial) { return predicate(trial.at("with_faults")); })),
                      count);
  };
  int wrong = 0;
  int right = 0;
  std::vector<double> rights;
  // Without faults, when the mission with them had ended: one that a lost device ends early has
  // verified by few views.
  int wrong_without = 0;
  int verified_without = 0;
  int right_without = 0;
  int collided_without = 0;
  std::vector<double> more_wrong;
  for (const Json& trial : trials) {
    const Json& with = trial.at("with_faults");
    const Json& without = trial.at("without_faults");
    wrong += CountVerdicts(with, "wrong");
    right += CountVerdicts(with, "right");
    rights.push_back(CountVerdicts(with, "right"));
    const int wrong_by_then = CountVerdicts(without, "wrong", "verdicts_by_then");
    wrong_without += wrong_by_then;
    verified_without += wrong_by_then + CountVerdicts(without, "right", "verdicts_by_then");
    right_without += CountVerdicts(without, "right");
    collided_without += without.at("collisions") > 0;
    more_wrong.push_back(CountVerdicts(with, "wrong") - wrong_by_then);
  }
  const auto share = [](int part, int all) { return all == 0 ? 0.0 : 1.0 * part / all; };
  return {
      {"missions that crash", missions([](const Json& m) { return m.at("crash") != ""; })},
      {"missions that hang", missions([](const Json& m) { return m.at("hangs"); })},
      {"missions with a motion after a stop",
       missions([](const Json& m) { return m.at("motions_after_stop") > 0; })},
      {"missions after which the robot moves",
       missions([](const Json& m) { return m.at("still_moves"); })},
      {"missions whose status or report is not true",
       missions([](const Json& m) { return m.at("untruth") != ""; })},
      {"verified wrongly, of all verified",
       Proportion(wrong, wrong + right),
       {},
       share(wrong_without, verified_without)},
      {"verified wrongly, a mission, more than without faults", BootstrappedMean(more_wrong)},
      {"known objects right, a mission", BootstrappedMean(rights), {}, share(right_without, count)},
      {"missions with a collision",
       missions([](const Json& m) { return m.at("collisions") > 0; }),
       {},
       share(collided_without, count)}};
}

}  // namespace

void RunFaultsExperiment(const ExperimentOptions& options) {
  spdlog::set_level(spdlog::level::critical);  // every fault warns of itself
  const auto database = world::ObjectDatabase::Load(options.models);
  const Repertoire repertoire = LoadRepertoire(options.models, options.unfamiliar);
  RunTrials(
      "faults", options,
      [&](int t) {
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("trial {}", t));
        Rng rng(ForkSeed(seed, "scene"));
        const sim::Scene scene = DrawScene(repertoire, &rng);
        Rng chance(ForkSeed(seed, "faults"));
        const Plight plight = DrawPlight(&chance);
        Plight none;
        none.with_arm = plight.with_arm;
        Json trial;
        trial["seed"] = seed;
        trial["arm"] = plight.with_arm;
        trial["faults"] = Json::array();
        for (const sim::Fault& fault : plight.faults) {
          trial.at("faults").push_back(
              {{"fault", ToString(fault)},
               {"from", ToSeconds(fault.from.time_since_epoch())},
               {"until", fault.until == Time::max()
                             ? Json(nullptr)
                             : Json(ToSeconds(fault.until.time_since_epoch()))}});
        }
        for (const Trouble trouble : plight.troubles) {
          trial.at("faults").push_back({{"fault", ToString(trouble)}});
        }
        trial["with_faults"] = RunInPlight(scene, database, seed, plight);
        const double end = trial.at("with_faults").at("robot_seconds");
        trial["without_faults"] = RunInPlight(scene, database, seed, none, end);
        fmt::print(stderr, "trial {}: {}\n", t,
                   trial.at("with_faults").at("end").get<std::string>());
        return trial;
      },
      Summarise);
}

}  // namespace secondlook::apps

#include "apps/mission.h"

#include <algorithm>
#include <array>
#include <utility>

#include <spdlog/spdlog.h>

#include "apps/run_config.h"
#include "lib/common/error.h"
#include "lib/common/stopwatch.h"
#include "lib/fusion/dempster_shafer.h"
#include "lib/planning/choose_look.h"
#include "lib/planning/hidden_space.h"

#include "second_look/nav_status_t.hpp"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using world::ObjectBelief;
using world::ObjectState;

/// Where the head looks for a table, one after the other.
constexpr std::array<hal::PanTiltAngles, 9> kSearch{{{0.0, 0.35},
                                                     {0.7, 0.35},
                                                     {-0.7, 0.35},
                                                     {1.4, 0.35},
                                                     {-1.4, 0.35},
                                                     {2.1, 0.35},
                                                     {-2.1, 0.35},
                                                     {0.0, 0.7},
                                                     {0.0, 0.1}}};

/// A belief below this is none.
constexpr double kNegligible = 0.02;
/// A base that has driven less has not set out [m].
constexpr double kSetOut = 0.05;
/// One that looks so nearly towards its first waypoint has turned to it [rad].
constexpr double kTurnedTo = 0.2;
/// So many looks at hidden space that never got there are enough.
constexpr int kMaxVain = 3;

int PhaseOf(DriveOutcome::Kind kind) {
  switch (kind) {
    case DriveOutcome::Kind::kReached:
      return second_look::nav_status_t::REACHED;
    case DriveOutcome::Kind::kStopped:
      return second_look::nav_status_t::STOPPED;
    default:
      return second_look::nav_status_t::FAILED;
  }
}

/// True when a look of this kind can be taken.
bool Offers(const std::vector<world::Look>& looks, const std::string& kind) {
  return std::any_of(looks.begin(), looks.end(),
                     [&](const world::Look& look) { return look.feasible && look.kind == kind; });
}

/// Why no scan can be taken.
std::string RefusedScans(std::vector<world::Look> looks) {
  std::erase_if(looks, [](const world::Look& look) { return look.kind != "scan"; });
  double most = 0.0;
  for (const world::Look& look : looks) most = std::max(most, look.visibility);
  return fmt::format("the best of them would add {:.1f} % to what is seen; {}", 100.0 * most,
                     planning::RefusalSummary(looks));
}

}  // namespace

Mission::Mission(const MissionConfig& config, const world::Task& task,
                 const world::ObjectDatabase& database,
                 const kinematics::HeadCalibration& calibration, std::uint64_t seed,
                 StopRequest stop, Publisher* publisher, hal::Robot* robot)
    : config_(config),
      task_(task),
      database_(database),
      robot_(robot),
      publisher_(publisher),
      calibration_(calibration),
      stop_(std::move(stop)),
      seed_(seed),
      rng_(ForkSeed(seed, "mission")),
      capturer_(robot, calibration),
      scene_(config.understanding, task, database),
      planner_(config.looks, config.understanding,
               {robot->base->info(), robot->head->info(), calibration, robot->head_camera->info()}),
      start_(robot->clock->Now()) {
  if (!config_.modelling) return;
  exploration_.emplace(*config_.modelling, database);
  planner_.KnowModelling(*config_.modelling);
}

Progress Mission::Step() try {
  std::optional<TakenLook> look;
  if (searched_ == 0) {
    publisher_->BeginStep();
    look = SearchForTable();  // wherever the head looked before
  } else {
    look = Plan();
  }
  if (choose_) look = Overruled(std::move(look));
  return look ? Act(*look) : progress_;
} catch (const DeviceError& error) {
  if (GoOnWithoutArm(error)) return Progress::kMore;
  End(Progress::kFailed, fmt::format("a device failed: {}", error.what()));
  throw;
} catch (const ProtocolError& error) {
  End(Progress::kFailed, fmt::format("a device does not keep to its protocol: {}", error.what()));
  throw;
}

std::optional<TakenLook> Mission::Plan() {
  publisher_->BeginStep();
  const std::optional<Capture> capture = Grab();
  if (!capture) {
    End(Progress::kStopped, "stopped on request");
    return std::nullopt;
  }
  Understand(*capture);
  if (!belief().plane_W) return SearchForTable();
  return Choose();
}

void Mission::KnowArm(const kinematics::EyeInHand& hand) {
  capturer_.KnowArm(hand);
  arm_known_ = true;
  const hal::CameraInfo& camera = robot_->hand_camera->info();
  if (!camera.has_depth) {
    spdlog::warn(
        "camera '{}' measures no depth, so that its views cannot add to the map: arm '{}' "
        "stays where it is",
        camera.name, robot_->arm->info().name);
    return;
  }
  planner_.KnowArm({config_.looks.arm,
                    {robot_->base->info(), robot_->arm->info(), camera, hand},
                    robot_->arm->State().q,
                    seed_});
}

/// When it was the arm or the camera in its hand that failed, the looks of the head remain. False
/// when it was something else, without which there is no mission.
bool Mission::GoOnWithoutArm(const DeviceError& error) try {
  if (!arm_known_) return false;
  robot_->Stop();
  robot_->base->State();
  robot_->head->State();
  const bool arm_lost = [&] {
    try {
      capturer_.ArmNow();
      return false;
    } catch (const Error&) {
      return true;
    }
  }();
  const bool of_the_hand = eye_ == world::LookWay::kArm && planner_.TakesArmLooks();
  if (!arm_lost && !of_the_hand) return false;
  if (arm_lost) {
    if (!capturer_.LoseArm()) return false;
    planner_.LoseArm();
  } else {
    planner_.TakeNoArmLooks();
  }
  eye_ = world::LookWay::kHead;
  blind_frames_ = 0;
  without_ =
      fmt::format("without looks by arm '{}', as {}", robot_->arm->info().name, error.what());
  spdlog::warn("the mission goes on {}", without_);
  return true;
} catch (const Error&) {
  return false;
}

Stance Mission::Standing() const {
  Stance stance{robot_->base->State().X_WB, robot_->head->State().angles, {}};
  if (arm_known_) {
    stance.q = capturer_.ArmNow();
  } else if (robot_->arm) {
    stance.q = robot_->arm->State().q;
  }
  stance.time = robot_->clock->Now();
  return stance;
}

/// The camera of the next view.
const hal::CameraInfo& Mission::Eye() const {
  return (eye_ == world::LookWay::kArm ? robot_->hand_camera : robot_->head_camera)->info();
}

/// A frame, or nothing when asked to stop meanwhile.
std::optional<Capture> Mission::Grab() {
  publisher_->Doing("grabbing", "waiting for a frame", robot_->clock->Now());
  for (int i = 0; i < config_.looks.frame_tries; ++i) {
    if (stop_()) return std::nullopt;
    std::optional<Capture> capture = capturer_.Take(Seconds(config_.looks.frame_timeout_s), eye_);
    if (!capture) continue;
    RequireDepth(*capture);
    return capture;
  }
  robot_->Stop();
  Throw<DeviceError>(
      "camera '{}': no frame in {} tries of {} s; check its cable and driver, or raise "
      "mission.looks.frame_timeout_s",
      Eye().name, config_.looks.frame_tries, config_.looks.frame_timeout_s);
}

/// One frame without any depth may be a wall right ahead; several are a fault of the camera.
void Mission::RequireDepth(const Capture& capture) {
  blind_frames_ = ShareWithDepth(capture.frame.depth) > 0.0 ? 0 : blind_frames_ + 1;
  if (blind_frames_ < config_.looks.frame_tries) return;
  robot_->Stop();
  Throw<DeviceError>(
      "camera '{}': no usable depth in {} frames in a row; check its projector and driver, and "
      "that nothing covers it",
      Eye().name, blind_frames_);
}

/// A view that was registered says where the base really stands; so it stands there for the next
/// view, too, if only head and arm have moved in between.
void Mission::Understand(Capture capture) {
  const Pose X_measured = capture.X_WC;
  if (footing_) {
    capture.X_WC = footing_->X_RegisteredMeasured * X_measured;
    capture.p_CB_W = footing_->X_RegisteredMeasured.linear() * capture.p_CB_W;
    capture.covariance =
        perception::CovarianceBeside(config_.understanding.registration, footing_->covariance,
                                     capture.X_WC.translation() - footing_->p_WC);
  }
  publisher_->Doing("understanding", fmt::format("frame {}", capture.frame.sequence),
                    robot_->clock->Now());
  publisher_->Image(capture.frame);
  Charge(config_.looks.understand_seconds);
  const Stopwatch watch;
  const std::string reason = scene_.Add(capture);
  stages_.push_back({"understand", config_.looks.understand_seconds, watch.Seconds()});
  TellView(capture, reason);
  if (reason.empty()) {
    const Pose& X_WC = belief().views.back().X_WC;
    footing_ = {X_WC * X_measured.inverse(), X_WC.translation(), scene_.covariance()};
  } else {
    spdlog::warn("nothing learned from frame {}: {}", capture.frame.sequence, reason);
    planner_.NoteVain(X_measured.translation());
  }
  for (const ObjectBelief& object : belief().objects) {
    std::string& told = told_[object.id];
    if (told == object.reason) continue;
    told = object.reason;
    spdlog::info("object {}: {}: {}", object.id, ToString(object.state), object.reason);
  }
}

Question Mission::WhatIsOpen() const {
  Question question;
  std::vector<Eigen::AlignedBox3d> known_W;
  for (const ObjectBelief& object : belief().objects) {
    if (object.state == ObjectState::kRejected) continue;
    Eigen::AlignedBox3d box_W = object.extent_W;
    if (object.state == ObjectState::kVerified) {
      const world::PoseHypothesis& best = *object.Best();
      const perception::RecognitionModel* model =
          perception::FindModel(scene_.models(), best.model);
      box_W.extend(PlacedBox(model->mesh, best.X_WM));
    }
    known_W.push_back(box_W);
    if (object.Settled() || !Matters(object)) continue;
    (object.looks_taken < config_.looks.per_object ? question.open : question.spent)
        .push_back(&object);
  }
  if (explored_ < config_.looks.at_hidden_space && vain_ < kMaxVain && !AllWantedFound()) {
    question.hidden_W = planning::HiddenRegions(scene_.space(), *belief().plane_W, known_W,
                                                config_.looks.hidden_space);
  }
  return question;
}

/// What is open and, when it is nothing but hidden space, what is to be modelled. So it is when no
/// look can help what is open: `stuck`.
Question Mission::WhatToAsk(bool stuck) {
  Question question = WhatIsOpen();
  while (exploration_ && (stuck || question.open.empty())) {
    std::optional<ModelledThing> thing = exploration_->Work(belief(), robot_->clock->Now());
    if (!thing) {
      scene_.DoNotRecognise(exploration_->NotToRecognise());
      question.scan = exploration_->Target(belief(), scene_.space());
      break;
    }
    Know(*std::move(thing));
    question = WhatIsOpen();
  }
  return question;
}

/// Recognises what was modelled from now on, and has it kept.
void Mission::Know(ModelledThing thing) {
  const int id = thing.object;
  scene_.DoNotRecognise({});
  if (thing.model.empty()) {
    scene_.Note(id, "was not modelled: " + thing.reason);
  } else {
    scene_.LearnModelled(id, AsModel(thing.scanned), thing.X_WM);
    scene_.Note(id, fmt::format("modelled as '{}' from {} scans, {:.0f} % of it seen: {}",
                                thing.model, thing.scanned.provenance.scans,
                                100.0 * thing.scanned.provenance.coverage, thing.reason));
    if (keep_) thing.not_kept = keep_(thing.scanned);
    if (!thing.not_kept.empty()) {
      spdlog::warn("model '{}' is known in this mission alone: {}", thing.model, thing.not_kept);
    }
  }
  spdlog::info("object {}: {}", id, belief().objects[id].reason);
  publisher_->Belief(belief(), robot_->clock->Now());
  record_.modelled.push_back(std::move(thing));
}

/// True when the task wants certain classes and each has been found.
bool Mission::AllWantedFound() const {
  const auto found = [&](const auto& wanted) {
    return std::any_of(
        belief().objects.begin(), belief().objects.end(), [&](const ObjectBelief& object) {
          return object.state == ObjectState::kVerified && object.Best()->model == wanted.first;
        });
  };
  return !task_.wanted.empty() && std::all_of(task_.wanted.begin(), task_.wanted.end(), found);
}

/// False when the task wants certain classes and the object is surely none of them.
bool Mission::Matters(const ObjectBelief& object) const {
  if (task_.wanted.empty()) return true;
  double possible = fusion::NormalisedIgnorance(object.masses);
  for (const auto& [c, confidence] : task_.wanted) {
    possible += fusion::NormalisedBelief(object.masses, c);
  }
  return possible >= kNegligible;
}

std::optional<TakenLook> Mission::SearchForTable() {
  const hal::PanTiltInfo& head = robot_->head->info();
  while (searched_ > 0 && searched_ < static_cast<int>(kSearch.size()) &&
         !head.Reaches(kSearch[searched_])) {
    ++searched_;
  }
  if (searched_ == static_cast<int>(kSearch.size())) {
    End(Progress::kNoLook, "no table was found in any direction");
    return std::nullopt;
  }
  TakenLook taken;
  taken.look.kind = "search";
  taken.look.head = kSearch[searched_];
  taken.look.feasible = true;
  taken.look.chosen = true;
  taken.look.reason = "no support plane in view yet";
  taken.candidates = {taken.look};
  return taken;
}

/// @param stuck No look can help what is open.
std::optional<TakenLook> Mission::Choose(bool stuck) {
  const Question question = WhatToAsk(stuck);
  const auto settled = [&] {
    if (belief().objects.empty()) {
      End(Progress::kSettled, "nothing was found on the table");
    } else if (question.spent.empty()) {
      End(Progress::kSettled, "everything is settled");
    } else {
      End(Progress::kBudgetSpent, fmt::format("still open after {} looks each: {} of the things",
                                              config_.looks.per_object, question.spent.size()));
    }
    return std::nullopt;
  };
  if (question.Empty()) return settled();
  if (const std::string spent = BudgetSpent(); !spent.empty()) {
    End(Progress::kBudgetSpent, spent);
    return std::nullopt;
  }
  TakenLook best = ScoreLooks(question);
  if (question.scan && !Offers(best.candidates, "scan")) {
    Know(exploration_->Finish(belief(), "no scan adds anything: " + RefusedScans(best.candidates),
                              robot_->clock->Now()));
    return Choose(stuck);
  }
  if (best.look.chosen) return best;
  if (exploration_ && !stuck && !question.open.empty()) return Choose(true);
  record_.looks.push_back(best);
  if (question.open.empty()) return settled();  // nowhere to see hidden space from
  End(Progress::kNoLook, "no look is possible: " + best.look.reason);
  return std::nullopt;
}

/// The candidates for all that is open, scored; `look` is the best, chosen or not.
TakenLook Mission::ScoreLooks(const Question& question) {
  publisher_->Doing("choosing", fmt::format("{} open objects", question.open.size()),
                    robot_->clock->Now());
  Charge(config_.looks.plan_seconds);
  const Stopwatch watch;
  TakenLook taken;
  taken.candidates = planner_.Candidates(scene_, task_, question, Standing(), &rng_);
  const planning::LookChoice choice = planning::ChooseLook(&taken.candidates);
  if (choice.index) {
    taken.look = taken.candidates[*choice.index];
  } else {
    taken.look.kind = "none";
    taken.look.reason = choice.reason;
  }
  stages_.push_back({"choose", config_.looks.plan_seconds, watch.Seconds()});
  publisher_->Candidates(taken.candidates, robot_->clock->Now());
  return taken;
}

/// What choose_ makes of the mission's own choice.
std::optional<TakenLook> Mission::Overruled(std::optional<TakenLook> own) {
  if (progress_ == Progress::kStopped) return own;
  const bool had_own = own.has_value();
  std::optional<TakenLook> look = choose_(std::move(own), record_.end);
  if (had_own && !look) End(Progress::kNoLook, "the looks to follow end here");
  if (!had_own && look) {
    progress_ = Progress::kMore;
    record_.end.clear();
  }
  return look;
}

Progress Mission::Act(TakenLook taken) {
  const world::Look& look = taken.look;
  spdlog::info("look {} ({}): {}", record_.looks.size() + 1, look.kind, look.reason);
  if (look.kind == "search") ++searched_;
  const Time begin = robot_->clock->Now();
  publisher_->Doing("moving", look.reason, begin);
  publisher_->Look(look, begin);
  if (confirm_) {
    publisher_->Doing("waiting", "for a confirmation: " + look.reason, begin);
    confirm_(look);
    publisher_->Doing("moving", look.reason, begin);
  }
  const Stopwatch watch;
  const DriveOutcome outcome = MoveTo(
      look, stop_,
      [&](double metres) {
        TellMotion(second_look::nav_status_t::MOVING, "", record_.metres + metres);
      },
      robot_, &capturer_);
  stages_.push_back({"move", SecondsSince(begin), watch.Seconds()});
  record_.motion_seconds += SecondsSince(begin);
  record_.metres += outcome.metres;
  const bool reached = outcome.kind == DriveOutcome::Kind::kReached;
  if (!look.path_W.empty()) footing_.reset();
  eye_ = reached ? look.way : world::LookWay::kHead;
  if (!look.arm_motion.knots.empty()) planner_.NoteArm(look.arm_motion, robot_->arm->State().q);
  if (look.kind == "hidden_space") ++(reached ? explored_ : vain_);
  taken.outcome = reached ? "reached" : outcome.reason;
  if (outcome.kind == DriveOutcome::Kind::kFailed) {
    spdlog::warn("look {}: {}", record_.looks.size() + 1, outcome.reason);
  }
  if (outcome.base_failed) {
    planner_.Block(WhatStopped(look, outcome), robot_->clock->Now());
  } else if (look.kind != "scan" && look.target >= 0 &&
             look.target < std::ssize(belief().objects)) {
    scene_.CountLook(look.target);  // one that was stopped on the way was none for its sake
  }
  record_.looks.push_back(std::move(taken));
  record_.total_seconds = SecondsSince(start_);
  TellMotion(PhaseOf(outcome.kind), outcome.reason, record_.metres);
  publisher_->Timing(std::exchange(stages_, {}), robot_->clock->Now());
  if (outcome.kind == DriveOutcome::Kind::kStopped) {
    End(Progress::kStopped, "stopped on request");
  }
  return progress_;
}

/// The place that the base does not drive to, although nothing that the map shows is in its way:
/// right ahead of where it stopped; its goal, when it has not even set out for it.
Eigen::Vector2d Mission::WhatStopped(const world::Look& look, const DriveOutcome& outcome) const {
  const Pose2 X_WB = robot_->base->State().X_WB;
  const Pose2& first = look.path_W.front();
  const double away = std::atan2(first.y - X_WB.y, first.x - X_WB.x) - X_WB.yaw;
  const bool turned_to_it = std::abs(WrapAngle(away)) < kTurnedTo;
  if (outcome.metres < kSetOut && !turned_to_it) {
    return {look.path_W.back().x, look.path_W.back().y};
  }
  const double ahead = robot_->base->info().radius + config_.looks.blocked_radius_m;
  return {X_WB.x + ahead * std::cos(X_WB.yaw), X_WB.y + ahead * std::sin(X_WB.yaw)};
}

/// The view, what is believed after it, and what it changed in the map.
void Mission::TellView(const Capture& capture, const std::string& reason) {
  publisher_->View(capture, belief(), reason);
  if (!reason.empty()) return;
  publisher_->Belief(belief(), capture.frame.time);
  publisher_->Map(scene_.space(), capture.frame.time);
}

void Mission::TellMotion(int phase, const std::string& reason, double metres) {
  publisher_->NavStatus(phase, reason, robot_->base->State(), robot_->head->State().angles, metres);
}

void Mission::SetTask(const world::Task& task) {
  task.Validate();
  RequireKnownClasses(task, database_);
  task_ = task;
  scene_.SetTask(task);
}

void Mission::Learn(const world::ObjectModel& model) { scene_.Learn(model); }

void Mission::Resume() {
  progress_ = Progress::kMore;
  record_.end.clear();
  spdlog::info("the mission goes on");
}

void Mission::End(Progress progress, std::string why) {
  robot_->Stop();
  const bool well = progress != Progress::kStopped && progress != Progress::kFailed;
  if (exploration_ && well) {
    std::optional<ModelledThing> thing =
        exploration_->FinishAny(belief(), why, robot_->clock->Now());
    if (thing) Know(*std::move(thing));
  }
  progress_ = progress;
  record_.total_seconds = SecondsSince(start_);
  record_.end = std::move(why);
  if (!without_.empty() && progress != Progress::kFailed) record_.end += "; " + without_;
  spdlog::info("the mission ends: {}", record_.end);
  publisher_->Timing(std::exchange(stages_, {}), robot_->clock->Now());
  publisher_->Doing("ended", record_.end, robot_->clock->Now());
}

void Mission::Charge(double seconds) {
  robot_->clock->ChargeThinking(Seconds(seconds));
  record_.compute_seconds += seconds;
  record_.total_seconds = SecondsSince(start_);
}

double Mission::SecondsSince(Time start) const { return ToSeconds(robot_->clock->Now() - start); }

/// Which part of the budget is spent; empty when none is.
std::string Mission::BudgetSpent() const {
  const world::Budget& budget = task_.budget;
  const int looks = static_cast<int>(
      std::count_if(record_.looks.begin(), record_.looks.end(),
                    [](const TakenLook& taken) { return taken.look.kind != "search"; }));
  if (looks >= budget.looks) return fmt::format("the budget of {} looks is spent", budget.looks);
  if (budget.seconds > 0.0 && SecondsSince(start_) >= budget.seconds) {
    return fmt::format("the budget of {} s is spent", budget.seconds);
  }
  if (budget.metres > 0.0 && record_.metres >= budget.metres) {
    return fmt::format("the budget of {} m is spent", budget.metres);
  }
  return "";
}

}  // namespace secondlook::apps

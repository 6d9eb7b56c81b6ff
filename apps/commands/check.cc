#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "apps/appearance.h"
#include "apps/capture.h"
#include "apps/commands/commands.h"
#include "apps/make_robot.h"
#include "apps/real_robot.h"
#include "apps/run_config.h"
#include "lib/common/error.h"
#include "lib/geometry/point_image.h"
#include "lib/hal/drivers/live_clock.h"
#include "lib/kinematics/calibration_file.h"
#include "lib/perception/segment.h"
#include "lib/world/object_database.h"
#include "sim/scene.h"
#include "sim/standing_room.h"

namespace secondlook::apps {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kRateSeconds = 1.0;  // for which frames are counted
/// So far apart the cameras of head and hand may see one table: the simulated robot's errors before
/// it is calibrated, at 1 m.
constexpr double kSameHeight = 0.02;  // [m]
constexpr double kSameTilt_deg = 2.0;

struct CheckOptions {
  std::string config;
  std::vector<std::string> overrides;
};

/// Prints one line for each thing that was checked and remembers the worst.
class Checklist {
 public:
  /// Prints what `check` returns, or what it throws. True when it did not throw.
  bool Check(const std::string& thing, const std::function<std::string()>& check) {
    try {
      Print("ok", thing, check());
      return true;
    } catch (const ConfigError& error) {
      input_wrong_ = true;
      Print("WRONG", thing, error.what());
    } catch (const InvalidArgument& error) {
      input_wrong_ = true;
      Print("WRONG", thing, error.what());
    } catch (const Error& error) {
      device_wrong_ = true;
      Print("WRONG", thing, error.what());
    }
    return false;
  }

  int Status() const { return input_wrong_ ? kWrongInput : device_wrong_ ? kDeviceFailed : kDone; }

 private:
  static void Print(const char* verdict, const std::string& thing, const std::string& text) {
    fmt::print("{:5}  {:12}  {}\n", verdict, thing, text);
  }

  bool input_wrong_{};
  bool device_wrong_{};
};

std::string SizeOf(const geometry::Mesh& mesh) {
  const Eigen::Vector3d size = geometry::Bounds(mesh).sizes();
  return fmt::format("{:.3f} x {:.3f} x {:.3f} m, {} triangles", size.x(), size.y(), size.z(),
                     mesh.triangles.size());
}

/// Every model by itself, so that one that is wrong does not hide the next. Empty when one is.
std::optional<world::ObjectDatabase> CheckModels(const std::string& folder, Checklist* list) {
  bool all = true;
  std::vector<std::filesystem::path> objects;
  all &= list->Check("models", [&] {
    objects = world::ModelFolders(folder);
    return fmt::format("{}: {} of them", folder, objects.size());
  });
  for (const std::filesystem::path& object : objects) {
    all &= list->Check("model", [&] {
      const world::ObjectModel model = world::ReadModel(object);
      return fmt::format("'{}': {}", model.name, SizeOf(model.mesh));
    });
  }
  if (!all) return std::nullopt;
  std::optional<world::ObjectDatabase> database;
  list->Check("names", [&] {
    database = world::ObjectDatabase::Load(folder);
    return std::string("no two models have the same");
  });
  return database;
}

/// @throws ConfigError for an object that is called known without being so, or a start where there
/// is no room.
std::string CheckScene(const sim::SimConfig& config,
                       const std::optional<world::ObjectDatabase>& database) {
  const sim::Scene scene = sim::LoadScene(config.scene);
  scene.Validate();
  const std::vector<sim::PlacedObject> objects = sim::PlaceObjects(scene);
  sim::RequireStandingRoom(scene, objects);
  for (const sim::PlacedObject& object : objects) {
    const bool missing = database && database->Find(object.name) == nullptr;
    if (object.role == sim::Role::kKnown && missing) {
      Throw<ConfigError>(
          "{}: object '{}' has the role known, but no model has this name; add the model, or make "
          "its role unknown",
          config.scene, object.name);
    }
  }
  return fmt::format("{}: {} objects", config.scene, scene.objects.size());
}

std::string CheckCalibration(const kinematics::HeadCalibration& calibration) {
  if (!IsValid(calibration.X_BH0) || !IsValid(calibration.X_HC)) {
    Throw<ConfigError>("X_BH0 or X_HC is no rigid transform; calibrate the head anew");
  }
  const Eigen::Vector3d p_BC = CameraInBase(calibration, {}).translation();
  return fmt::format(
      "the camera sits at ({:.3f}, {:.3f}, {:.3f}) m in the base when the head looks "
      "ahead",
      p_BC.x(), p_BC.y(), p_BC.z());
}

/// What to say of how well it was calibrated, if it was.
std::string CheckResiduals(const std::optional<kinematics::CalibrationResiduals>& residuals) {
  if (!residuals) return "; nobody has calibrated it: `secondlook calibrate` does";
  return fmt::format("; calibrated from {} views, {:.2f} px, to {:.1f} mm and {:.2f} deg",
                     residuals->views, residuals->pixels, residuals->millimetres,
                     residuals->degrees);
}

std::string CheckCamera(const hal::CameraInfo& info) {
  info.model.Validate(("camera '" + info.name + "'").c_str());
  if (!info.has_depth) {
    Throw<ConfigError>("camera '{}': it has no depth, and a mission needs a camera with depth",
                       info.name);
  }
  const hal::CameraModel& m = info.model;
  const auto angle = [](int pixels, double focal) {
    return 2.0 * std::atan(0.5 * pixels / focal) * kDegrees;
  };
  return fmt::format(
      "'{}': {} x {} pixels, {:.0f} x {:.0f} deg, depth from {} to {} m; fx {:.1f}, fy {:.1f}, cx "
      "{:.1f}, cy {:.1f} px",
      info.name, m.width, m.height, angle(m.width, m.fx), angle(m.height, m.fy), info.min_depth,
      info.max_depth, m.fx, m.fy, m.cx, m.cy);
}

/// Waits for a frame as a mission would.
std::string CheckFrame(const LookConfig& looks, hal::Camera* camera) {
  const std::string& name = camera->info().name;
  std::optional<hal::RgbdFrame> frame;
  for (int i = 0; i < looks.frame_tries && !frame; ++i) {
    frame = camera->Grab(Seconds(looks.frame_timeout_s));
  }
  if (!frame) {
    Throw<DeviceError>("camera '{}': no frame in {} tries of {} s; check its cable and driver",
                       name, looks.frame_tries, looks.frame_timeout_s);
  }
  if (!camera->info().has_depth) return fmt::format("'{}': frame {} came", name, frame->sequence);
  const double share = ShareWithDepth(frame->depth);
  if (share == 0.0) {
    Throw<DeviceError>(
        "camera '{}': no usable depth: no pixel of frame {} has any; check its projector and "
        "driver, and that nothing covers it",
        name, frame->sequence);
  }
  return fmt::format("'{}': frame {} came; {:.0f} % of its pixels have depth", name,
                     frame->sequence, 100.0 * share);
}

/// How often frames come, and how old the newest is.
std::string CheckRate(hal::Camera* camera, const Clock& clock) {
  std::optional<hal::RgbdFrame> first;
  std::optional<hal::RgbdFrame> last;
  const Time end = clock.Now() + Seconds(kRateSeconds);
  while (clock.Now() < end) {
    std::optional<hal::RgbdFrame> frame = camera->Grab(Seconds(kRateSeconds));
    if (!frame) continue;
    if (!first) first = frame;
    last = std::move(frame);
  }
  if (!last || last->sequence == first->sequence) {
    Throw<DeviceError>(
        "camera '{}': not two frames in {} s; lower its resolution, or check its cable",
        camera->info().name, kRateSeconds);
  }
  const auto frames = static_cast<double>(last->sequence - first->sequence);
  return fmt::format("'{}': {:.0f} frames a second, the newest {:.3f} s old", camera->info().name,
                     frames / ToSeconds(last->time - first->time),
                     ToSeconds(clock.Now() - last->time));
}

std::string CheckHead(hal::PanTilt* head) {
  const hal::PanTiltInfo& info = head->info();
  const hal::PanTiltAngles now = head->State().angles;
  const std::string limits = fmt::format("pan {:.0f} to {:.0f} deg, tilt {:.0f} to {:.0f} deg",
                                         info.lower.pan * kDegrees, info.upper.pan * kDegrees,
                                         info.lower.tilt * kDegrees, info.upper.tilt * kDegrees);
  if (!std::isfinite(now.pan) || !std::isfinite(now.tilt)) {
    Throw<DeviceError>("pan-tilt '{}': its angles are not finite; reference it anew", info.name);
  }
  return fmt::format("'{}': at pan {:.1f}, tilt {:.1f} deg; limits: {}", info.name,
                     now.pan * kDegrees, now.tilt * kDegrees, limits);
}

std::string CheckArm(hal::Arm* arm) {
  const hal::ArmInfo& info = arm->info();
  const Eigen::VectorXd q = arm->State().q;
  if (q.size() != static_cast<Eigen::Index>(info.joints.size()) || !q.allFinite()) {
    Throw<DeviceError>("arm '{}': it does not say {} finite joint angles; reference it anew",
                       info.name, info.joints.size());
  }
  std::string at;
  for (std::size_t i = 0; i < info.joints.size(); ++i) {
    const hal::JointInfo& joint = info.joints[i];
    const double angle = q[static_cast<Eigen::Index>(i)];
    at += fmt::format("{}{:.0f}", i == 0 ? "" : ", ", angle * kDegrees);
    if (angle >= joint.lower && angle <= joint.upper) continue;
    Throw<DeviceError>(
        "arm '{}': joint '{}' at {:.1f} deg is beyond its limits of {:.1f} to {:.1f} deg; move it "
        "back by hand",
        info.name, joint.name, angle * kDegrees, joint.lower * kDegrees, joint.upper * kDegrees);
  }
  return fmt::format("'{}': {} joints, at {} deg", info.name, info.joints.size(), at);
}

std::string CheckHandCamera(const hal::CameraInfo& info, const kinematics::EyeInHand& hand) {
  if (!IsValid(hand.X_EC)) {
    Throw<ConfigError>("X_EC is no rigid transform; calibrate hand and eye anew");
  }
  info.model.Validate(("camera '" + info.name + "'").c_str());
  return fmt::format("'{}': {} x {} pixels, {}, {:.3f} m from the end-effector", info.name,
                     info.model.width, info.model.height,
                     info.has_depth ? "with depth" : "colour alone",
                     hand.X_EC.translation().norm());
}

/// It stays dark.
std::string CheckStriper(hal::LaserStriper* striper, const Pose& X_EL) {
  if (!IsValid(X_EL)) {
    Throw<ConfigError>("X_EL is no rigid transform; calibrate the laser on the arm anew");
  }
  striper->Take();
  const hal::StriperInfo& info = striper->info();
  return fmt::format(
      "'{}': {} points over {:.2f} deg, from {} to {} m, {} lines a second; {:.3f} m from the "
      "end-effector",
      info.name, info.points, info.field_of_view * kDegrees, info.min_range, info.max_range,
      info.lines_per_second, X_EL.translation().norm());
}

std::string CheckBase(hal::Base* base) {
  const hal::BaseInfo& info = base->info();
  const Pose2 X_WB = base->State().X_WB;
  if (!std::isfinite(X_WB.x) || !std::isfinite(X_WB.y) || !std::isfinite(X_WB.yaw)) {
    Throw<DeviceError>("base '{}': its pose is not finite; check localisation", info.name);
  }
  return fmt::format("'{}': at ({:.2f}, {:.2f}) m, {:.0f} deg in W; radius {} m, {} m/s", info.name,
                     X_WB.x, X_WB.y, X_WB.yaw * kDegrees, info.radius, info.speed);
}

/// What `way`'s camera sees of the table where it is, in W; without one, `reason` says why.
std::optional<world::SupportPlane> TableSeen(const MissionConfig& config, Capturer* capturer,
                                             world::LookWay way, std::string* reason) {
  const UnderstandingConfig& understanding = config.understanding;
  const std::optional<Capture> capture = capturer->Take(Seconds(config.looks.frame_timeout_s), way);
  if (!capture) {
    *reason = "no frame came";
    return std::nullopt;
  }
  const Pose& X_WC = capture->X_WC;
  const Eigen::Vector3d up_C = X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
  const perception::Segmentation seen = perception::Segment(
      geometry::Deproject(capture->frame.depth, capture->camera), up_C, understanding.segment,
      X_WC.translation().z() - understanding.floor_clearance_m);
  if (seen.plane_C) return Transform(X_WC, *seen.plane_C);
  *reason = seen.reason;
  return std::nullopt;
}

/// Whether the cameras of head and hand put the table in the same place. That they both see one is
/// not asked for: nothing moves here.
/// @throws DeviceError when they do not, with what to do about it.
std::string CheckSameTable(const MissionConfig& config, hal::Robot* robot,
                           const kinematics::HeadCalibration& calibration,
                           const kinematics::EyeInHand& hand) {
  Capturer capturer(robot, calibration);
  capturer.KnowArm(hand);
  std::string reason;
  const auto by_head = TableSeen(config, &capturer, world::LookWay::kHead, &reason);
  if (!by_head) {
    return fmt::format("not compared, as the head's camera sees none: {}; turn it to the table",
                       reason);
  }
  const auto by_hand = TableSeen(config, &capturer, world::LookWay::kArm, &reason);
  if (!by_hand) {
    return fmt::format(
        "not compared, as the hand's camera sees none: {}; move the arm by hand so that it looks "
        "at the table",
        reason);
  }
  Eigen::Vector3d middle_W = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& corner_W : by_hand->corners_A) middle_W += corner_W / 4.0;
  const double apart = by_head->HeightOf(middle_W);
  const double tilted =
      kDegrees * std::acos(std::clamp(by_head->normal_A.dot(by_hand->normal_A), -1.0, 1.0));
  const std::string what = fmt::format(
      "the hand's camera sees it {:.1f} mm {} than the head's, and tilted by {:.1f} deg",
      1e3 * std::abs(apart), apart < 0.0 ? "lower" : "higher", tilted);
  if (std::abs(apart) <= kSameHeight && tilted <= kSameTilt_deg) return what;
  Throw<DeviceError>(
      "{}; {:.0f} mm and {:.0f} deg are usual: calibrate both with `secondlook calibrate --hand`, "
      "and check that both look at the same table",
      what, 1e3 * kSameHeight, kSameTilt_deg);
}

/// A real robot, each device by itself, so that one that does not answer does not hide the next.
void CheckRealRobot(const RunConfig& config, const RealConfig& real, Checklist* list) {
  kinematics::Calibration calibration;
  list->Check("calibration", [&] {
    calibration = kinematics::LoadCalibration(real.calibration);
    return CheckCalibration(calibration.head) + CheckResiduals(calibration.residuals);
  });
  hal::Robot robot;  // what is there of it
  robot.clock = std::make_unique<hal::LiveClock>();
  RealDevices devices(real, robot.clock.get());
  const auto check_frames = [&](const std::string& prefix, hal::Camera* camera) {
    list->Check(prefix + "frame", [&] { return CheckFrame(config.mission.looks, camera); });
    list->Check(prefix + "rate", [&] { return CheckRate(camera, *robot.clock); });
  };
  const bool sees = list->Check("camera", [&] {
    robot.head_camera = devices.OpenCamera();
    return CheckCamera(robot.head_camera->info());
  });
  if (sees) check_frames("", robot.head_camera.get());
  const bool turns = list->Check("pan-tilt", [&] {
    robot.head = devices.OpenHead();
    return CheckHead(robot.head.get());
  });
  const bool stands = list->Check("base", [&] {
    robot.base = devices.OpenBase();
    return CheckBase(robot.base.get());
  });
  if (!real.arm) return;
  const bool reaches = list->Check("arm", [&] {
    robot.arm = devices.OpenArm();
    return CheckArm(robot.arm.get());
  });
  std::optional<kinematics::EyeInHand> hand;
  const bool hand_sees = list->Check("hand camera", [&] {
    robot.hand_camera = devices.OpenHandCamera();
    hand = LoadArm(*real.arm, calibration);
    return CheckHandCamera(robot.hand_camera->info(), *hand);
  });
  if (hand_sees) check_frames("hand ", robot.hand_camera.get());
  if (sees && turns && stands && reaches && hand_sees && robot.hand_camera->info().has_depth) {
    list->Check("same table",
                [&] { return CheckSameTable(config.mission, &robot, calibration.head, *hand); });
  }
  if (!real.arm->striper) return;
  list->Check("striper",
              [&] { return CheckStriper(devices.OpenStriper().get(), LaserOnArm(calibration)); });
}

void CheckRobot(const RunConfig& config, Checklist* list) {
  if (const auto* real = std::get_if<RealConfig>(&config.robot)) {
    CheckRealRobot(config, *real, list);
    return;
  }
  std::optional<ReadyRobot> ready;
  const bool connected = list->Check("robot", [&] {
    ready.emplace(MakeRobot(config.robot, config.seed));
    return std::string("simulated");
  });
  if (!connected) return;
  hal::Robot& robot = ready->robot;
  list->Check("calibration", [&] { return CheckCalibration(ready->calibration); });
  list->Check("camera", [&] { return CheckCamera(robot.head_camera->info()); });
  list->Check("frame", [&] { return CheckFrame(config.mission.looks, robot.head_camera.get()); });
  list->Check("pan-tilt", [&] { return CheckHead(robot.head.get()); });
  list->Check("base", [&] { return CheckBase(robot.base.get()); });
  if (!robot.arm) return;
  list->Check("arm", [&] { return CheckArm(robot.arm.get()); });
  if (!robot.hand_camera) return;
  list->Check("hand camera",
              [&] { return CheckHandCamera(robot.hand_camera->info(), *ready->hand); });
  list->Check("hand frame",
              [&] { return CheckFrame(config.mission.looks, robot.hand_camera.get()); });
  if (robot.hand_camera->info().has_depth) {
    list->Check("same table", [&] {
      return CheckSameTable(config.mission, &robot, ready->calibration, *ready->hand);
    });
  }
  if (!robot.striper) return;
  list->Check("striper", [&] { return CheckStriper(robot.striper.get(), *ready->X_EL); });
}

int RunCheck(const CheckOptions& options) {
  Checklist list;
  RunConfig config;
  const bool readable = list.Check("config", [&] {
    config = LoadRunConfig(options.config, options.overrides);
    return options.config;
  });
  if (!readable) return list.Status();
  std::optional<world::ObjectDatabase> database = CheckModels(config.models, &list);
  if (database && !config.learned.empty()) {
    list.Check("learned", [&] {
      const std::size_t given = database->models().size();
      database = LoadDatabase(config);
      return fmt::format("{}: {} of them", config.learned, database->models().size() - given);
    });
  }
  if (database) {
    list.Check("task", [&] {
      RequireKnownClasses(config.task, *database);
      return config.task.wanted.empty() ? std::string("everything on the table")
                                        : fmt::format("{} classes", config.task.wanted.size());
    });
  }
  if (database && !config.classifier.empty()) {
    list.Check("classifier", [&] {
      const auto classifier = LoadMissionClassifier(config.classifier, *database);
      return fmt::format("{}: {} classes", config.classifier, classifier->classes().size());
    });
  }
  if (const auto* sim = std::get_if<sim::SimConfig>(&config.robot)) {
    if (!list.Check("scene", [&] { return CheckScene(*sim, database); })) return list.Status();
  }
  CheckRobot(config, &list);
  return list.Status();
}

}  // namespace

void AddCheck(CLI::App* app, int* status) {
  CLI::App* check =
      app->add_subcommand("check", "Checks config, models, calibration and devices; moves nothing");
  const auto options = std::make_shared<CheckOptions>();  // outlives this function in the callback
  check->add_option("--config", options->config, "Configuration, YAML")->required();
  check
      ->add_option("--set", options->overrides,
                   "KEY=VALUE, over the configuration; may be repeated")
      ->expected(1)
      ->take_all();
  check->callback([options, status] { *status = RunCheck(*options); });
}

}  // namespace secondlook::apps

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "apps/arm_looks.h"
#include "apps/board_looks.h"
#include "apps/capture.h"
#include "apps/commands/commands.h"
#include "apps/make_robot.h"
#include "apps/run_config.h"
#include "apps/stop_signal.h"
#include "lib/common/error.h"
#include "lib/hal/guard.h"
#include "lib/kinematics/calibrate_hand.h"
#include "lib/kinematics/calibrate_head.h"
#include "lib/kinematics/calibration_file.h"
#include "lib/perception/board.h"
#include "lib/planning/motion/obstacles.h"
#include "lib/world/voxel_space.h"

namespace secondlook::apps {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kSignalStatus = 128;   // plus the signal
constexpr int kRounds = 9;           // the head's angles err anew each time
constexpr int kHandRounds = 5;       // and so does an arm
constexpr int kFewestHandLooks = 3;  // that turn the hand about two axes
constexpr double kNearer = 0.8;      // than where the board fills the image's width
constexpr double kFarther = 1.1;
constexpr int kStride = 2;  // pixels of a depth image that enter the map

struct CalibrateOptions {
  std::string config;
  std::vector<std::string> overrides;
  std::string out;
  perception::Board board;
  std::string board_image;
  double encoder_sigma_deg{0.1};
  bool hand{};
  double arm_sigma_mm{1.0};
  double arm_sigma_deg{0.1};
};

/// The angles from `middle` by steps of `pan` and `tilt`, that the head can reach.
std::vector<hal::PanTiltAngles> Grid(const hal::PanTiltInfo& info, hal::PanTiltAngles middle,
                                     double pan, int pans, double tilt, int tilts) {
  std::vector<hal::PanTiltAngles> grid;
  for (int t = -tilts; t <= tilts; ++t) {
    for (int p = -pans; p <= pans; ++p) {
      const hal::PanTiltAngles angles{middle.pan + p * pan, middle.tilt + t * tilt};
      if (info.Reaches(angles)) grid.push_back(angles);
    }
  }
  return grid;
}

/// The angles at which the board is in the middle of the image.
/// @throws ConfigError when the head sees none, wherever it looks.
hal::PanTiltAngles FindMiddle(const kinematics::HeadCalibration& nominal, hal::Robot* robot,
                              BoardLooks* looks) {
  const hal::PanTiltAngles now = robot->head->State().angles;
  std::vector<hal::PanTiltAngles> places{now};
  for (const auto& place :
       Grid(robot->head->info(), {0.0, 25.0 * kDegree}, 30.0 * kDegree, 3, 25.0 * kDegree, 1)) {
    places.push_back(place);
  }
  for (const hal::PanTiltAngles& place : places) {
    const std::optional<kinematics::BoardView> view = looks->WithHead(place);
    if (!view) continue;
    Eigen::Vector3d middle_P = Eigen::Vector3d::Zero();
    const kinematics::SightedBoard& board = view->board;
    for (const Eigen::Vector3d& p_P : board.points_P) {
      middle_P += p_P / static_cast<double>(board.points_P.size());
    }
    const Pose X_BC = CameraInBase(nominal, view->head);
    const auto angles = kinematics::AimAt(nominal, X_BC * (board.X_CP * middle_P));
    return angles ? hal::PanTiltAngles{angles->pan, angles->tilt} : place;
  }
  Throw<ConfigError>(
      "no board is in sight in {} directions: put it where the head can see it, well lit and large "
      "in the image, and give its --columns, --rows, --square and --marker",
      places.size());
}

void Print(const char* camera, const kinematics::CalibrationResiduals& residuals, const Pose& X_EC,
           const Pose& X_EC_nominal) {
  fmt::print(
      "{}: {} views, {:.2f} px: known to {:.1f} mm and {:.2f} deg; it sits {:.1f} mm and {:.2f} "
      "deg "
      "from where it was taken to be\n",
      camera, residuals.views, residuals.pixels, residuals.millimetres, residuals.degrees,
      1e3 * (X_EC.translation() - X_EC_nominal.translation()).norm(),
      RotationDistance(X_EC.linear(), X_EC_nominal.linear()) / kDegree);
}

/// All that the robot's calibration file says so far, or what it goes by where it has none.
kinematics::Calibration Before(const RobotConfig& config, const ReadyRobot& ready) {
  const std::string& file =
      std::visit([](const auto& robot) -> const std::string& { return robot.calibration; }, config);
  if (!file.empty()) return kinematics::LoadCalibration(file);
  kinematics::Calibration calibration{ready.calibration, {}, {}};
  if (ready.hand) calibration.X_EC = ready.hand->X_EC;
  calibration.X_EL = ready.X_EL;
  return calibration;
}

/// Where the camera on the head sits. The head looks at the board in the end.
kinematics::Calibration CalibrateHeadOf(ReadyRobot* ready, const CalibrateOptions& options,
                                        BoardLooks* looks,
                                        std::vector<kinematics::BoardView>* views) {
  const hal::PanTiltAngles middle = FindMiddle(ready->calibration, &ready->robot, looks);
  const std::vector<hal::PanTiltAngles> grid =
      Grid(ready->robot.head->info(), middle, 20.0 * kDegree, 1, 15.0 * kDegree, 1);
  for (int round = 0; round < kRounds; ++round) {
    for (const hal::PanTiltAngles& angles : grid) {
      std::optional<kinematics::BoardView> view = looks->WithHead(angles);
      if (view) views->push_back(*std::move(view));
    }
  }
  looks->WithHead(middle);
  return CalibrateHead(*views, ready->robot.head_camera->info().model, ready->calibration,
                       options.encoder_sigma_deg * kDegree);
}

/// What the head sees of the space in which the arm is to move, around where it looks now. It looks
/// there again in the end.
world::VoxelSpace MapAround(ReadyRobot* ready, const kinematics::HeadCalibration& calibration,
                            BoardLooks* looks) {
  Capturer capturer(&ready->robot, calibration);
  capturer.KnowArm(*ready->hand);
  world::VoxelSpace space;
  const hal::PanTiltAngles middle = ready->robot.head->State().angles;
  std::vector<hal::PanTiltAngles> around =
      Grid(ready->robot.head->info(), middle, 35.0 * kDegree, 2, 25.0 * kDegree, 2);
  around.push_back(middle);
  for (const hal::PanTiltAngles& angles : around) {
    looks->WithHead(angles);
    const std::optional<Capture> capture = capturer.Take(Seconds(1.0));
    if (capture) space.Insert(capture->frame.depth, capture->camera, capture->X_WC, kStride);
  }
  return space;
}

/// `config` with views from where the board fills the image's width, and a little nearer and
/// farther.
ArmLooksConfig FromWhereItFills(const geometry::CameraModel& camera, const perception::Board& board,
                                ArmLooksConfig config) {
  const double filled = board.columns * board.square * camera.fx / camera.width;
  config.views.inner_distance_m = kNearer * filled;
  config.views.outer_distance_m = kFarther * filled;
  return config;
}

/// @throws ConfigError when the arm can take too few of these looks, with what is in its way.
void RequireLooks(const std::vector<world::Look>& looks) {
  std::map<std::string, int> refused;  // by the check
  std::string unseen;                  // what is in the way of one, where nobody has looked
  for (const world::Look& look : looks) {
    if (look.feasible) continue;
    ++refused[look.checks.back().name];
    const bool unknown =
        look.reason.find(ToString(planning::ObstacleKind::kUnknown)) != look.reason.npos;
    if (unknown) unseen = look.reason;
  }
  auto feasible = static_cast<int>(looks.size());
  std::string counts;
  for (const auto& [check, count] : refused) {
    feasible -= count;
    counts += fmt::format("{}{} refused by '{}'", counts.empty() ? "" : ", ", count, check);
  }
  fmt::print("the arm can take {} of {} looks at the board: {}\n", feasible, looks.size(), counts);
  if (feasible >= kFewestHandLooks) return;
  if (unseen.empty()) unseen = "none by unknown space";
  Throw<ConfigError>(
      "the arm can take {} looks at the board where it is, at least {} are wanted ({}; {}): put "
      "the "
      "board where the arm can reach around it. Space is known to be free where the head's camera "
      "measures something behind it; where a person knows that it is, --set "
      "mission.looks.arm.obstacles.avoid_unknown=false",
      feasible, kFewestHandLooks, counts, unseen);
}

/// Where the camera in the hand sits, from looks that the arm takes at the board, through space
/// that the head has seen to be free.
kinematics::HandCalibration CalibrateHandOf(ReadyRobot* ready, const RunConfig& config,
                                            const CalibrateOptions& options,
                                            const kinematics::HeadCalibration& head,
                                            const std::vector<kinematics::BoardView>& views,
                                            BoardLooks* looks) {
  hal::Robot& robot = ready->robot;
  const world::VoxelSpace space = MapAround(ready, head, looks);
  const Stance stance{robot.base->State().X_WB, robot.head->State().angles, robot.arm->State().q,
                      robot.clock->Now()};
  hal::CameraInfo camera = robot.hand_camera->info();
  camera.has_depth = false;  // which it may be too near for
  ArmLooks arm(FromWhereItFills(camera.model, options.board, config.mission.looks.arm),
               {robot.base->info(), robot.arm->info(), camera, *ready->hand}, stance.q,
               config.seed);
  const auto& workspace = config.safety.limits.arm_workspace;
  if (workspace) arm.KeepWithin(workspace->box_B());
  const Pose X_BC = CameraInBase(head, views.front().head);
  const Eigen::Vector3d p_WP =
      ToPose(stance.X_WB) * X_BC * views.front().board.X_CP *
      Eigen::Vector3d(0.5 * options.board.columns * options.board.square,
                      0.5 * options.board.rows * options.board.square, 0.0);
  const std::vector<world::Look> around =
      arm.Views(p_WP, 0, stance, arm.CollisionAt(stance, space, {}));
  RequireLooks(around);
  std::vector<kinematics::HandView> seen;
  for (int round = 0; round < kHandRounds; ++round) {
    for (const world::Look& look : around) {
      if (!look.feasible) continue;
      looks->MoveArm(look.arm_motion);
      std::optional<kinematics::HandView> view = looks->WithHand();
      if (view) seen.push_back(*std::move(view));
      const Eigen::VectorXd q = robot.arm->State().q;
      arm.Follow(look.arm_motion, q);
      const hal::JointTrajectory folding = arm.Folding(q);
      looks->MoveArm(folding);
      arm.Follow(folding, robot.arm->State().q);
    }
  }
  return CalibrateHand(seen, robot.hand_camera->info().model, ready->hand->arm,
                       {1e-3 * options.arm_sigma_mm, options.arm_sigma_deg * kDegree});
}

int Calibrate(const CalibrateOptions& options) try {
  options.board.Validate();
  if (!options.board_image.empty()) {
    if (!cv::imwrite(options.board_image, perception::DrawBoard(options.board, 200))) {
      Throw<ConfigError>("{}: cannot be written", options.board_image);
    }
    fmt::print("{}: print it {:.3f} m wide\n", options.board_image,
               options.board.columns * options.board.square);
    if (options.config.empty()) return kDone;
  }
  if (options.config.empty() || options.out.empty()) {
    Throw<ConfigError>("give --config and --out, or --board-image alone");
  }
  CatchStopSignals();
  const RunConfig config = LoadRunConfig(options.config, options.overrides);
  hal::Guard guard(config.safety.limits);
  ReadyRobot ready = MakeRobot(config.robot, config.seed);
  if (options.hand && !ready.hand) {
    Throw<ConfigError>("--hand: the robot of {} has no arm with a camera in its hand",
                       options.config);
  }
  ready.robot = guard.Protect(std::move(ready.robot), BoxOfArm(ready));
  BoardLooks looks(&ready.robot, options.board);
  kinematics::Calibration calibration = Before(config.robot, ready);
  std::vector<kinematics::BoardView> views;
  const kinematics::Calibration found = CalibrateHeadOf(&ready, options, &looks, &views);
  calibration.head = found.head;
  calibration.residuals = found.residuals;
  Print("head camera", *calibration.residuals, found.head.X_HC, ready.calibration.X_HC);
  if (options.hand) {
    const kinematics::HandCalibration hand =
        CalibrateHandOf(&ready, config, options, found.head, views, &looks);
    calibration.X_EC = hand.X_EC;
    calibration.hand_residuals = hand.residuals;
    Print("hand camera", hand.residuals, hand.X_EC, ready.hand->X_EC);
  }
  SaveCalibration(calibration, options.out);
  fmt::print("{}: written\n", options.out);
  return kDone;
} catch (const Stopped&) {
  return kSignalStatus + StopSignal();
}

}  // namespace

void AddCalibrate(CLI::App* app, int* status) {
  CLI::App* calibrate = app->add_subcommand(
      "calibrate", "Looks at a ChArUco board and writes where the cameras of head and hand sit");
  const auto options = std::make_shared<CalibrateOptions>();  // outlives this in the callback
  calibrate->add_option("--config", options->config, "Configuration, YAML");
  calibrate
      ->add_option("--set", options->overrides,
                   "KEY=VALUE, over the configuration; may be repeated")
      ->expected(1)
      ->take_all();
  calibrate->add_option("--out", options->out, "Calibration file to write");
  calibrate->add_option("--columns", options->board.columns, "Squares of the board along x")
      ->capture_default_str();
  calibrate->add_option("--rows", options->board.rows, "Squares of the board along y")
      ->capture_default_str();
  calibrate->add_option("--square", options->board.square, "Side of a square [m]")
      ->capture_default_str();
  calibrate->add_option("--marker", options->board.marker, "Side of a marker [m]")
      ->capture_default_str();
  calibrate
      ->add_option("--encoder-sigma-deg", options->encoder_sigma_deg,
                   "By which the head's angles err")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 5.0));
  calibrate->add_flag("--hand", options->hand,
                      "The camera in the arm's hand, too: this moves the arm");
  calibrate
      ->add_option("--arm-sigma-mm", options->arm_sigma_mm,
                   "By which the arm errs, along each axis")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 50.0));
  calibrate->add_option("--arm-sigma-deg", options->arm_sigma_deg, "Likewise, about each axis")
      ->capture_default_str()
      ->check(CLI::Range(0.001, 5.0));
  calibrate->add_option("--board-image", options->board_image,
                        "Picture of the board to write, for printing");
  calibrate->callback([options, status] { *status = Calibrate(*options); });
}

}  // namespace secondlook::apps

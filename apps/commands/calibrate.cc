#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "apps/commands/commands.h"
#include "apps/make_robot.h"
#include "apps/run_config.h"
#include "apps/stop_signal.h"
#include "lib/common/error.h"
#include "lib/kinematics/calibrate_head.h"
#include "lib/kinematics/calibration_file.h"
#include "lib/perception/board.h"

namespace secondlook::apps {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr Duration kPoll = Seconds(0.05);
constexpr Duration kSettle = Seconds(0.3);   // until the head no longer swings
constexpr Duration kPatience = Seconds(20);  // with one motion, and with one frame
constexpr int kSignalStatus = 128;           // plus the signal
constexpr int kRounds = 9;                   // the angles err anew each time

struct CalibrateOptions {
  std::string config;
  std::vector<std::string> overrides;
  std::string out;
  perception::Board board;
  std::string board_image;
  double encoder_sigma_deg{0.1};
};

/// A signal has asked for a stop.
struct Stopped {};

/// The head and its camera, which look at a board that stands still.
class BoardWatcher {
 public:
  BoardWatcher(hal::Robot* robot, const perception::Board& board) : robot_(robot), board_(board) {}

  /// Turns the head to `target` and looks. Empty when the board is not in sight.
  /// @throws DeviceError, Stopped; the robot stands still then.
  std::optional<kinematics::BoardView> LookFrom(const hal::PanTiltAngles& target) {
    Turn(target);
    const Time still = robot_->clock->Now() + kSettle;
    robot_->clock->SleepUntil(still);
    const hal::RgbdFrame frame = Grab(still);
    const hal::PanTiltAngles at = robot_->head->State().angles;
    const auto seen = perception::FindBoard(frame.color, robot_->head_camera->info().model, board_);
    if (!seen) return std::nullopt;
    return kinematics::BoardView{{at.pan, at.tilt}, seen->corners, seen->points_P, seen->X_CP};
  }

 private:
  void Turn(const hal::PanTiltAngles& target) {
    const Time deadline = robot_->clock->Now() + kPatience;
    robot_->head->Start(target);
    hal::MotionStatus status = robot_->head->Status();
    for (; status.phase == hal::MotionPhase::kMoving; status = robot_->head->Status()) {
      if (StopSignal() != 0) {
        robot_->Stop();
        throw Stopped{};
      }
      if (robot_->clock->Now() > deadline) {
        robot_->Stop();
        Throw<DeviceError>("{}: still moving after {} s", robot_->head->info().name,
                           ToSeconds(kPatience));
      }
      robot_->clock->SleepUntil(robot_->clock->Now() + kPoll);
    }
    if (status.phase != hal::MotionPhase::kReached) {
      Throw<DeviceError>("{}: did not turn: {}", robot_->head->info().name, status.reason);
    }
  }

  /// The first frame that was taken after `still`.
  hal::RgbdFrame Grab(Time still) {
    const Time deadline = robot_->clock->Now() + kPatience;
    while (robot_->clock->Now() < deadline) {
      if (StopSignal() != 0) throw Stopped{};
      std::optional<hal::RgbdFrame> frame = robot_->head_camera->Grab(Seconds(1.0));
      if (frame && frame->time >= still) return *std::move(frame);
    }
    Throw<DeviceError>("camera '{}': no new frame in {} s", robot_->head_camera->info().name,
                       ToSeconds(kPatience));
  }

  hal::Robot* robot_;
  const perception::Board& board_;
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
                              BoardWatcher* watcher) {
  const hal::PanTiltAngles now = robot->head->State().angles;
  std::vector<hal::PanTiltAngles> places{now};
  for (const auto& place :
       Grid(robot->head->info(), {0.0, 25.0 * kDegree}, 30.0 * kDegree, 3, 25.0 * kDegree, 1)) {
    places.push_back(place);
  }
  for (const hal::PanTiltAngles& place : places) {
    const std::optional<kinematics::BoardView> view = watcher->LookFrom(place);
    if (!view) continue;
    Eigen::Vector3d middle_P = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p_P : view->points_P) {
      middle_P += p_P / static_cast<double>(view->points_P.size());
    }
    const Pose X_BC = CameraInBase(nominal, view->head);
    const auto angles = kinematics::AimAt(nominal, X_BC * (view->X_CP * middle_P));
    return angles ? hal::PanTiltAngles{angles->pan, angles->tilt} : place;
  }
  Throw<ConfigError>(
      "no board is in sight in {} directions: put it where the head can see it, well lit and large "
      "in the image, and give its --columns, --rows, --square and --marker",
      places.size());
}

void PrintResult(const kinematics::Calibration& calibration,
                 const kinematics::HeadCalibration& nominal) {
  const Pose& X_HC = calibration.head.X_HC;
  const kinematics::CalibrationResiduals& residuals = *calibration.residuals;
  fmt::print(
      "{} views, {:.2f} px: known to {:.1f} mm and {:.2f} deg\n"
      "the camera sits {:.1f} mm and {:.2f} deg from where it was taken to be\n",
      residuals.views, residuals.pixels, residuals.millimetres, residuals.degrees,
      1e3 * (X_HC.translation() - nominal.X_HC.translation()).norm(),
      RotationDistance(X_HC.linear(), nominal.X_HC.linear()) / kDegree);
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
  ReadyRobot ready = MakeRobot(config.robot, config.seed);
  BoardWatcher watcher(&ready.robot, options.board);
  const hal::PanTiltAngles middle = FindMiddle(ready.calibration, &ready.robot, &watcher);
  std::vector<kinematics::BoardView> views;
  const std::vector<hal::PanTiltAngles> grid =
      Grid(ready.robot.head->info(), middle, 20.0 * kDegree, 1, 15.0 * kDegree, 1);
  for (int round = 0; round < kRounds; ++round) {
    for (const hal::PanTiltAngles& angles : grid) {
      std::optional<kinematics::BoardView> view = watcher.LookFrom(angles);
      if (view) views.push_back(*std::move(view));
    }
  }
  const kinematics::Calibration calibration =
      CalibrateHead(views, ready.robot.head_camera->info().model, ready.calibration,
                    options.encoder_sigma_deg * kDegree);
  PrintResult(calibration, ready.calibration);
  SaveCalibration(calibration, options.out);
  fmt::print("{}: written\n", options.out);
  return kDone;
} catch (const Stopped&) {
  return kSignalStatus + StopSignal();
}

}  // namespace

void AddCalibrate(CLI::App* app, int* status) {
  CLI::App* calibrate = app->add_subcommand(
      "calibrate", "Turns the head before a ChArUco board and writes where its camera sits");
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
  calibrate->add_option("--board-image", options->board_image,
                        "Picture of the board to write, for printing");
  calibrate->callback([options, status] { *status = Calibrate(*options); });
}

}  // namespace secondlook::apps

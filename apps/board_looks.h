#pragma once

#include <functional>
#include <optional>
#include <string>

#include "lib/hal/robot.h"
#include "lib/kinematics/calibrate_hand.h"
#include "lib/kinematics/calibrate_head.h"
#include "lib/perception/board.h"

namespace secondlook::apps {

/// A signal has asked for a stop; the robot stands still.
struct Stopped {};

/// Looks at a calibration board that stands still, by the head's camera and the hand's.
/// What moves the robot throws DeviceError for a motion that fails or takes too long, a device that
/// is lost or a camera without frames, and Stopped; the robot stands still then.
class BoardLooks {
 public:
  /// `robot` must outlive this.
  BoardLooks(hal::Robot* robot, const perception::Board& board) : robot_(robot), board_(board) {}

  /// Turns the head to `target` and looks. Empty when the board is not in sight.
  std::optional<kinematics::BoardView> WithHead(const hal::PanTiltAngles& target);

  /// Looks with the hand's camera from where the arm stands. Empty when the board is not in sight.
  std::optional<kinematics::HandView> WithHand();

  /// Moves the arm along `trajectory`, which may be empty.
  void MoveArm(const hal::JointTrajectory& trajectory);

 private:
  void Complete(const std::string& device, Duration patience,
                const std::function<hal::MotionStatus()>& ask);
  std::optional<kinematics::SightedBoard> Sight(hal::Camera* camera, Time still);
  Time Settle();

  hal::Robot* robot_;
  perception::Board board_;
};

}  // namespace secondlook::apps

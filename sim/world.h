#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/pose.h"
#include "lib/common/time.h"
#include "lib/kinematics/head.h"
#include "sim/arm_contact.h"
#include "sim/arm_drive.h"
#include "sim/base_drive.h"
#include "sim/fixtures.h"
#include "sim/head_drive.h"
#include "sim/noise.h"
#include "sim/scene.h"
#include "sim/striper_drive.h"
#include "sim/surroundings.h"
#include "sim/walker.h"

namespace secondlook::sim {

/// The truth at one instant.
struct WorldState {
  Time time{};
  Pose2 X_WB;                                ///< Of the base.
  kinematics::HeadAngles head;               ///< Where the head truly points.
  std::vector<Eigen::Vector2d> obstacles_W;  ///< Centres of the moving obstacles [m].
  Eigen::VectorXd arm;                       ///< Joint angles [rad]; empty: it has no arm.
  Pose hand_X_BC{Pose::Identity()};          ///< Where its hand camera truly is, in the base.
};

/// The base or the arm touched something, or something touched it.
struct Collision {
  Time time{};                        ///< When the contact began.
  std::string name;                   ///< With what.
  Eigen::Vector2d point_W{0.0, 0.0};  ///< Where [m].
  double base_speed{};                ///< Of the base at that moment [m/s].
  bool arm{};                         ///< It was the arm; false: the base.
};

/// What the camera truly was like when it took a frame.
struct TrueView {
  std::uint64_t sequence{};  ///< Of the frame.
  Pose X_WC{Pose::Identity()};
  WorldState state;
};

/// The simulated world: the room, what moves in it, and the robot as it truly is. It moves on only
/// in steps of kStep, in one fixed order (moving obstacles, base, head, arm, striper, collisions),
/// and depends on nothing but the scene, the noise, the seed and the commands. Threading: Now() and
/// the RequestStop() of the drives from any thread, the rest from one.
class World {
 public:
  static constexpr Duration kStep = Seconds(0.01);

  /// `nominal` is what the calibration file says; the true camera sits a little beside it.
  /// @throws ConfigError naming the object whose mesh cannot be read.
  World(const Scene& scene, const NoiseConfig& noise, const kinematics::HeadCalibration& nominal,
        std::uint64_t seed, const std::optional<ArmSetup>& arm = std::nullopt);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  Time Now() const { return Time(Duration(now_.load())); }

  /// Moves on by kStep.
  void Step();

  /// The truth at the last step not after `time`, of the last half second at most.
  const WorldState& StateAt(Time time) const;

  /// The true pose of the camera on the head in `state`.
  Pose CameraPose(const WorldState& state) const;
  /// The true pose of the camera on the arm. @pre there is an arm.
  Pose HandCameraPose(const WorldState& state) const;

  BaseDrive& base() { return base_; }
  HeadDrive& head() { return head_; }
  const BaseDrive& base() const { return base_; }
  /// Null when the robot has none.
  ArmDrive* arm() { return arm_ ? &*arm_ : nullptr; }
  const ArmDrive* arm() const { return arm_ ? &*arm_ : nullptr; }
  /// Likewise.
  StriperDrive* striper() { return striper_ ? &*striper_ : nullptr; }

  const Scene& scene() const { return scene_; }
  const std::vector<PlacedObject>& objects() const { return objects_; }
  const std::vector<Fixture>& fixtures() const { return fixtures_; }
  const NoiseConfig& noise() const { return noise_; }
  const std::vector<Collision>& collisions() const { return collisions_; }
  const std::vector<TrueView>& views() const { return views_; }
  const std::vector<TrueView>& hand_views() const { return hand_views_; }

  /// For the cameras: keeps what a frame truly shows, for the judge.
  void Record(TrueView view) { views_.push_back(std::move(view)); }
  void RecordHand(TrueView view) { hand_views_.push_back(std::move(view)); }

 private:
  Disc RobotDisc() const;
  void FindCollisions();
  void FindArmCollisions();
  void KeepState();

  Scene scene_;
  NoiseConfig noise_;
  std::vector<PlacedObject> objects_;
  std::vector<Fixture> fixtures_;
  kinematics::HeadCalibration true_calibration_;
  Surroundings surroundings_;
  std::vector<Walker> walkers_;
  BaseDrive base_;
  HeadDrive head_;
  std::optional<ArmDrive> arm_;
  std::optional<StriperDrive> striper_;
  std::optional<ArmContact> arm_contact_;
  std::atomic<Duration::rep> now_{0};
  std::deque<WorldState> states_;
  std::vector<std::string> touching_;      // what the base touches now
  std::vector<std::string> arm_touching_;  // what the arm touches now
  std::vector<Collision> collisions_;
  std::vector<TrueView> views_;       // of the head's camera
  std::vector<TrueView> hand_views_;  // of the hand's
};

}  // namespace secondlook::sim

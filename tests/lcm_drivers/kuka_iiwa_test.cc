// A KUKA iiwa, through the messages of drake-iiwa-driver, which is emulated on the same link.

#include "lib/hal/drivers/kuka_iiwa.h"

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include <poll.h>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/transport/schema.h"
#include "tests/hal/arm_contract.h"
#include "tests/lcm_drivers/iiwa_emulator.h"
#include "tests/support/expect_throws.h"

#include "drake/lcmt_iiwa_status.hpp"
#include "second_look/base_cancel_t.hpp"

namespace secondlook::hal {
namespace {

constexpr const char* kTick = "TICK";

Eigen::VectorXd Home() {
  Eigen::VectorXd q(7);
  q << 0.1, 0.5, 0.0, -1.2, 0.2, 0.9, -0.3;
  return q;
}

/// The beat of an emulated arm. Whoever sleeps lets it beat, and waits after each beat until all
/// that was sent, and what that was answered by, has been heard.
class BeatingClock : public Clock {
 public:
  explicit BeatingClock(LcmLink* link) : link_(link), arm_(link, this, Home()) {
    link_->Listen(kTick, {"second_look.base_cancel_t", {}}, [this](const auto&) {
      ++heard_;
      heard_.notify_all();
    });
  }

  Time Now() const override { return Time(Duration(now_)); }
  void SleepUntil(Time time) override {
    while (Now() < time) {
      now_ += IiwaEmulator::kBeat.count();
      arm_.Step();
      Hear();
      Hear();
    }
  }
  void ChargeThinking(Duration) override {}

  IiwaEmulator& arm() { return arm_; }

  void Hear() {
    second_look::base_cancel_t tick{};
    link_->Publish(transport::Pack(kTick, tick));
    ++sent_;
    for (int heard = heard_; heard < sent_; heard = heard_) heard_.wait(heard);
  }

 private:
  LcmLink* link_;
  std::atomic<Duration::rep> now_{1'000'000'000};
  IiwaEmulator arm_;
  int sent_{};
  std::atomic<int> heard_{0};
};

/// A driver and the arm it speaks with.
struct Driven {
  std::shared_ptr<LcmLink> link = std::make_shared<LcmLink>("memq://");
  BeatingClock clock{link.get()};
  std::unique_ptr<KukaIiwa> arm;

  Driven() {
    // Somebody has to speak while the driver waits for a first status.
    std::atomic<bool> connected{false};
    std::thread speaker([&] {
      while (!connected) {
        clock.arm().Step();
        poll(nullptr, 0, 1);
      }
    });
    arm = std::make_unique<KukaIiwa>(KukaIiwaConfig{}, link, &clock);
    connected = true;
    speaker.join();
    clock.Hear();
  }
  ~Driven() {
    arm.reset();
    clock.Hear();
  }

  void Wait(double seconds) { clock.SleepUntil(clock.Now() + Seconds(seconds)); }

  /// From rest where it is to rest with its first joint turned by `turn`, in `seconds`.
  JointTrajectory Turn(double turn, double seconds) const {
    const Eigen::VectorXd q = arm->State().q;
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(7);
    Eigen::VectorXd goal = q;
    goal[0] += turn;
    return {{{0.0, q, rest}, {seconds, goal, rest}}};
  }

  MotionStatus WaitForEnd() {
    while (arm->Status().phase == MotionPhase::kMoving) Wait(0.02);
    return arm->Status();
  }
};

const auto kName = [](const auto& info) { return info.param.name; };

INSTANTIATE_TEST_SUITE_P(KukaIiwa, ArmContract,
                         ::testing::Values(ArmFactory{
                             "Emulated",
                             [] {
                               const auto driven = std::make_shared<Driven>();
                               return ArmRig{&driven->clock, driven->arm.get(), driven};
                             }}),
                         kName);

TEST(KukaIiwa, CommandsNothingBeforeItIsToMoveAndHoldsItAfterwards) {
  Driven driven;
  driven.Wait(0.5);
  EXPECT_EQ(driven.clock.arm().commands(), 0);
  driven.arm->Start(driven.Turn(0.2, 1.0));
  ASSERT_EQ(driven.WaitForEnd().phase, MotionPhase::kReached);
  const int commands = driven.clock.arm().commands();
  driven.Wait(0.5);
  EXPECT_EQ(driven.clock.arm().commands(), commands + 100);  // 200 a second
}

TEST(KukaIiwa, NeverCommandsAJump) {
  Driven driven;
  // Begins 0.9 degrees beside where the arm is, which a trajectory may.
  JointTrajectory beside = driven.Turn(0.3, 1.5);
  for (JointKnot& knot : beside.knots) knot.q.array() += 0.9 / 180.0 * M_PI;
  driven.arm->Start(beside);
  EXPECT_EQ(driven.WaitForEnd().phase, MotionPhase::kReached);
  // At 0.3 rad/s on average a beat of 5 ms is 0.0015 rad, and twice that at its fastest.
  EXPECT_LT(driven.clock.arm().longest_jump(), 0.004);
}

TEST(KukaIiwa, EndsItsMotionWhenNoStatusComes) {
  Driven driven;
  driven.arm->Start(driven.Turn(0.5, 2.0));
  driven.Wait(0.5);
  driven.clock.arm().Set(IiwaFault::kSilent);
  driven.Wait(0.2);
  const MotionStatus status = driven.arm->Status();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_NE(status.reason.find("no status on IIWA_STATUS of memq:// for 0.1 s: is drake-iiwa-dr"),
            std::string::npos)
      << status.reason;
  EXPECT_THROWS(driven.arm->State(), DeviceError, "no status on IIWA_STATUS");
  const int commands = driven.clock.arm().commands();
  driven.Wait(0.2);
  EXPECT_EQ(driven.clock.arm().commands(), commands);
}

TEST(KukaIiwa, DoesNotGoOnByItselfWhenTheStatusIsBack) {
  Driven driven;
  driven.arm->Start(driven.Turn(0.5, 2.0));
  driven.Wait(0.5);
  driven.clock.arm().Set(IiwaFault::kSilent);
  driven.Wait(0.2);
  driven.clock.arm().Set(IiwaFault::kNone);
  driven.Wait(0.1);
  EXPECT_EQ(driven.arm->Status().phase, MotionPhase::kFailed);
  const Eigen::VectorXd q = driven.clock.arm().q();
  driven.Wait(0.5);
  EXPECT_LT((driven.clock.arm().q() - q).cwiseAbs().maxCoeff(), 1e-3);
  driven.arm->Start(driven.Turn(0.1, 1.0));
  EXPECT_EQ(driven.WaitForEnd().phase, MotionPhase::kReached);
}

TEST(KukaIiwa, GivesUpWhenSomethingIsInItsWay) {
  Driven driven;
  driven.clock.arm().Set(IiwaFault::kBlocked);
  driven.arm->Start(driven.Turn(0.5, 2.0));
  const MotionStatus status = driven.WaitForEnd();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_NE(status.reason.find("joint_1 is 5."), std::string::npos) << status.reason;
  EXPECT_NE(status.reason.find("is something in its way"), std::string::npos);
}

TEST(KukaIiwa, RefusesTheStatusOfAnotherArm) {
  Driven driven;
  drake::lcmt_iiwa_status status{};
  status.num_joints = 1;
  for (auto* values :
       {&status.joint_position_measured, &status.joint_velocity_estimated,
        &status.joint_position_commanded, &status.joint_position_ipo, &status.joint_torque_measured,
        &status.joint_torque_commanded, &status.joint_torque_external}) {
    values->push_back(0.0);
  }
  driven.clock.arm().Set(IiwaFault::kSilent);
  driven.Wait(0.2);
  driven.link->Publish(transport::Pack("IIWA_STATUS", status));
  driven.clock.Hear();
  EXPECT_THROWS(driven.arm->State(), DeviceError,
                "a status of 1 joints, and it has 7: is it another arm's?");
}

TEST(KukaIiwa, HasTheMessagesOfDrake) {
  // The fingerprints of the Python package drake 1.51.
  const transport::Schema& ours = transport::Schema::Messages();
  EXPECT_EQ(ours.Fingerprint("drake.lcmt_iiwa_command"), 0xddc7c7738c815334U);
  EXPECT_EQ(ours.Fingerprint("drake.lcmt_iiwa_status"), 0xf16fb804284abca3U);
}

TEST(KukaIiwaConfig, RefusesValuesOutOfRange) {
  KukaIiwaConfig config;
  config.limit_deg.pop_back();
  EXPECT_THROWS(config.Validate(), ConfigError, "'limit_deg' has 6 values; an iiwa has 7 joints");
  config = {};
  config.speed_deg[2] = 0.0;
  EXPECT_THROWS(config.Validate(), ConfigError, "'speed_deg' = 0 must lie in 0.1..360");
  config = {};
  config.patience_seconds = 5.0;
  EXPECT_THROWS(config.Validate(), ConfigError, "'patience_seconds' = 5 must lie in 0.02..1");
}

}  // namespace
}  // namespace secondlook::hal

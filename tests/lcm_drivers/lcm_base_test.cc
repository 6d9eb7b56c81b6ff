// A base behind LCM, driven by a stand-in for its navigation stack on the same link.

#include "lib/hal/drivers/lcm_base.h"

#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <thread>

#include <poll.h>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/hal/drivers/fixed_base.h"
#include "lib/hal/drivers/fixed_head.h"
#include "sim/sim_robot.h"
#include "tests/hal/base_contract.h"
#include "tests/lcm_drivers/base_follower.h"
#include "tests/sim/rig.h"
#include "tests/support/expect_throws.h"

#include "second_look/base_cancel_t.hpp"

namespace secondlook::hal {
namespace {

constexpr const char* kTick = "TICK";

/// The clock of a simulated robot whose base is on the other side of LCM. Whoever sleeps steps the
/// world, and after each step waits until all that was sent has been heard.
class FollowerClock : public Clock {
 public:
  FollowerClock(sim::SimulatedRobot* simulated, LcmLink* link)
      : simulated_(simulated),
        link_(link),
        follower_(link, simulated->robot.base.get(), simulated->robot.clock.get()) {
    link_->Listen(kTick, {"second_look.base_cancel_t", {}}, [this](const auto&) {
      ++heard_;
      heard_.notify_all();
    });
  }

  Time Now() const override { return simulated_->world->Now(); }
  void SleepUntil(Time time) override {
    while (Now() < time) {
      Hear();
      for (int i = 0; i < 2; ++i) simulated_->world->Step();
      follower_.Step();
      Hear();
    }
  }
  void ChargeThinking(Duration) override {}

  BaseFollower& follower() { return follower_; }

  /// Waits until all that was sent has been heard: messages come in the order they were sent in.
  void Hear() {
    second_look::base_cancel_t tick{};
    link_->Publish(transport::Pack(kTick, tick));
    ++sent_;
    for (int heard = heard_; heard < sent_; heard = heard_) heard_.wait(heard);
  }

 private:
  sim::SimulatedRobot* simulated_;
  LcmLink* link_;
  BaseFollower follower_;
  int sent_{};
  std::atomic<int> heard_{0};
};

LcmBaseConfig Config() {
  LcmBaseConfig config;
  config.speed = 1.0;  // the simulated one stays below
  return config;
}

/// A driver and the base it speaks with, in the simulated world.
struct Driven {
  std::shared_ptr<sim::SimulatedRobot> simulated =
      sim::MakeShared(sim::FreeScene(), sim::NoiseConfig::None(), 1);
  std::shared_ptr<LcmLink> link = std::make_shared<LcmLink>("memq://");
  FollowerClock clock{simulated.get(), link.get()};
  std::unique_ptr<LcmBase> base;

  Driven() {
    // Somebody has to speak while the driver waits for a first pose.
    std::atomic<bool> connected{false};
    std::thread speaker([&] {
      while (!connected) {
        clock.follower().Step();
        poll(nullptr, 0, 1);
      }
    });
    base = std::make_unique<LcmBase>(Config(), link, &clock);
    connected = true;
    speaker.join();
    clock.Hear();
  }
  ~Driven() {
    base.reset();
    clock.Hear();  // that it is to stop
  }

  void Wait(double seconds) { clock.SleepUntil(clock.Now() + Seconds(seconds)); }

  Pose2 Ahead(double metres) const {
    const Pose2 X_WB = base->State().X_WB;
    return {X_WB.x + metres * std::cos(X_WB.yaw), X_WB.y + metres * std::sin(X_WB.yaw), X_WB.yaw};
  }

  MotionStatus WaitForEnd() {
    while (base->Status().phase == MotionPhase::kMoving) Wait(0.05);
    return base->Status();
  }
};

const auto kName = [](const auto& info) { return info.param.name; };

INSTANTIATE_TEST_SUITE_P(Lcm, BaseContract,
                         ::testing::Values(BaseFactory{
                             "Follower",
                             [] {
                               const auto driven = std::make_shared<Driven>();
                               return BaseRig{&driven->clock, driven->base.get(), driven};
                             }}),
                         kName);

TEST(LcmBase, RenewsItsGoalForAsLongAsSomebodyAsksHowFarItIs) {
  Driven driven;
  driven.base->Start({{driven.Ahead(1.2)}});
  for (int i = 0; i < 42; ++i) {
    driven.Wait(0.05);
    driven.base->Status();
  }
  // At the start and then every 0.25 s of 2 s; the last was heard in the tenth of a second since.
  EXPECT_EQ(driven.clock.follower().goals_heard(), 9);
}

TEST(LcmBase, StandsStillWhenNobodyAsksHowFarItIs) {
  Driven driven;
  driven.base->Start({{driven.Ahead(2.0)}});
  driven.Wait(4.0);  // more than valid_seconds, less than the way takes
  const Pose2 X_WB = driven.simulated->world->base().truth();
  driven.Wait(1.0);
  EXPECT_EQ(driven.simulated->world->base().truth(), X_WB);
  const MotionStatus status = driven.base->Status();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_NE(status.reason.find("has given up the goal unasked"), std::string::npos);
}

TEST(LcmBase, StopsTheBaseAtTheEnd) {
  Driven driven;
  driven.base->Start({{driven.Ahead(1.2)}});
  driven.Wait(1.0);
  driven.base.reset();
  driven.Wait(1.0);
  EXPECT_TRUE(driven.simulated->world->base().stands());
}

TEST(LcmBase, FailsWithWhatItsNavigationSays) {
  Driven driven;
  driven.clock.follower().Set(FollowerFault::kGivesUp);
  driven.base->Start({{driven.Ahead(1.2)}});
  const MotionStatus status = driven.WaitForEnd();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_EQ(status.reason, "base: no way round");
}

TEST(LcmBase, DoesNotTakeAGoalForReachedThatIsNot) {
  Driven driven;
  driven.clock.follower().Set(FollowerFault::kStopsShort);
  driven.base->Start({{driven.Ahead(1.2)}});
  const MotionStatus status = driven.WaitForEnd();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_NE(status.reason.find("says that it has reached its goal ("), std::string::npos)
      << status.reason;
}

TEST(LcmBase, FailsWhenNobodyAnswers) {
  Driven driven;
  driven.clock.follower().Set(FollowerFault::kSilent);
  driven.base->Start({{driven.Ahead(1.2)}});
  const MotionStatus status = driven.WaitForEnd();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_NE(status.reason.find("no answer on BASE_STATUS to its goal for 1 s: is the navigation"),
            std::string::npos)
      << status.reason;
}

TEST(LcmBase, SaysWhenAStopIsNotAnswered) {
  Driven driven;
  driven.base->Start({{driven.Ahead(1.2)}});
  driven.Wait(0.3);
  driven.clock.follower().Set(FollowerFault::kSilent);
  driven.base->Stop();
  const MotionStatus status = driven.WaitForEnd();
  EXPECT_EQ(status.phase, MotionPhase::kFailed);
  EXPECT_NE(status.reason.find("no answer on BASE_STATUS to its stop"), std::string::npos);
}

TEST(LcmBase, IsLostWithoutAPoseAndBackWithOne) {
  Driven driven;
  driven.clock.follower().Set(FollowerFault::kNoPose);
  driven.Wait(1.1);
  EXPECT_THROWS(driven.base->State(), DeviceError,
                "base 'base': no pose on BASE_POSE of memq:// for 1 s: is localisation running");
  EXPECT_THROWS(driven.base->Start({{Pose2{}}}), DeviceError, "no pose on BASE_POSE");
  driven.base->Stop();  // possible all the same
  driven.clock.follower().Set(FollowerFault::kNone);
  driven.Wait(0.1);
  EXPECT_NO_THROW(driven.base->State());
}

TEST(LcmBase, IsNotThereWithoutAPose) {
  Driven driven;
  const auto silent = std::make_shared<LcmLink>("memq://");
  LcmBaseConfig config = Config();
  config.patience_seconds = 0.1;
  EXPECT_THROWS(LcmBase(config, silent, &driven.clock), DeviceError,
                "no pose on BASE_POSE of memq:// for 0.1 s");
}

TEST(LcmBaseConfig, RefusesValuesOutOfRange) {
  LcmBaseConfig config;
  config.valid_seconds = 0.3;
  EXPECT_THROWS(config.Validate(), ConfigError, "'valid_seconds' = 0.3 must lie in 0.5..60");
  config = {};
  config.name.clear();
  EXPECT_THROWS(config.Validate(), ConfigError, "'name' is empty");
}

TEST(FixedHead, LooksWhereItWasFixedAndNowhereElse) {
  const auto simulated = sim::MakeShared(sim::FreeScene(), sim::NoiseConfig::None(), 1);
  FixedHead head({10.0, 25.0}, simulated->robot.clock.get());
  head.Start(head.State().angles);
  EXPECT_EQ(head.Status().phase, MotionPhase::kReached);
  EXPECT_THROWS(head.Start({}), InvalidArgument, "it is fixed at pan 10.00, tilt 25.00 deg");
  EXPECT_THROWS(FixedHead({0.0, 100.0}, simulated->robot.clock.get()), ConfigError,
                "'tilt_deg' = 100 must lie in -90..90");
}

TEST(FixedBase, StandsWhereItWasPutAndSaysThatItCannotDrive) {
  const auto simulated = sim::MakeShared(sim::FreeScene(), sim::NoiseConfig::None(), 1);
  FixedBaseConfig config;
  config.x = 1.0;
  config.yaw_deg = 90.0;
  FixedBase base(config, simulated->robot.clock.get());
  EXPECT_EQ(base.State().X_WB.x, 1.0);
  EXPECT_NEAR(base.State().X_WB.yaw, M_PI / 2.0, 1e-12);
  base.Start({{base.State().X_WB}});
  EXPECT_EQ(base.Status().phase, MotionPhase::kReached);
  base.Start({{Pose2{2.0, 0.0, 0.0}}});
  EXPECT_EQ(base.Status().phase, MotionPhase::kFailed);
  EXPECT_EQ(
      base.Status().reason,
      "base: it is fixed, and cannot drive from (1.00, 0.00) m, 90 deg to (2.00, 0.00) m, 0 deg");
  EXPECT_THROWS(base.Start({}), InvalidArgument, "no waypoint");
}

}  // namespace
}  // namespace secondlook::hal

#include "tests/lcm_drivers/iiwa_emulator.h"

#include <algorithm>
#include <cmath>

#include "lib/hal/drivers/sender_time.h"

#include "drake/lcmt_iiwa_command.hpp"
#include "drake/lcmt_iiwa_status.hpp"

namespace secondlook::hal {
namespace {

constexpr double kFastest = 2.5;  // [rad/s] of any joint

}  // namespace

IiwaEmulator::IiwaEmulator(LcmLink* link, const Clock* clock, const Eigen::VectorXd& q)
    : link_(link), clock_(clock), q_(q) {
  link_->Listen("IIWA_COMMAND", {"drake.lcmt_iiwa_command", {}}, [this](const auto& message) {
    const auto command = transport::Decode<drake::lcmt_iiwa_command>(message);
    const std::scoped_lock lock(mutex_);
    command_ = Eigen::Map<const Eigen::VectorXd>(command.joint_position.data(),
                                                 std::ssize(command.joint_position));
    ++commands_;
  });
}

int IiwaEmulator::commands() const {
  const std::scoped_lock lock(mutex_);
  return commands_;
}

void IiwaEmulator::Step() {
  std::optional<Eigen::VectorXd> command;
  {
    const std::scoped_lock lock(mutex_);
    command = command_;
  }
  const double most = kFastest * ToSeconds(kBeat);
  if (command && command->size() == q_.size()) {
    longest_jump_ = std::max(longest_jump_, (*command - q_).cwiseAbs().maxCoeff());
    if (fault_ != IiwaFault::kBlocked) {
      q_ += (*command - q_).cwiseMax(-most).cwiseMin(most);
    }
  }
  if (fault_ == IiwaFault::kSilent) return;
  drake::lcmt_iiwa_status status{};
  status.utime = Microseconds(clock_->Now());
  status.num_joints = static_cast<std::int32_t>(q_.size());
  const std::vector<double> measured(q_.data(), q_.data() + q_.size());
  const std::vector<double> zeros(measured.size(), 0.0);
  status.joint_position_measured = measured;
  status.joint_position_commanded = measured;
  status.joint_position_ipo = measured;
  status.joint_velocity_estimated = zeros;
  status.joint_torque_measured = zeros;
  status.joint_torque_commanded = zeros;
  status.joint_torque_external = zeros;
  link_->Publish(transport::Pack("IIWA_STATUS", status));
}

}  // namespace secondlook::hal

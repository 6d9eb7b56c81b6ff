#pragma once

#include <mutex>
#include <optional>

#include <Eigen/Core>

#include "lib/common/clock.h"
#include "lib/hal/drivers/lcm_link.h"

namespace secondlook::hal {

/// What goes wrong at an arm.
enum class IiwaFault {
  kNone,
  kSilent,   ///< No status comes.
  kBlocked,  ///< It does not move.
};

/// A KUKA LBR iiwa and drake-iiwa-driver before it: follows the positions that it is told, each at
/// most as fast as it can, and holds the last one.
class IiwaEmulator {
 public:
  static constexpr Duration kBeat = Seconds(0.005);

  /// @param link, clock Not null; outlive this, and nothing comes from the link afterwards.
  IiwaEmulator(LcmLink* link, const Clock* clock, const Eigen::VectorXd& q);

  void Set(IiwaFault fault) { fault_ = fault; }

  /// Moves on by a beat, and tells where it is.
  void Step();

  const Eigen::VectorXd& q() const { return q_; }
  /// The farthest that a command was from where it was [rad]: the real one refuses a jump.
  double longest_jump() const { return longest_jump_; }
  int commands() const;

 private:
  LcmLink* link_;
  const Clock* clock_;
  Eigen::VectorXd q_;
  IiwaFault fault_{IiwaFault::kNone};
  double longest_jump_{};

  mutable std::mutex mutex_;  // of what follows
  std::optional<Eigen::VectorXd> command_;
  int commands_{};
};

}  // namespace secondlook::hal

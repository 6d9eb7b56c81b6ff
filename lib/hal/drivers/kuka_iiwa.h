#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lib/common/clock.h"
#include "lib/hal/arm.h"
#include "lib/hal/drivers/lcm_link.h"

namespace secondlook::hal {

struct KukaIiwaConfig {
  static constexpr const char* kTag = "KukaIiwa";

  std::string name{"iiwa"};
  /// Of each joint, base to tip, a little inside what an LBR iiwa 14 R820 can do.
  std::vector<double> limit_deg{168.0, 118.0, 168.0, 118.0,
                                168.0, 118.0, 173.0};                          ///< To each side.
  std::vector<double> speed_deg{80.0, 80.0, 95.0, 70.0, 125.0, 130.0, 130.0};  ///< A second.
  double acceleration_deg{150.0};  ///< Of every joint [deg/s^2].
  double patience_seconds{0.1};    ///< Without a status for so long it is lost.
  double max_lag_deg{5.0};         ///< A joint that lags more behind its command is held up.

  template <class A>
  void Serialize(A* a) {
    a->Visit("name", &name);
    a->Visit("limit_deg", &limit_deg);
    a->Visit("speed_deg", &speed_deg);
    a->Visit("acceleration_deg", &acceleration_deg);
    a->Visit("patience_seconds", &patience_seconds);
    a->Visit("max_lag_deg", &max_lag_deg);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A KUKA LBR iiwa behind drake-iiwa-driver, which sends IIWA_STATUS 200 times a second and takes
/// IIWA_COMMAND. Every status is answered with the next position of the trajectory, so the arm is
/// led by its own beat: a status that is late makes it slower and never faster, and one that does
/// not come for patience_seconds ends the motion. Nothing is commanded before the first Start();
/// after it the arm is held where it was led to.
class KukaIiwa : public Arm {
 public:
  /// Waits for the first status.
  /// @param link Not null. Of its own: what shares it is waited for.
  /// @param clock Not null; outlives both this and the link.
  /// @throws ConfigError; DeviceError naming the arm when no status came, or one of another arm.
  KukaIiwa(const KukaIiwaConfig& config, std::shared_ptr<LcmLink> link, const Clock* clock);
  /// Brakes, then commands nothing any more: the arm's own driver holds it.
  ~KukaIiwa() override;

  const ArmInfo& info() const override { return info_; }
  ArmState State() override;
  void Start(const JointTrajectory& trajectory) override;
  MotionStatus Status() override;
  void Stop() noexcept override;

 private:
  class Servo;

  ArmInfo info_;
  const std::shared_ptr<LcmLink> link_;
  std::shared_ptr<Servo> servo_;  ///< The link keeps it, too.
};

}  // namespace secondlook::hal

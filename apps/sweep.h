#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/drive.h"
#include "lib/hal/robot.h"
#include "lib/kinematics/chain.h"
#include "lib/perception/striped_scan.h"
#include "lib/planning/motion/plan_sweep.h"
#include "lib/world/range_scan.h"

namespace secondlook::apps {

/// What a sweep brought.
struct Swept {
  world::RangeScan scan;          ///< As far as it came; may be empty.
  int lines{};                    ///< In the scan.
  std::uint64_t lost{};           ///< Lines that were measured and never came.
  std::uint64_t without_place{};  ///< Lines that came, and it is not known from where: not in the
                                  ///< scan.
  DriveOutcome motion;            ///< How the arm's motion ended.
};

/// Where the laser is on the robot.
struct LaserMount {
  kinematics::Chain arm;
  Pose X_EL{Pose::Identity()};  ///< Calibration of the laser on the end-effector.
};

/// Moves the arm to where `plan` begins, then along its sweep with the laser on, and makes a scan
/// of the lines that come, each with where the arm was at its own time. Stopped on the way, by
/// `stop` or by somebody else, or failing, it keeps the scan up to there and says so. The laser is
/// off before the sweep, after it, and whatever is thrown.
/// @param X_WB Of the base, which stands still.
/// @pre plan.outcome is kFound; robot has arm and striper.
/// @throws DeviceError when a device is lost; everything is stopped before.
Swept RunSweep(const planning::PlannedSweep& plan, const LaserMount& mount, const Pose& X_WB,
               const StopRequest& stop, hal::Robot* robot,
               const perception::LaserPrecision& precision = {});

}  // namespace secondlook::apps

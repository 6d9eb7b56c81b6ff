#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lib/common/time.h"
#include "lib/hal/robot.h"

namespace secondlook::sim {

/// The part of a robot that has a fault.
enum class FaultyPart { kHeadCamera, kHandCamera, kHead, kBase, kLocalisation, kArm };

/// What a fault does, in the words of PX4's failure injection where it has one.
enum class FaultType {
  kOff,           ///< The device is lost: every question throws DeviceError.
  kStuck,         ///< It says the same for ever; an actuator takes a motion, and never moves.
  kGarbage,       ///< What it measures is random or not finite.
  kWrong,         ///< It is off by a constant: by scale, in angle or in place.
  kSlow,          ///< A frame or a state in 3 s; a motion takes 3 s longer.
  kDelayed,       ///< It answers, or sets out, late.
  kIntermittent,  ///< It works half of the time.
  kBlind,         ///< A camera: no depth.
  kClockJump,     ///< Its stamps jump ahead by 5 s.
  kRefuses,       ///< An actuator fails every motion before it moves.
  kAborts,        ///< An actuator fails on its way.
  kStopsShort,    ///< An actuator says on its way that it has arrived.
  kAtLimit,       ///< An arm fails where a joint comes near its limit.
};

/// One fault of one part, for a while of robot time.
struct Fault {
  FaultyPart part{FaultyPart::kHeadCamera};
  FaultType type{FaultType::kOff};
  Time from{};
  Time until{Time::max()};
};

/// All faults that there are, of a robot without an arm or with one.
std::vector<Fault> AllFaults(bool with_arm);

/// e.g. "localisation delayed".
std::string ToString(const Fault& fault);

/// The same robot with `faults`. What is random in them is drawn from `seed`. A device that is not
/// faulty answers as it would have.
/// @pre a robot with faults of arm or hand camera has both.
hal::Robot WithFaults(hal::Robot robot, const std::vector<Fault>& faults, std::uint64_t seed);

}  // namespace secondlook::sim

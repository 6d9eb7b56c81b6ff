#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/common/time.h"

namespace secondlook::hal {

/// What a laser striper is. Constant for its lifetime. Its frame L: the rays of a line start at the
/// origin and fan out in the plane of x and z, about z, the first on the side of -x.
struct StriperInfo {
  std::string name;           ///< What messages call it.
  int points{};               ///< Of a line, >= 2.
  double field_of_view{};     ///< From the first ray to the last [rad], in (0, pi).
  double min_range{};         ///< Nothing nearer is measured [m], > 0 …
  double max_range{};         ///< … nor farther.
  double lines_per_second{};  ///< While it is on, > 0.
  double range_sigma{};       ///< Of a range [m], > 0.

  /// The unit direction of ray `i`, in L.
  Eigen::Vector3d Ray(int i) const {
    const double angle = field_of_view * (static_cast<double>(i) / (points - 1) - 0.5);
    return {std::sin(angle), 0.0, std::cos(angle)};
  }
};

/// One line that the laser drew.
struct ScanLine {
  Time time{};                ///< When it was measured, not when it arrived.
  std::uint64_t sequence{};   ///< Count of lines measured.
  std::vector<float> ranges;  ///< Of each ray, along it from L's origin [m]; NaN = no return.
};

/// A laser that draws a line on what is before it and measures how far each point of it is; whoever
/// carries it sweeps the line over things. Its pose X_WL(time) is not the striper's business. Every
/// backend passes tests/hal/laser_striper_contract.h.
///
/// The laser is off until it is switched on, off again when this is destroyed, and goes off by
/// itself when nobody has called On() or Take() for kAttended.
/// Threading: Off() from any thread, the rest from one.
class LaserStriper {
 public:
  static constexpr Duration kAttended = Seconds(0.5);

  LaserStriper(const LaserStriper&) = delete;
  LaserStriper& operator=(const LaserStriper&) = delete;
  virtual ~LaserStriper() = default;

  virtual const StriperInfo& info() const = 0;

  /// Switches the laser on and returns at once. Lines are not older than this call.
  /// @throws DeviceError naming the striper if it is lost.
  virtual void On() = 0;

  /// Switches the laser off. Always possible, also when it is off. Lines that were measured before
  /// can still be taken.
  virtual void Off() noexcept = 0;

  /// The lines that have come since the last call, oldest first; never waits. Their times and
  /// sequence strictly increase, and each that is missing is counted by lost().
  /// @throws DeviceError naming the striper if it is lost, which it is too when it is on and sends
  /// nothing.
  virtual std::vector<ScanLine> Take() = 0;

  /// How many of the lines measured so far nobody will ever take.
  virtual std::uint64_t lost() const = 0;

 protected:
  LaserStriper() = default;
};

}  // namespace secondlook::hal

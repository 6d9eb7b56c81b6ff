#pragma once

#include <algorithm>
#include <cmath>

namespace secondlook::sim {

/// How fast something may move and change its speed.
struct RampLimits {
  double speed{};         ///< [m/s] or [rad/s]
  double acceleration{};  ///< [m/s^2] or [rad/s^2]
};

/// A speed that changes by no more than its acceleration allows.
class Ramp {
 public:
  double speed() const { return speed_; }

  /// Speeds up or brakes over `dt` [s] such that a rest `distance` (signed) ahead can be met, and
  /// returns the way of that time; the last one ends exactly there, at rest. When it is too fast to
  /// brake in time it overshoots and comes back.
  double Approach(double distance, const RampLimits& limits, double dt) {
    const double brakeable = std::sqrt(2.0 * limits.acceleration * std::abs(distance));
    const double wanted = std::copysign(std::min(limits.speed, brakeable), distance);
    Toward(wanted, limits, dt);
    const double way = speed_ * dt;
    const bool arrives = way * distance >= 0.0 && std::abs(way) >= std::abs(distance);
    if (!arrives && std::abs(distance) > limits.acceleration * dt * dt) return way;
    if (std::abs(speed_) > 4.0 * limits.acceleration * dt) return way;  // too fast to stand
    speed_ = 0.0;
    return distance;
  }

  /// Brakes over `dt` [s] and returns the way of that time.
  double Brake(const RampLimits& limits, double dt) {
    Toward(0.0, limits, dt);
    return speed_ * dt;
  }

 private:
  void Toward(double wanted, const RampLimits& limits, double dt) {
    const double most = limits.acceleration * dt;
    speed_ += std::clamp(wanted - speed_, -most, most);
  }

  double speed_{};
};

}  // namespace secondlook::sim

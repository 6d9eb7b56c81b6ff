#include "sim/striper_drive.h"

#include <numbers>
#include <utility>

#include "lib/common/rng.h"

namespace secondlook::sim {

StriperDrive::StriperDrive(const Pose& X_EL, int held, const NoiseConfig& noise, std::uint64_t seed)
    : X_EL_(X_EL), arrived_(held) {
  Rng rng(ForkSeed(seed, "striper mounting"));
  Eigen::Vector3d shift;
  Eigen::Vector3d turn;
  for (int i = 0; i < 3; ++i) {
    shift[i] = rng.Gaussian(noise.hand_eye_sigma);
    turn[i] = rng.Gaussian(noise.hand_eye_sigma_deg * std::numbers::pi / 180.0);
  }
  Pose error = Pose::Identity();
  error.translation() = shift;
  error.linear() = RotationFromVector(turn);
  X_EL_ = X_EL * error;
}

void StriperDrive::Light(Time attended_until) {
  Attend(attended_until);
  lit_ = true;
}

void StriperDrive::Step(Time now, const Pose& X_WE) {
  if (now > attended_until_) lit_ = false;
  if (now.time_since_epoch() % kPeriod != Duration::zero()) return;
  if (under_way_) arrived_.Push(*std::exchange(under_way_, std::nullopt));
  if (lit_) under_way_ = Shot{now, ++sequence_, X_WE * X_EL_};
}

}  // namespace secondlook::sim

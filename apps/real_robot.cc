#include "apps/real_robot.h"

#include "lib/common/error.h"

namespace secondlook::apps {

void RealArmConfig::Validate() const {
  if (urdf.empty()) Throw<ConfigError>("'urdf' is missing: the file that describes the arm");
}

void RealConfig::Validate() const {
  if (!beyond_this_host && transport::ReachesBeyondThisHost(lcm_url)) {
    Throw<ConfigError>(
        "'lcm_url' = '{}' reaches beyond this host, where everybody could then command the base: "
        "set its ttl=0, or 'beyond_this_host: true' on a network that only the robot is on",
        lcm_url);
  }
}

std::unique_ptr<hal::Camera> RealDevices::OpenCamera() {
  return std::visit([this](const auto& config) { return Open(config); }, config_.camera);
}

std::unique_ptr<hal::PanTilt> RealDevices::OpenHead() {
  return std::visit([this](const auto& config) { return Open(config); }, config_.pan_tilt);
}

std::unique_ptr<hal::Base> RealDevices::OpenBase() {
  return std::visit([this](const auto& config) { return Open(config); }, config_.base);
}

std::unique_ptr<hal::Arm> RealDevices::OpenArm() {
  return std::visit([this](const auto& config) { return Open(config); }, config_.arm->driver);
}

std::unique_ptr<hal::Camera> RealDevices::OpenHandCamera() {
  return std::visit([this](const auto& config) { return Open(config); }, config_.arm->camera);
}

std::unique_ptr<hal::LaserStriper> RealDevices::OpenStriper() {
  return std::make_unique<hal::LcmStriper>(*config_.arm->striper, Link(), clock_);
}

std::unique_ptr<hal::Camera> RealDevices::Open(const hal::OpenNi2Config& config) {
  return std::make_unique<hal::OpenNi2Camera>(config, clock_);
}

std::unique_ptr<hal::Camera> RealDevices::Open(const hal::LcmCameraConfig& config) {
  return std::make_unique<hal::LcmCamera>(config, Link(), clock_);
}

std::unique_ptr<hal::Camera> RealDevices::Open(const hal::VideoCameraConfig& config) {
  return std::make_unique<hal::VideoCamera>(config, clock_);
}

std::unique_ptr<hal::PanTilt> RealDevices::Open(const hal::FlirPtuConfig& config) {
  return std::make_unique<hal::FlirPtu>(config, clock_);
}

std::unique_ptr<hal::PanTilt> RealDevices::Open(const hal::FixedHeadConfig& config) {
  return std::make_unique<hal::FixedHead>(config, clock_);
}

std::unique_ptr<hal::Base> RealDevices::Open(const hal::FixedBaseConfig& config) {
  return std::make_unique<hal::FixedBase>(config, clock_);
}

std::unique_ptr<hal::Base> RealDevices::Open(const hal::LcmBaseConfig& config) {
  return std::make_unique<hal::LcmBase>(config, Link(), clock_);
}

std::unique_ptr<hal::Arm> RealDevices::Open(const hal::KukaIiwaConfig& config) {
  // A link of its own: no image holds up what leads the arm.
  return std::make_unique<hal::KukaIiwa>(config, std::make_shared<hal::LcmLink>(config_.lcm_url),
                                         clock_);
}

const std::shared_ptr<hal::LcmLink>& RealDevices::Link() {
  if (link_ == nullptr) link_ = std::make_shared<hal::LcmLink>(config_.lcm_url);
  return link_;
}

kinematics::EyeInHand LoadArm(const RealArmConfig& config,
                              const kinematics::Calibration& calibration) {
  if (!calibration.X_EC) {
    Throw<ConfigError>("the calibration file has no X_EC: where the camera sits in the hand");
  }
  kinematics::EyeInHand hand{{kinematics::LoadUrdf(config.urdf), config.tip}, *calibration.X_EC};
  const std::size_t joints =
      std::visit([](const auto& driver) { return driver.limit_deg.size(); }, config.driver);
  if (hand.arm.size() != static_cast<int>(joints)) {
    Throw<ConfigError>("{}: has {} joints up to '{}', and the arm has {}", config.urdf,
                       hand.arm.size(), config.tip, joints);
  }
  return hand;
}

Pose LaserOnArm(const kinematics::Calibration& calibration) {
  if (!calibration.X_EL) {
    Throw<ConfigError>("the calibration file has no X_EL: where the laser sits on the arm");
  }
  return *calibration.X_EL;
}

}  // namespace secondlook::apps

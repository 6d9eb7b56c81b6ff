#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "lib/common/clock.h"
#include "lib/hal/drivers/fixed_base.h"
#include "lib/hal/drivers/fixed_head.h"
#include "lib/hal/drivers/flir_ptu.h"
#include "lib/hal/drivers/kuka_iiwa.h"
#include "lib/hal/drivers/lcm_base.h"
#include "lib/hal/drivers/lcm_camera.h"
#include "lib/hal/drivers/lcm_link.h"
#include "lib/hal/drivers/lcm_striper.h"
#include "lib/hal/drivers/openni2_camera.h"
#include "lib/hal/drivers/video_camera.h"
#include "lib/kinematics/calibration_file.h"
#include "lib/kinematics/eye_in_hand.h"

namespace secondlook::apps {

/// An arm with a camera in its hand.
struct RealArmConfig {
  std::variant<hal::KukaIiwaConfig> driver;
  std::string urdf;           ///< Its description; the root link is the base B. Required.
  std::string tip{"flange"};  ///< The link that is its end-effector E.
  std::variant<hal::VideoCameraConfig, hal::LcmCameraConfig> camera;
  std::optional<hal::LcmStriperConfig> striper;  ///< None: it carries no laser.

  template <class A>
  void Serialize(A* a) {
    a->Visit("driver", &driver);
    a->Visit("urdf", &urdf);
    a->Visit("tip", &tip);
    a->Visit("camera", &camera);
    a->Visit("striper", &striper);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A robot that is there (docs/real_robot.md): which driver each of its devices has, by its tag.
struct RealConfig {
  static constexpr const char* kTag = "Real";

  std::variant<hal::OpenNi2Config, hal::LcmCameraConfig> camera;  ///< On the head.
  std::variant<hal::FlirPtuConfig, hal::FixedHeadConfig> pan_tilt;
  std::variant<hal::FixedBaseConfig, hal::LcmBaseConfig> base;
  std::optional<RealArmConfig> arm;                ///< None: it has no arm.
  std::string calibration;                         ///< The calibration file; required.
  std::string lcm_url{transport::kDefaultLcmUrl};  ///< Of the devices that are behind LCM.
  /// Devices on other hosts may be spoken with, which lets everybody there command the base.
  bool beyond_this_host{false};

  template <class A>
  void Serialize(A* a) {
    a->Visit("camera", &camera);
    a->Visit("pan_tilt", &pan_tilt);
    a->Visit("base", &base);
    a->Visit("arm", &arm);
    a->Visit("calibration", &calibration);
    a->Visit("lcm_url", &lcm_url);
    a->Visit("beyond_this_host", &beyond_this_host);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// Opens the devices of a real robot, each by itself. What it has opened must not outlive `clock`.
class RealDevices {
 public:
  /// @param clock Not null; outlives this and what is opened.
  /// @param link The network of the devices behind LCM; null: one is made for config.lcm_url.
  RealDevices(const RealConfig& config, const Clock* clock,
              std::shared_ptr<hal::LcmLink> link = nullptr)
      : config_(config), clock_(clock), link_(std::move(link)) {}

  // Each throws DeviceError for a device that does not answer, saying what to do about it.
  std::unique_ptr<hal::Camera> OpenCamera();
  std::unique_ptr<hal::PanTilt> OpenHead();
  std::unique_ptr<hal::Base> OpenBase();
  // @pre there is an arm.
  std::unique_ptr<hal::Arm> OpenArm();
  std::unique_ptr<hal::Camera> OpenHandCamera();
  // @pre it carries a laser.
  std::unique_ptr<hal::LaserStriper> OpenStriper();

 private:
  std::unique_ptr<hal::Camera> Open(const hal::OpenNi2Config& config);
  std::unique_ptr<hal::Camera> Open(const hal::LcmCameraConfig& config);
  std::unique_ptr<hal::Camera> Open(const hal::VideoCameraConfig& config);
  std::unique_ptr<hal::PanTilt> Open(const hal::FlirPtuConfig& config);
  std::unique_ptr<hal::PanTilt> Open(const hal::FixedHeadConfig& config);
  std::unique_ptr<hal::Base> Open(const hal::FixedBaseConfig& config);
  std::unique_ptr<hal::Base> Open(const hal::LcmBaseConfig& config);
  std::unique_ptr<hal::Arm> Open(const hal::KukaIiwaConfig& config);
  /// The network that all share, made for the first.
  const std::shared_ptr<hal::LcmLink>& Link();

  const RealConfig config_;
  const Clock* clock_;
  std::shared_ptr<hal::LcmLink> link_;
};

/// The kinematics of the arm that `config` describes, with the camera in its hand where
/// `calibration` says.
/// @throws ConfigError for a description of another arm, or a calibration without X_EC.
kinematics::EyeInHand LoadArm(const RealArmConfig& config,
                              const kinematics::Calibration& calibration);

/// Where the laser sits on the arm, as `calibration` says. @throws ConfigError when it does not.
Pose LaserOnArm(const kinematics::Calibration& calibration);

}  // namespace secondlook::apps

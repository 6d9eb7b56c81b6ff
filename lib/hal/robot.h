#pragma once

#include <memory>

#include "lib/common/clock.h"
#include "lib/hal/arm.h"
#include "lib/hal/base.h"
#include "lib/hal/camera.h"
#include "lib/hal/laser_striper.h"
#include "lib/hal/pan_tilt.h"

namespace secondlook::hal {

/// All the devices of one robot. They are destroyed in reverse order, so the clock outlives them.
struct Robot {
  std::unique_ptr<Clock> clock;
  std::unique_ptr<Base> base;
  std::unique_ptr<PanTilt> head;
  std::unique_ptr<Camera> head_camera;
  std::unique_ptr<Arm> arm;               ///< Null: it has none.
  std::unique_ptr<Camera> hand_camera;    ///< On the arm's end-effector; null: there is none.
  std::unique_ptr<LaserStriper> striper;  ///< Likewise.

  /// Stops everything that moves and switches the laser off, from any thread.
  void Stop() noexcept {
    base->Stop();
    head->Stop();
    if (arm) arm->Stop();
    if (striper) striper->Off();
  }
};

}  // namespace secondlook::hal

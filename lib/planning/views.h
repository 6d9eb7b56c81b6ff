#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/hal/base.h"
#include "lib/hal/camera.h"
#include "lib/hal/pan_tilt.h"
#include "lib/kinematics/head.h"
#include "lib/planning/collision.h"
#include "lib/planning/path.h"
#include "lib/world/look.h"

namespace secondlook::planning {

/// The number of poses is the paper's (McGreavy 2016), which does not say how far from the object
/// its rings are: the radii are what the simulated robot's camera sees well from. The other values
/// are chosen by hand.
struct ViewsConfig {
  double inner_radius_m{0.95};  ///< From the target to the base's centre.
  double outer_radius_m{1.35};
  int poses{38};   ///< In both rings together (McGreavy 2016); each has half of them.
  int placed{24};  ///< Beside them, so many made for the place (PlacedViews).
  double max_depth_sigma_m{0.004};  ///< Placed views are so near that depth is no worse than this…
  double min_target_px{60.0};       ///< …and that the target spans so much of the picture.

  template <class A>
  void Serialize(A* a) {
    a->Visit("inner_radius_m", &inner_radius_m);
    a->Visit("outer_radius_m", &outer_radius_m);
    a->Visit("poses", &poses);
    a->Visit("placed", &placed);
    a->Visit("max_depth_sigma_m", &max_depth_sigma_m);
    a->Visit("min_target_px", &min_target_px);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// The camera and what carries it.
struct CameraCarrier {
  hal::BaseInfo base;
  hal::PanTiltInfo pan_tilt;
  kinematics::HeadCalibration head;
  hal::CameraInfo camera;
};

/// What the robot can reach from where it is. The references must outlive the call they are for.
struct Reach {
  const CollisionChecker& collision;
  const Routes& routes;     ///< From where the base is now.
  hal::PanTiltAngles head;  ///< Where the head looks now.
};

/// The candidates for the next view of a target at `p_WT`: base poses on two uniform rings around
/// it, each facing it, the head aimed at it (McGreavy 2016, View Generation). The rings are turned
/// against each other by half a step, so that together they give as many directions as poses. Each
/// candidate goes through the checks "pan-tilt limits", "range" (of a depth camera), "collision"
/// and "path", in this order, until one refuses it; none is left out of the result. `seconds`: the
/// head turns while the base drives.
/// @throws ConfigError when `config` is not valid, InvalidArgument for a target that is not finite
/// or a head without speed.
std::vector<world::Look> CandidateViews(const Eigen::Vector3d& p_WT, int target,
                                        const CameraCarrier& carrier, const Reach& reach,
                                        const ViewsConfig& config = {});

/// Distances along the floor [m]; empty when near >= far.
struct DistanceRange {
  double near{};
  double far{};
};

/// How far from a target in `box_W` the base may stand, by what the camera sees from there: no
/// nearer than its depth reaches and its picture holds the whole target, no farther than depth is
/// good and the target spans enough pixels.
DistanceRange UsefulDistances(const Eigen::AlignedBox3d& box_W, const CameraCarrier& carrier,
                              const ViewsConfig& config = {});

/// Candidates made for the place, where the rings may have few: base poses at useful distances all
/// around the target, evenly spread (an R2 sequence, no chance), of which the first `placed` that
/// pass all the checks of CandidateViews() are returned. Those that fail are no candidates.
/// @throws As CandidateViews() does; InvalidArgument for a box that is empty or not finite.
std::vector<world::Look> PlacedViews(const Eigen::AlignedBox3d& box_W, int target,
                                     const CameraCarrier& carrier, const Reach& reach,
                                     const ViewsConfig& config = {});

}  // namespace secondlook::planning

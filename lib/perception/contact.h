#pragma once

#include <vector>

#include "lib/common/pose.h"
#include "lib/geometry/point_to_plane.h"
#include "lib/perception/recognition_model.h"
#include "lib/world/support_plane.h"

namespace secondlook::perception {

/// Adds pairs that bring the lowest points of `model` at X_CM onto the plane, of `weight` in all.
/// Only when it nearly stands there already (within 2.5 cm): what lies on top of something else is
/// left alone.
void AddContact(const RecognitionModel& model, const Pose& X_CM, const world::SupportPlane& plane_C,
                double weight, std::vector<geometry::PointPlanePair>* pairs);

/// As AddContact(), but the same points are all to be moved by what the lowest stands too high or
/// too deep: that holds the height and leaves the tilt to what is measured.
void AddContactHeight(const RecognitionModel& model, const Pose& X_CM,
                      const world::SupportPlane& plane_C, double weight,
                      std::vector<geometry::PointPlanePair>* pairs);

}  // namespace secondlook::perception

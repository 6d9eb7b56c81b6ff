#pragma once

#include <cstdint>
#include <vector>

#include "apps/capture.h"
#include "lib/hal/base.h"
#include "lib/hal/pan_tilt.h"
#include "lib/world/look.h"
#include "lib/world/scene_belief.h"
#include "lib/world/task.h"

#include "bot_core/images_t.hpp"
#include "second_look/detection_t.hpp"
#include "second_look/look_t.hpp"
#include "second_look/object_t.hpp"
#include "second_look/support_plane_t.hpp"
#include "second_look/task_t.hpp"
#include "second_look/view_t.hpp"

namespace secondlook::apps {

/// The project's nouns as messages; docs/channels.md says what each field means.

/// An instant in microseconds of its clock.
std::int64_t ToUtime(Time time);

second_look::pose_t ToMessage(const Pose& X_AB);
second_look::camera_t ToMessage(const std::string& name, const hal::CameraModel& camera);
second_look::verification_t ToMessage(const world::Verification& verification);
second_look::object_t ToMessage(const world::ObjectBelief& object);
second_look::support_plane_t ToMessage(const world::SupportPlane& plane_W);
second_look::look_t ToMessage(const world::Look& look);
second_look::task_t ToMessage(const world::Task& task);

/// The task of a message. Not validated.
world::Task FromMessage(const second_look::task_t& task);
/// The look of a message; long texts come as they were shortened.
world::Look FromMessage(const second_look::look_t& look);

/// The things that view number `view` shows, each with the object it was matched with.
std::vector<second_look::detection_t> DetectionsOf(const world::SceneBelief& belief, int view);

/// Colour as JPEG and depth at half the resolution, together at most `max_bytes` long: the JPEG's
/// quality is lowered from 80 until it fits. @pre max_bytes >= 60,000.
bot_core::images_t ToImages(const hal::RgbdFrame& frame, std::size_t max_bytes);

}  // namespace secondlook::apps

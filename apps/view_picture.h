#pragma once

#include <opencv2/core/mat.hpp>

#include "lib/world/scene_belief.h"

namespace secondlook::apps {

/// View number `view` as a picture: its colour image with each thing outlined in the colour of its
/// state (green verified, orange open, violet unknown) and named. [height, width] CV_8UC3, RGB.
cv::Mat DrawView(const world::SceneBelief& belief, int view);

}  // namespace secondlook::apps

#pragma once

#include <array>

#include "lib/common/rng.h"
#include "lib/planning/tile_scores.h"

namespace secondlook::apps {

/// The 15 cases in which an initial view is shown (Hoseini 2021, 5.2).
inline constexpr std::array<const char*, 15> kDistortions{"none",
                                                          "top white",
                                                          "bottom white",
                                                          "left black",
                                                          "right black",
                                                          "noise 20",
                                                          "noise 30",
                                                          "upper left covered",
                                                          "upper right covered",
                                                          "lower left covered",
                                                          "lower right covered",
                                                          "blur 5",
                                                          "blur 9",
                                                          "bright 150",
                                                          "dark 150"};

/// `crop` in the case `distortion`. Colours are clipped, not wrapped around. What lies over the
/// object has a depth, too: that of `other` under a corner of it, 60 % of the length and width; the
/// mean of what is known where half of the image is blank. `rng` is drawn from for noise alone.
/// @param other Whose corner is laid over the object's, shrunk to the size of `crop`.
planning::ObjectCrop Distorted(const planning::ObjectCrop& crop, int distortion,
                               const planning::ObjectCrop& other, Rng* rng);

/// As seen in a mirror: left is right.
planning::ObjectCrop Mirrored(const planning::ObjectCrop& crop);

}  // namespace secondlook::apps

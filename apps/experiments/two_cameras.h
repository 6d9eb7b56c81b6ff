#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "lib/fusion/cross_match.h"
#include "lib/perception/appearance/classifier.h"
#include "lib/perception/appearance/training_images.h"
#include "sim/scene.h"

namespace secondlook::apps {

/// Something that a camera detected.
struct Sighted {
  int thing{-1};                      ///< The scene's object that it mostly shows; -1: none.
  std::vector<double> probabilities;  ///< By class of the classifier.
};

/// A table as the camera on the head, which measures depth, and the one in the hand, which has
/// colour alone, see it.
struct TwoViews {
  std::vector<Sighted> head;
  std::vector<Sighted> hand;
  std::vector<fusion::CrossMatch> matches;  ///< Between the two, by index.
};

/// A table with all of `things` at random, not crowded, in the light and on the tables that the
/// test is made with.
sim::Scene DrawTestTable(const std::vector<sim::SceneObject>& things, std::uint64_t seed);

/// `scene` with up to `count` boards on the table, each hiding a part of one of its objects from an
/// eye at `p_WEye`.
sim::Scene WithOccluders(sim::Scene scene, const Eigen::Vector3d& p_WEye, int count,
                         std::uint64_t seed);

/// … up to three of them, from the head of LookTwice(scene, …, seed).
sim::Scene WithOccluders(sim::Scene scene, std::uint64_t seed);

/// Looks at the table from the head (1.3 to 1.6 m away, 20 to 35 degrees above it), and from the
/// hand (1.1 to 1.2 m, 55 to 70 degrees) 50 to 110 degrees further round; cuts the head's view by
/// depth, the hand's by the background of the empty table (BackgroundModel), matches what is there
/// by the calibration with the design's errors, and asks `classifier` about the crops. All chance
/// comes from `seed`; the same seed looks from the same places.
TwoViews LookTwice(const sim::Scene& scene, const perception::Classifier& classifier,
                   std::uint64_t seed);

/// Pictures of `things`, each alone, whole and in part, and behind boxes, from near and far, and of
/// boxes as the class of the background: in other light, on other tables and from other poses than
/// any test's.
perception::TrainingSet RenderTrainingSet(const std::vector<sim::SceneObject>& things,
                                          std::uint64_t seed);

}  // namespace secondlook::apps

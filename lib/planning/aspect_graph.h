#pragma once

#include <vector>

#include "lib/common/rng.h"
#include "lib/geometry/camera_model.h"
#include "lib/planning/aspect_graph_config.h"
#include "lib/planning/aspect_target.h"
#include "lib/planning/model_analysis.h"
#include "lib/world/look.h"
#include "lib/world/voxel_space.h"

namespace secondlook::planning {

/// All terms of one candidate's score. All 0 for a candidate that was refused before.
struct AspectScore {
  int box_rays{};                       ///< Rays of the modelled camera that meet the target's box.
  double blocked{};                     ///< Share of these that an occupied voxel stops.
  double through_unknown{};             ///< Share that is not stopped but crosses unknown space.
  double surviving{};                   ///< Share that arrives, with the chance to survive.
  std::vector<ModelVisibility> models;  ///< One a hypothesis.
  double view_score{};  ///< The paper's: sum of view shares minus their differences.
  double difference{};  ///< Mean over pairs of hypotheses, by belief: share of the rays to
                        ///< either on which what would be seen differs.
  double novelty{};     ///< Of the direction, against the views taken, in [0, 1].
  std::vector<Prospect> prospects;  ///< Among the hypotheses and, last, none of them.
};

/// The candidates with their scores.
struct AspectGraph {
  std::vector<world::Look> looks;   ///< Of one target, in the order they were given.
  std::vector<AspectScore> scores;  ///< One a look.
};

/// Scores the feasible ones of `looks` (McGreavy 2016, Sections 3 and 4).
///
/// Environment analysis: the rays of the modelled camera at X_WC that meet the target's box are
/// cast through `space`; those stopped before the box are dropped. Model analysis: the others are
/// cast at each hypothesis' mesh. With several hypotheses the paper subtracts the differences of
/// the visible shares from their sum. That finds a view of both but not one that tells them apart;
/// the default strategy also compares what each ray would measure, depth and colour, and predicts
/// what would be believed after the view. The evidence of a view is the share of the rays on which
/// two hypotheses differ, times `evidence`, novelty and pixels / (pixels + few_px); unknown space
/// on the way hides what is behind all of it, or nothing. For a hypothesis it counts by the chance
/// that verification accepts it from there: what is nearly all rim (InnerShare()) never is. A
/// target without a model has the environment analysis alone.
///
/// Fills in visibility, gain, score and the check "visible" of each look, by the default strategy
/// "worth its time", too:
///   visibility = box shares of the hypotheses, averaged by belief (no model: `surviving`)
///   gain       = expected drop of the task's loss
///   score      = gain per second of the best plan of one or two looks that begins with this one
///                (GainsLookingAhead), or what the strategy says instead.
///
/// @param camera The real camera; it is modelled with ray_columns columns, or region_ray_columns.
/// @param rng Used by the strategy "random" alone. Not null.
/// @throws ConfigError when `config` is not valid; InvalidArgument for a box that is empty, not
/// finite or smaller than 1 mm, a pose or direction that is not valid, or a null mesh.
AspectGraph ScoreAspectGraph(const world::VoxelSpace& space, const geometry::CameraModel& camera,
                             const AspectTarget& target, std::vector<world::Look> looks, Rng* rng,
                             const AspectGraphConfig& config = {});

}  // namespace secondlook::planning

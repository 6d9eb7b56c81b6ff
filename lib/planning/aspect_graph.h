#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "lib/common/rng.h"
#include "lib/geometry/camera_model.h"
#include "lib/geometry/mesh.h"
#include "lib/geometry/ray_caster.h"
#include "lib/planning/expected_loss.h"
#include "lib/planning/look_ahead.h"
#include "lib/world/look.h"
#include "lib/world/voxel_space.h"

namespace secondlook::planning {

/// By what a candidate look is scored.
enum class LookStrategy {
  kExpectedLoss,  ///< Expected drop of the task's loss, divided by the seconds: the default.
  kMcGreavy,      ///< Most of the camera's field of view filled by the model (McGreavy 2016).
  kNearest,       ///< Baseline: the one reached soonest.
  kRandom,        ///< Baseline: any.
  kFixedStep,     ///< Baseline: so many degrees round the object from the last view (Wixson 1994).
};

/// Parses "expected loss", "McGreavy", "nearest", "random" or "fixed step".
/// @throws ConfigError naming `text` and what is expected.
LookStrategy ParseLookStrategy(const std::string& text);

/// Where the values come from. Measured or derived: `evidence` is the steepness of
/// perception::ScoreOf(); `depth_sigmas` two of the sensor's own; `ahead_speed` the simulated
/// base's 0.5 m/s with its turns and stops; `look_seconds` what the mission charges for a look. Of
/// the task, to be set by who gives it: `loss`. Of the paper (McGreavy 2016) or its peers:
/// `fixed_step_deg` (Wixson 1994). Chosen by hand, and backed by no measurement but that the looks
/// that are taken settle things (experiments `unobstructed` to `rejection`): `ray_columns`,
/// `box_margin_m` (three voxels), `unknown_m` (four voxels), `unknown_survival` (nothing is known:
/// even odds), `min_visibility`, `same_view_deg`, `new_view_deg`, `new_view_unknown_deg`,
/// `same_view_novelty`, `color_difference`, `unlike`, `few_px`.
struct AspectGraphConfig {
  std::string strategy{"expected loss"};
  LossConfig loss;
  LookAheadConfig look_ahead;
  int ray_columns{160};          ///< Of the modelled camera; its rows follow from the camera's.
  double box_margin_m{0.03};     ///< Voxels so near to the target's box may be the target itself.
  double unknown_m{0.04};        ///< A ray that crosses more unknown space is probably occluded…
  double unknown_survival{0.5};  ///< …and counts so much.
  double min_visibility{0.05};   ///< A candidate that sees less of the target is refused.
  double same_view_deg{20.0};    ///< A direction so near to one that was no help is no news…
  double new_view_deg{45.0};     ///< …and this far from all of them it is new,…
  double new_view_unknown_deg{90.0};  ///< …or so far when no model fits the target.
  double same_view_novelty{0.1};      ///< What the same view again counts.
  double look_seconds{5.0};           ///< What a look takes beside getting there.
  double depth_sigmas{2.0};           ///< Two depths differ when so many sigma apart.
  double color_difference{0.2};       ///< Two colours differ when their largest channel does by so
                                      ///< much, of 1.
  double evidence{25.0};  ///< For one hypothesis against another where all that is seen of them
                          ///< differs [nat]: how steep perception::ScoreOf() is.
  double unlike{0.2};    ///< What is none of the hypotheses differs from each by so much of what is
                         ///< seen of it for the first time.
  double few_px{500.0};  ///< With so many pixels on a thing, a view gives half of its evidence.
  double ahead_speed{0.3};       ///< From one look to the next, turns included [m/s].
  double fixed_step_deg{180.0};  ///< Of the strategy "fixed step".

  template <class A>
  void Serialize(A* a) {
    a->Visit("strategy", &strategy);
    a->Visit("loss", &loss);
    a->Visit("look_ahead", &look_ahead);
    a->Visit("ray_columns", &ray_columns);
    a->Visit("box_margin_m", &box_margin_m);
    a->Visit("unknown_m", &unknown_m);
    a->Visit("unknown_survival", &unknown_survival);
    a->Visit("min_visibility", &min_visibility);
    a->Visit("same_view_deg", &same_view_deg);
    a->Visit("new_view_deg", &new_view_deg);
    a->Visit("new_view_unknown_deg", &new_view_unknown_deg);
    a->Visit("same_view_novelty", &same_view_novelty);
    a->Visit("look_seconds", &look_seconds);
    a->Visit("depth_sigmas", &depth_sigmas);
    a->Visit("color_difference", &color_difference);
    a->Visit("evidence", &evidence);
    a->Visit("unlike", &unlike);
    a->Visit("few_px", &few_px);
    a->Visit("ahead_speed", &ahead_speed);
    a->Visit("fixed_step_deg", &fixed_step_deg);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A model that may stand at a pose. What the pointers show must outlive the call it is for.
struct PosedModel {
  const geometry::Mesh* mesh{};         ///< Not null; for the colours.
  const geometry::RayCaster* caster{};  ///< Not null; of the same mesh.
  Pose X_WM{Pose::Identity()};
  double belief{0.5};  ///< Its probability; those of a target sum to at most 1.
  double needed{0.9};  ///< The task decides for it from this probability on, in [0, 1).
};

/// What the next look is for.
struct AspectTarget {
  int id{-1};  ///< Object id, as the looks carry it; -1: space where one could stand unseen.
  Eigen::AlignedBox3d box_W;           ///< Around the candidate: its hypotheses and its points.
  std::vector<PosedModel> hypotheses;  ///< Empty: no model fits.
  double none{0.5};  ///< Probability that nothing that is known fits. Of hypotheses it is the rest.
  /// Unit vectors from the target to the cameras of the views taken, oldest first, none of which
  /// has settled it.
  std::vector<Eigen::Vector3d> seen_from_W;
};

/// How much of one hypothesis a candidate would see.
struct ModelVisibility {
  double box_share{};   ///< Of the rays to the target's box that arrive and hit the model, each
                        ///< counted with its chance to survive, in [0, 1].
  double view_share{};  ///< Of all rays of the camera, unknown space counted as free: the paper's
                        ///< visibility, in [0, 1].
  double area{};        ///< Of the model's surface that these rays see [m^2].
};

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
/// on the way hides what is behind all of it, or nothing. A target without a model has the
/// environment analysis alone.
///
/// Fills in visibility, gain, score and the check "visible" of each look, by the default strategy
/// "worth its time", too:
///   visibility = box shares of the hypotheses, averaged by belief (no model: `surviving`)
///   gain       = expected drop of the task's loss
///   score      = gain per second of the best plan of one or two looks that begins with this one
///                (GainsLookingAhead), or what the strategy says instead.
///
/// @param camera The real camera; it is modelled with ray_columns columns.
/// @param rng Used by the strategy "random" alone. Not null.
/// @throws ConfigError when `config` is not valid; InvalidArgument for a box that is empty, not
/// finite or smaller than 1 mm, a pose or direction that is not valid, or a null mesh.
AspectGraph ScoreAspectGraph(const world::VoxelSpace& space, const geometry::CameraModel& camera,
                             const AspectTarget& target, std::vector<world::Look> looks, Rng* rng,
                             const AspectGraphConfig& config = {});

}  // namespace secondlook::planning

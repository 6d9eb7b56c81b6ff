#pragma once

#include <string>

#include "lib/planning/expected_loss.h"
#include "lib/planning/look_ahead.h"

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
/// `region_ray_columns`, `box_margin_m` (three voxels), `unknown_m` (four voxels),
/// `unknown_survival` (nothing is known: even odds), `min_visibility`, `same_view_deg`,
/// `new_view_deg`, `new_view_unknown_deg`, `same_view_novelty`, `color_difference`, `unlike`,
/// `few_px`.
struct AspectGraphConfig {
  std::string strategy{"expected loss"};
  LossConfig loss;
  LookAheadConfig look_ahead;
  int ray_columns{160};          ///< Of the modelled camera; its rows follow from the camera's.
  int region_ray_columns{80};    ///< Likewise for space where a thing could stand unseen, which has
                                 ///< a share that is visible, but no shape.
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
    a->Visit("region_ray_columns", &region_ray_columns);
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

}  // namespace secondlook::planning

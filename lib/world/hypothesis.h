#pragma once

#include <string>

#include "lib/common/pose.h"

namespace secondlook::world {

/// What rendering a hypothesis and comparing it with the frame showed (Kriegel 2013, III-C).
/// Counts are pixels of the frame, inside the silhouette of the model rendered at the hypothesis.
struct Verification {
  int rendered{};     ///< Of the silhouette, without its rim, where depth cameras see nothing.
  int visible{};      ///< Of these, not hidden behind a nearer measurement: N_r of Eq. 5.
  int matching{};     ///< Of these, measured at the rendered depth: N_m of Eq. 5.
  int see_through{};  ///< Of these, measured well behind the rendered surface: a contradiction.
  int cluster{};      ///< Pixels of the cluster that the hypothesis is to explain: N_c of Eq. 5.
  double quality{};   ///< q_h (Eq. 5), in [0, 1].
  double visible_fraction{};  ///< visible / rendered, in [0, 1].
  double color_agreement{};   ///< Of the matching pixels' colours, in [0, 1]; NaN without colour.
  bool accepted{};            ///< Passed every check.
  std::string reason;         ///< Which check failed, with values; empty when accepted.
};

/// That a model stands at a pose. It is born in one view; X_CM belongs to that view's camera.
struct Hypothesis {
  std::string model;  ///< Name in the object database.
  Pose X_CM{Pose::Identity()};
  /// Probability-like support in [0, 1] that model and pose are right, from the verification alone,
  /// whatever else may be in the database.
  double score{};
  Verification verification;
  /// Calibrated probability in [0, 1] that model and pose are right, given what this view alone
  /// shows and all else that it holds for possible there (perception/posterior.h). 0 for a
  /// hypothesis that was asked of a view by itself, without its rivals.
  double probability{};
};

}  // namespace secondlook::world

#pragma once

#include <string>
#include <vector>

#include "lib/perception/posterior.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/verify.h"
#include "lib/perception/view.h"
#include "lib/world/observation.h"

namespace secondlook::perception {

/// How hard recognition tries, and when it is sure.
struct RecogniseConfig {
  VerifyConfig verify;
  PosteriorConfig posterior;
  int guesses_per_model = 4;      ///< Poses of one model that are refined.
  int hypotheses_per_model = 3;   ///< That are handed on, with their verification.
  double min_guess_share = 0.45;  ///< A guess below this share of the cluster's best is dropped.
  double min_score = 0.9;         ///< Of a hypothesis that is chosen.
  /// How far ahead of every rival the best hypothesis must be to be verified: difference of the
  /// log-odds of the scores.
  double min_lead = 1.0;
  /// Poses of one model nearer than this are one answer, and need no lead over each other.
  double tolerance_m = 0.03;
  double tolerance_deg = 15.0;

  template <class A>
  void Serialize(A* a) {
    a->Visit("verify", &verify);
    a->Visit("posterior", &posterior);
    a->Visit("guesses_per_model", &guesses_per_model);
    a->Visit("hypotheses_per_model", &hypotheses_per_model);
    a->Visit("min_guess_share", &min_guess_share);
    a->Visit("min_score", &min_score);
    a->Visit("min_lead", &min_lead);
    a->Visit("tolerance_m", &tolerance_m);
    a->Visit("tolerance_deg", &tolerance_deg);
  }

  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// What each cluster of `view` may be: for every model poses are proposed, refined and verified; of
/// what is accepted, all poses that could be taken for it are, too, and they are told apart by the
/// colours where they differ. One Detection per cluster, in order; its hypotheses by falling score,
/// at most `hypotheses_per_model` of a model, those of an accepted one not within the tolerance of
/// each other. `reason` says why none is accepted. The same for any number of threads.
std::vector<world::Detection> Recognise(const View& view,
                                        const std::vector<world::Cluster>& clusters,
                                        const std::vector<RecognitionModel>& models,
                                        const RecogniseConfig& config);

/// Which hypothesis of a detection is beyond doubt.
struct Choice {
  int hypothesis{-1};  ///< Index into the detection's; -1: none is.
  std::string reason;  ///< Why none is, with values; empty otherwise.
};

/// For each detection the hypothesis that is accepted and ahead of every rival by the lead: of
/// every other model, and of the same model (of `models`) in another pose, unless its surface and
/// colours nearly coincide there.
std::vector<Choice> ChooseHypotheses(const std::vector<world::Detection>& detections,
                                     const std::vector<RecognitionModel>& models,
                                     const RecogniseConfig& config);

}  // namespace secondlook::perception

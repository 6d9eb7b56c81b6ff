#include "lib/perception/recognise.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "lib/common/check_range.h"
#include "lib/common/parallel.h"
#include "lib/perception/hypothesise.h"
#include "lib/perception/point_match.h"
#include "lib/perception/posed_colors.h"
#include "lib/perception/refine.h"
#include "lib/perception/rival_turns.h"
#include "lib/perception/turn_by_color.h"

namespace secondlook::perception {
namespace {

using world::Hypothesis;

void SortByScore(std::vector<Hypothesis>* hypotheses) {
  std::stable_sort(hypotheses->begin(), hypotheses->end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
}

/// Looks for the poses at which one model may have made one cluster.
class Examination {
 public:
  Examination(const RecognitionModel& model, const View& view, int label, int inner_pixels,
              const RecogniseConfig& config)
      : model_(model), view_(view), label_(label), inner_pixels_(inner_pixels), config_(config) {}

  /// Refines the guesses, turns them by colour, verifies each, and looks for what could be taken
  /// for the best.
  std::vector<Hypothesis> Run(const std::vector<PoseGuess>& guesses) {
    for (const PoseGuess& guess : guesses) Follow(guess.X_CM);
    SortByScore(&found_);
    KeepDistinct(kSameDistance, kSamePeak, config_.hypotheses_per_model);
    if (!found_.empty() && !found_.front().verification.accepted && found_.front().score > 0.5) {
      Add(RefinePose(model_, found_.front().X_CM, view_, label_, 6, &rasteriser_));
      SortByScore(&found_);
    }
    if (found_.empty() || !found_.front().verification.accepted) return std::move(found_);
    Polish();
    for (int round = 0; round < kRounds; ++round) {
      const Pose X_best = found_.front().X_CM;
      AddRivals(X_best);
      SortByColor();
      KeepDistinct(kSameDistance, kSamePeak, kMostRivals);
      SettleFitted(X_best);
      SortByColor();
      if (!found_.front().verification.accepted || found_.front().X_CM.isApprox(X_best)) break;
      Polish();
    }
    CompareColors();
    SortByScore(&found_);
    KeepDistinct(config_.tolerance_m, config_.tolerance_deg * kDegree,
                 config_.hypotheses_per_model);
    return std::move(found_);
  }

 private:
  static constexpr double kDegree = std::numbers::pi / 180.0;
  static constexpr double kSameDistance = 0.010;      // [m]
  static constexpr double kSamePeak = 9.0 * kDegree;  // [rad]
  static constexpr double kByChance = 1.0;            // [log-odds]
  static constexpr RegistrationSigma kNoFreedom{1e-6, 1e-6};
  static constexpr double kNudge = 10.0 * kDegree;
  static constexpr double kRivalTurn = 20.0 * kDegree;
  static constexpr int kSpotTurns = 24;        // about the support plane's normal
  static constexpr double kRivalShare = 0.7;   // of the best one's quality: less is no rival
  static constexpr double kRivalColor = 0.15;  // that its colours may agree less
  static constexpr std::size_t kPoints = 300;
  static constexpr int kRounds = 3;
  static constexpr std::size_t kSettledRivals = 4;  // the best among them
  static constexpr double kSettledDistance = 1e-4;  // [m]
  static constexpr double kSettledAngle = 0.1 * kDegree;
  static constexpr int kMostRivals = 10;           // that stay for the next round
  static constexpr double kHopelessHalfway = 0.6;  // of the share that must match in the end
  static constexpr double kHopeless = 0.85;

  /// Refines a guess and adds what it turns to by colour, as far as its shape has a chance: a turn
  /// by colour keeps the shape, and what is far off after half the rounds does not come right.
  void Follow(const Pose& X_CM) {
    const auto refined = [&](const Pose& X) {
      return Verified(RefinePose(model_, X, view_, label_, 2, &rasteriser_));
    };
    const auto is_hopeless = [&](const Hypothesis& h, double share) {
      return h.verification.matching < share * config_.verify.min_matching * h.verification.visible;
    };
    Hypothesis hypothesis = refined(X_CM);
    if (!is_hopeless(hypothesis, kHopelessHalfway)) {
      hypothesis = refined(hypothesis.X_CM);
      if (!is_hopeless(hypothesis, kHopeless)) {
        for (const Pose& X : TurnByColor(model_, hypothesis.X_CM, view_, label_, 4)) Add(X);
        return;
      }
    }
    found_.push_back(std::move(hypothesis));
  }

  void Add(const Pose& X_CM) { found_.push_back(Verified(X_CM)); }

  void AddAccepted(const Pose& X_CM) {
    Hypothesis hypothesis = Verified(X_CM);
    if (hypothesis.verification.accepted) found_.push_back(std::move(hypothesis));
  }

  Hypothesis Verified(const Pose& X_CM) {
    Hypothesis hypothesis;
    hypothesis.model = model_.name;
    hypothesis.X_CM = X_CM;
    hypothesis.verification = Verify(model_, X_CM, view_, label_, inner_pixels_, config_.verify,
                                     &rasteriser_, &hypothesis.score);
    return hypothesis;
  }

  /// Keeps the first of the poses that are nearer to each other than this, and no more than `most`.
  void KeepDistinct(double distance, double angle, int most) {
    std::vector<Hypothesis> kept;
    for (Hypothesis& hypothesis : found_) {
      if (static_cast<int>(kept.size()) >= most) break;
      const bool known = std::any_of(kept.begin(), kept.end(), [&](const Hypothesis& other) {
        const PoseDistance d = DistanceUpToSymmetry(other.X_CM, hypothesis.X_CM, model_.symmetry,
                                                    model_.center_M, true);
        return d.translation < distance && d.rotation < angle;
      });
      if (!known) kept.push_back(std::move(hypothesis));
    }
    found_ = std::move(kept);
  }

  /// Turns the best by a little, to where it fits better.
  void Polish() {
    Hypothesis& best = found_.front();
    const Pose X_polished = PolishByColor(model_, best.X_CM, view_, label_);
    for (const Pose& X_CM :
         {X_polished, RefinePose(model_, X_polished, view_, label_, 2, &rasteriser_)}) {
      Hypothesis polished = Verified(X_CM);
      if (polished.score > best.score) best = std::move(polished);
    }
    Settle(&best);
  }

  /// Settles the likeliest of the rivals that were fitted anew. What the symmetry of the shape made
  /// of the best is as settled as that.
  void SettleFitted(const Pose& X_best) {
    for (std::size_t i = 1; i < std::min(found_.size(), kSettledRivals); ++i) {
      const PoseDistance d =
          DistanceUpToSymmetry(X_best, found_[i].X_CM, model_.symmetry, model_.center_M, false);
      if (d.translation > kSettledDistance || d.rotation > kSettledAngle) Settle(&found_[i]);
    }
  }

  /// Moves a pose to where depth, outline and colours together hold it: of poses so near to each
  /// other that their scores differ by chance, the one of the least squares is the most exact.
  void Settle(Hypothesis* hypothesis) {
    if (!hypothesis->verification.accepted) return;
    const JointPose joint = RefineTogether(model_, {PlacedModel{&view_, label_, hypothesis->X_CM}},
                                           kNoFreedom, 4, &rasteriser_);
    Hypothesis settled = Verified(joint.X_CM.front());
    const PoseDistance d = DistanceUpToSymmetry(hypothesis->X_CM, settled.X_CM, model_.symmetry,
                                                model_.center_M, true);
    const bool same = d.translation < kSameDistance && d.rotation < kSamePeak;
    if (!same || !settled.verification.accepted) return;
    if (LogOdds(settled.score) > LogOdds(hypothesis->score) - kByChance) {
      *hypothesis = std::move(settled);
    }
  }

  /// Turned about the support plane's normal, what shows of it staying where it is.
  Pose TurnedOnTheSpot(const Pose& X_CM, double angle) const {
    const Eigen::Vector3d& up_C = view_.plane_C.normal_A;
    const Eigen::Vector3d up_M = X_CM.linear().transpose() * up_C;
    Pose X_CT = X_CM * TurnAbout({model_.center_M, up_M}, angle);
    const Eigen::Vector3d shift = VisibleMean(model_, X_CM) - VisibleMean(model_, X_CT);
    X_CT.translation() += shift - shift.dot(up_C) * up_C;
    return X_CT;
  }

  /// What fits as well as the best after a turn is a hypothesis of its own; what fits better takes
  /// over.
  void AddRivals(const Pose& X_best) {
    const auto stands = [&](const Pose& turn) {
      return !LeavesItsRest(model_, X_best, turn, view_.plane_C.normal_A);
    };
    const auto points = static_cast<int>(std::min<std::size_t>(kPoints, model_.points.size()));
    const auto quality = [&](const Pose& X_CM) {
      return MatchPoints(model_, X_CM, view_, label_, inner_pixels_, points).quality;
    };
    const auto agreement = [&](const Pose& X_CM) {
      return PointColorAgreement(model_, X_CM, view_, label_, points);
    };
    const double least_quality = kRivalShare * quality(X_best);
    const double least_agreement = agreement(X_best) - kRivalColor;
    /// By its points, which cost a hundredth of rendering it. Colours that are NaN say nothing.
    const auto is_hopeless = [&](const Pose& X_CM) {
      return quality(X_CM) < least_quality || agreement(X_CM) < least_agreement;
    };
    const auto add = [&](const std::vector<Pose>& turns) {
      for (const Pose& turn : turns) {
        const Pose X_CM = X_best * turn;
        if (stands(turn) && !is_hopeless(X_CM)) AddAccepted(X_CM);
      }
    };
    std::vector<Pose> nudges = RivalTurns(model_, kNudge);
    std::erase_if(nudges, [](const Pose& turn) {
      return RotationDistance(Eigen::Matrix3d::Identity(), turn.linear()) > 1.01 * kNudge;
    });
    add(nudges);
    add(RivalTurns(model_, kRivalTurn));
    // Where the shape is nearly the same, it has to be fitted again.
    std::vector<Pose> fits;
    for (const Pose& turn : BoxTurns(model_)) {
      if (stands(turn)) fits.push_back(X_best * turn);
    }
    for (int i = 1; i < kSpotTurns; ++i) {
      fits.push_back(TurnedOnTheSpot(X_best, 2.0 * std::numbers::pi * i / kSpotTurns));
    }
    for (const Pose& fit : fits) {
      const Pose X_CM = AlignPoints(model_, fit, view_, label_, points, 5, 0.025);
      if (is_hopeless(X_CM)) continue;
      const PoseDistance d =
          DistanceUpToSymmetry(X_best, X_CM, model_.symmetry, model_.center_M, true);
      if (d.rotation < kNudge) continue;
      AddAccepted(RefinePose(model_, X_CM, view_, label_, 3, &rasteriser_));
    }
  }

  /// What the colours where the poses differ from the first make of the log-odds of each. Colours
  /// do not make good what the shape refuses. @pre there is a pose.
  std::vector<double> OddsByColor() {
    std::vector<double> odds{LogOdds(found_.front().score)};
    if (found_.size() == 1) return odds;
    const PosedColors first(model_, found_.front().X_CM, view_);
    for (std::size_t i = 1; i < found_.size(); ++i) {
      const Hypothesis& h = found_[i];
      double lead = first.LogRatio(PosedColors(model_, h.X_CM, view_)).value_or(0.0);
      if (!h.verification.accepted) lead = std::max(lead, 0.0);
      odds.push_back(LogOdds(h.score) - lead);
    }
    return odds;
  }

  /// The likeliest first, by the colours, too. The scores stay as they are: those of the next round
  /// have to be held against them.
  void SortByColor() {
    const std::vector<double> odds = OddsByColor();
    std::vector<std::size_t> order(found_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return odds[a] > odds[b]; });
    std::vector<Hypothesis> sorted;
    for (const std::size_t i : order) sorted.push_back(std::move(found_[i]));
    found_ = std::move(sorted);
  }

  /// Weighs the poses against each other by the colours where they differ, too. The likeliest keeps
  /// its score, as the model as a whole is no likelier for it; the others get what they lack of it.
  void CompareColors() {
    const std::vector<double> odds = OddsByColor();
    const auto best = std::max_element(odds.begin(), odds.end());
    const double score = LogOdds(found_[static_cast<std::size_t>(best - odds.begin())].score);
    for (std::size_t i = 0; i < found_.size(); ++i) {
      found_[i].score = 1.0 / (1.0 + std::exp(*best - odds[i] - score));
    }
  }

  const RecognitionModel& model_;
  const View& view_;
  int label_;
  int inner_pixels_;
  const RecogniseConfig& config_;
  geometry::DepthRasteriser rasteriser_;
  std::vector<Hypothesis> found_;
};

/// True when nothing needs to tell two poses of one model apart: surfaces and colours coincide, but
/// for a fiftieth of the points.
bool LooksAlike(const RecognitionModel& model, const Hypothesis& a, const Hypothesis& b) {
  constexpr std::size_t kPoints = 300;
  constexpr float kDistance = 0.003F;     // [m]
  constexpr float kColorDistance = 0.2F;  // of the largest difference of RGB in [0, 1]
  const Pose X_AB = a.X_CM.inverse() * b.X_CM;
  const Eigen::Matrix3f R = X_AB.linear().cast<float>();
  const Eigen::Vector3f t = X_AB.translation().cast<float>();
  const std::size_t count = std::min(kPoints, model.points.size());
  std::size_t differing = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f p = R * model.points[i].point + t;
    const auto nearest =
        std::min_element(model.points.begin(), model.points.end(),
                         [&](const ModelPoint& one, const ModelPoint& other) {
                           return (one.point - p).squaredNorm() < (other.point - p).squaredNorm();
                         });
    // Along the normal: the spacing of the points is no distance.
    const float off = std::abs(nearest->normal.dot(p - nearest->point));
    const float color = (nearest->color - model.points[i].color).cwiseAbs().maxCoeff();
    if (off > kDistance || color > kColorDistance) ++differing;
  }
  return count > 0 && 50 * differing <= count;
}

/// True when two hypotheses of one model are the same answer.
bool NeedNotBeToldApart(const std::vector<RecognitionModel>& models, const Hypothesis& a,
                        const Hypothesis& b, const RecogniseConfig& config) {
  const RecognitionModel* model = FindModel(models, a.model);
  if (model == nullptr) return false;
  const PoseDistance d =
      DistanceUpToSymmetry(a.X_CM, b.X_CM, model->symmetry, model->center_M, true);
  const bool near = d.translation < config.tolerance_m &&
                    d.rotation < config.tolerance_deg * std::numbers::pi / 180.0;
  return near || LooksAlike(*model, a, b);
}

}  // namespace

void RecogniseConfig::Validate() const {
  verify.Validate();
  posterior.Validate();
  CheckRange(guesses_per_model, 1, 1000, "guesses_per_model");
  CheckRange(hypotheses_per_model, 1, 1000, "hypotheses_per_model");
  CheckRange(min_guess_share, 0.0, 1.0, "min_guess_share");
  CheckRange(min_score, 0.0, 1.0, "min_score");
  CheckRange(min_lead, 0.0, 100.0, "min_lead");
  CheckRange(tolerance_m, 0.0, 1.0, "tolerance_m");
  CheckRange(tolerance_deg, 0.0, 180.0, "tolerance_deg");
}

std::vector<world::Detection> Recognise(const View& view,
                                        const std::vector<world::Cluster>& clusters,
                                        const std::vector<RecognitionModel>& models,
                                        const RecogniseConfig& config) {
  const auto cluster_count = static_cast<int>(clusters.size());
  const auto model_count = static_cast<int>(models.size());
  std::vector<std::vector<geometry::OrientedPoint>> surfaces(clusters.size());
  std::vector<int> inner(clusters.size());
  ParallelFor(cluster_count, [&](int c) {
    const auto i = static_cast<std::size_t>(c);
    surfaces[i] = OrientCluster(view, c, clusters[i]);
    inner[i] = InnerPixels(view, c, clusters[i]);
  });
  std::vector<std::vector<PoseGuess>> guesses(clusters.size() * models.size());
  ParallelFor(cluster_count * model_count, [&](int k) {
    const auto c = static_cast<std::size_t>(k / model_count);
    guesses[static_cast<std::size_t>(k)] =
        HypothesisePoses(models[static_cast<std::size_t>(k % model_count)], view,
                         static_cast<int>(c), clusters[c], surfaces[c], config.guesses_per_model);
  });
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    double best = 0.0;
    for (std::size_t m = 0; m < models.size(); ++m) {
      const auto& list = guesses[c * models.size() + m];
      if (!list.empty()) best = std::max(best, list.front().quality);
    }
    for (std::size_t m = 0; m < models.size(); ++m) {
      std::erase_if(guesses[c * models.size() + m], [&](const PoseGuess& guess) {
        return guess.quality <= 0.02 || guess.quality < config.min_guess_share * best;
      });
    }
  }
  std::vector<std::vector<Hypothesis>> examined(guesses.size());
  ParallelFor(cluster_count * model_count, [&](int k) {
    const auto index = static_cast<std::size_t>(k);
    const int c = k / model_count;
    examined[index] = Examination(models[static_cast<std::size_t>(k % model_count)], view, c,
                                  inner[static_cast<std::size_t>(c)], config)
                          .Run(guesses[index]);
  });

  std::vector<world::Detection> detections(clusters.size());
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    world::Detection& detection = detections[c];
    detection.cluster = clusters[c];
    for (std::size_t m = 0; m < models.size(); ++m) {
      for (Hypothesis& h : examined[c * models.size() + m]) {
        detection.hypotheses.push_back(std::move(h));
      }
    }
    std::stable_sort(detection.hypotheses.begin(), detection.hypotheses.end(),
                     [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
    SetProbabilities(config.posterior, &detection.hypotheses);
    const bool accepted = std::any_of(detection.hypotheses.begin(), detection.hypotheses.end(),
                                      [](const Hypothesis& h) { return h.verification.accepted; });
    if (accepted) continue;
    if (detection.hypotheses.empty()) {
      detection.reason = fmt::format("none of {} models fits the {} pixels in any pose",
                                     models.size(), clusters[c].pixels.size());
    } else {
      const Hypothesis& nearest = detection.hypotheses.front();
      detection.reason =
          fmt::format("nearest is {}: {}", nearest.model, nearest.verification.reason);
    }
  }
  return detections;
}

std::vector<Choice> ChooseHypotheses(const std::vector<world::Detection>& detections,
                                     const std::vector<RecognitionModel>& models,
                                     const RecogniseConfig& config) {
  std::vector<Choice> choices;
  for (const world::Detection& detection : detections) {
    Choice choice;
    choice.reason = detection.reason;
    for (std::size_t i = 0; i < detection.hypotheses.size(); ++i) {
      const Hypothesis& h = detection.hypotheses[i];
      if (!h.verification.accepted) continue;
      if (h.score < config.min_score) {
        choice.reason = fmt::format("{} fits with a score of {:.3f} (at least {:.3f})", h.model,
                                    h.score, config.min_score);
        break;
      }
      choice.hypothesis = static_cast<int>(i);
      choice.reason.clear();
      for (std::size_t k = 0; k < detection.hypotheses.size(); ++k) {
        const Hypothesis& rival = detection.hypotheses[k];
        const double lead = LogOdds(h.score) - LogOdds(rival.score);
        if (k == i || lead >= config.min_lead) continue;
        if (rival.model == h.model && NeedNotBeToldApart(models, h, rival, config)) continue;
        choice.hypothesis = -1;
        choice.reason = fmt::format(
            "{} (score {:.3f}) is not enough ahead of {} (score {:.3f}): the log-odds differ by "
            "{:.2f} (at least {:.2f})",
            h.model, h.score, rival.model == h.model ? "another pose of it" : rival.model,
            rival.score, lead, config.min_lead);
        break;
      }
      break;
    }
    choices.push_back(std::move(choice));
  }
  return choices;
}

}  // namespace secondlook::perception

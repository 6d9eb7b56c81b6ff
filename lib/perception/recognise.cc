#include "lib/perception/recognise.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "lib/common/check_range.h"
#include "lib/common/parallel.h"
#include "lib/perception/hypothesise.h"
#include "lib/perception/refine.h"
#include "lib/perception/turn_by_color.h"

namespace secondlook::perception {
namespace {

using world::Hypothesis;

constexpr double kSameDistance = 0.010;                       // [m]
constexpr double kSamePeak = 9.0 * std::numbers::pi / 180.0;  // [rad]

constexpr double kTurn = 10.0 * std::numbers::pi / 180.0;  // [rad]

/// Keeps the best of poses that no one can tell apart, at most `count`. Best first.
std::vector<Hypothesis> KeepDistinct(std::vector<Hypothesis> hypotheses,
                                     const RecognitionModel& model, int count) {
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
  std::vector<Hypothesis> kept;
  for (Hypothesis& hypothesis : hypotheses) {
    if (static_cast<int>(kept.size()) >= count) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Hypothesis& other) {
      const PoseDistance d =
          DistanceUpToSymmetry(other.X_CM, hypothesis.X_CM, model.symmetry, model.center_M, true);
      return d.translation < kSameDistance && d.rotation < kSamePeak;
    });
    if (!known) kept.push_back(std::move(hypothesis));
  }
  return kept;
}

/// The turns of X_CM about the centre by `angle` that the symmetry does not take back, about three
/// axes of M: the continuous axis or z, and two across.
std::vector<Pose> Neighbours(const RecognitionModel& model, const Pose& X_CM, double angle) {
  const Eigen::Vector3d first =
      model.symmetry.axis ? model.symmetry.axis->direction : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d second = first.unitOrthogonal();
  std::vector<Pose> poses;
  for (const Eigen::Vector3d& direction : {first, second, Eigen::Vector3d(first.cross(second))}) {
    for (const double sign : {-1.0, 1.0}) {
      poses.push_back(X_CM * TurnAbout({model.center_M, direction}, sign * angle));
    }
  }
  return poses;
}

/// Refines the guesses of one model, turns them by colour, and verifies each.
std::vector<Hypothesis> Examine(const RecognitionModel& model,
                                const std::vector<PoseGuess>& guesses, const View& view, int label,
                                int inner_pixels, const RecogniseConfig& config) {
  geometry::DepthRasteriser rasteriser;
  std::vector<Hypothesis> hypotheses;
  for (const PoseGuess& guess : guesses) {
    const Pose X_refined = RefinePose(model, guess.X_CM, view, label, 4, &rasteriser);
    for (const Pose& X_CM : TurnByColor(model, X_refined, view, label, 4)) {
      Hypothesis hypothesis;
      hypothesis.model = model.name;
      hypothesis.X_CM = X_CM;
      hypothesis.verification = Verify(model, X_CM, view, label, inner_pixels, config.verify,
                                       &rasteriser, &hypothesis.score);
      hypotheses.push_back(std::move(hypothesis));
    }
  }
  hypotheses = KeepDistinct(std::move(hypotheses), model, config.hypotheses_per_model);
  if (hypotheses.empty() || !hypotheses.front().verification.accepted) return hypotheses;
  // Is the pose held by what is seen? What fits as well after a turn is a hypothesis of its own;
  // what fits better takes over.
  const auto verify = [&](const Pose& X_CM) {
    Hypothesis hypothesis;
    hypothesis.model = model.name;
    hypothesis.X_CM = X_CM;
    hypothesis.verification = Verify(model, X_CM, view, label, inner_pixels, config.verify,
                                     &rasteriser, &hypothesis.score);
    return hypothesis;
  };
  const Pose X_polished = PolishByColor(model, hypotheses.front().X_CM, view, label);
  const Pose X_refined = RefinePose(model, X_polished, view, label, 2, &rasteriser);
  for (const Pose& X_CM : {X_polished, X_refined}) hypotheses.push_back(verify(X_CM));
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
  for (const Pose& X_CM : Neighbours(model, hypotheses.front().X_CM, kTurn)) {
    Hypothesis turned = verify(X_CM);
    if (turned.verification.accepted) hypotheses.push_back(std::move(turned));
  }
  return KeepDistinct(std::move(hypotheses), model, config.hypotheses_per_model);
}

/// True when nothing needs to tell two poses of one model apart: surfaces and colours coincide, but
/// for a fiftieth of the points.
bool LooksAlike(const std::vector<RecognitionModel>& models, const Hypothesis& a,
                const Hypothesis& b) {
  constexpr std::size_t kPoints = 300;
  constexpr float kDistance = 0.003F;     // [m]
  constexpr float kColorDistance = 0.2F;  // of the largest difference of RGB in [0, 1]
  const RecognitionModel* model = FindModel(models, a.model);
  if (model == nullptr) return false;
  const Pose X_AB = a.X_CM.inverse() * b.X_CM;
  const Eigen::Matrix3f R = X_AB.linear().cast<float>();
  const Eigen::Vector3f t = X_AB.translation().cast<float>();
  const std::size_t count = std::min(kPoints, model->points.size());
  std::size_t differing = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f p = R * model->points[i].point + t;
    const auto nearest =
        std::min_element(model->points.begin(), model->points.end(),
                         [&](const ModelPoint& one, const ModelPoint& other) {
                           return (one.point - p).squaredNorm() < (other.point - p).squaredNorm();
                         });
    // Along the normal: the spacing of the points is no distance.
    const float off = std::abs(nearest->normal.dot(p - nearest->point));
    const float color = (nearest->color - model->points[i].color).cwiseAbs().maxCoeff();
    if (off > kDistance || color > kColorDistance) ++differing;
  }
  return count > 0 && 50 * differing <= count;
}

double LogOdds(double score) {
  const double bounded = std::clamp(score, 1e-15, 1.0 - 1e-15);
  return std::log(bounded / (1.0 - bounded));
}

}  // namespace

void RecogniseConfig::Validate() const {
  verify.Validate();
  CheckRange(guesses_per_model, 1, 1000, "guesses_per_model");
  CheckRange(hypotheses_per_model, 1, 1000, "hypotheses_per_model");
  CheckRange(min_guess_share, 0.0, 1.0, "min_guess_share");
  CheckRange(min_score, 0.0, 1.0, "min_score");
  CheckRange(min_lead, 0.0, 100.0, "min_lead");
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
    examined[index] = Examine(models[static_cast<std::size_t>(k % model_count)], guesses[index],
                              view, c, inner[static_cast<std::size_t>(c)], config);
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
        if (rival.model == h.model && LooksAlike(models, h, rival)) continue;
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

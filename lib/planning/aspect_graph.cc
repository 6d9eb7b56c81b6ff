#include "lib/planning/aspect_graph.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "lib/common/parallel.h"
#include "lib/perception/verify.h"
#include "lib/planning/environment_analysis.h"
#include "lib/planning/look_check.h"
#include "lib/planning/rim.h"

namespace secondlook::planning {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// What a view may give: with the chance `survival` that nothing stands in unknown space, and
/// without.
class Prospects {
 public:
  Prospects(int alternatives, double pixels_a_ray, double novelty, const AspectGraphConfig& config)
      : pixels_a_ray_(pixels_a_ray), novelty_(novelty), config_(config) {
    open_ = Eigen::MatrixXd::Zero(alternatives, alternatives);
    closed_ = open_;
  }

  /// Notes what tells alternative i from j, of which `difference` is seen on each ray with news.
  void Set(int i, int j, const NewsRays& rays, double difference) {
    if (rays.all == 0.0) return;
    const double pixels = rays.all * pixels_a_ray_;
    const double each =
        config_.evidence * novelty_ * difference * pixels / (pixels + config_.few_px) / rays.all;
    open_(i, j) = open_(j, i) = each * rays.arriving;
    closed_(i, j) = closed_(j, i) = each * rays.through_free;
  }

  /// If alternative i is true, the view shows it only with this chance.
  void Doubt(int i, double chance) {
    open_.row(i) *= chance;
    closed_.row(i) *= chance;
  }

  std::vector<Prospect> List() const {
    if (open_ == closed_) return {{1.0, open_}};
    return {{config_.unknown_survival, open_}, {1.0 - config_.unknown_survival, closed_}};
  }

 private:
  double pixels_a_ray_;
  double novelty_;
  const AspectGraphConfig& config_;
  Eigen::MatrixXd open_;
  Eigen::MatrixXd closed_;
};

/// What is believed of the target: its hypotheses and, last, none of them.
Belief BeliefOf(const AspectTarget& target) {
  Belief belief;
  if (target.id < 0) {
    belief.incomplete = 1.0;
    return belief;
  }
  double none = target.none;
  if (target.hypotheses.empty()) {
    belief.alternatives.push_back({1.0 - target.none});  // a model that did not come to mind yet
  } else {
    none = 1.0;
    for (const PosedModel& model : target.hypotheses) {
      belief.alternatives.push_back({model.belief, model.needed});
      none -= model.belief;
    }
  }
  belief.alternatives.push_back({std::max(0.0, none)});
  return belief;
}

/// 0 .. 1: what a view counts that is `angle` [rad] from the nearest one before, at least
/// `same_view_novelty`.
double NoveltyAt(double angle, const AspectTarget& target, const AspectGraphConfig& config) {
  const double same = config.same_view_deg * kDegree;
  const double new_view =
      (target.hypotheses.empty() ? config.new_view_unknown_deg : config.new_view_deg) * kDegree;
  const double share = std::clamp((angle - same) / (new_view - same), 0.0, 1.0);
  return config.same_view_novelty + (1.0 - config.same_view_novelty) * share;
}

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0));
}

/// From the target to the camera.
Eigen::Vector3d DirectionOf(const AspectTarget& target, const Pose& X_WC) {
  return (X_WC.translation() - target.box_W.center()).normalized();
}

/// The novelty of `direction_W` against all that were seen.
double Novelty(const Eigen::Vector3d& direction_W, const AspectTarget& target,
               const AspectGraphConfig& config) {
  double nearest = std::numbers::pi;
  for (const Eigen::Vector3d& seen_W : target.seen_from_W) {
    nearest = std::min(nearest, AngleBetween(seen_W, direction_W));
  }
  return NoveltyAt(nearest, target, config);
}

/// The beliefs, summing to 1.
std::vector<double> Beliefs(const std::vector<PosedModel>& hypotheses) {
  double sum = 0.0;
  for (const PosedModel& model : hypotheses) sum += model.belief;
  std::vector<double> beliefs;
  for (const PosedModel& model : hypotheses) {
    beliefs.push_back(sum > 0.0 ? model.belief / sum
                                : 1.0 / static_cast<double>(hypotheses.size()));
  }
  return beliefs;
}

/// The chance that a view accepts a hypothesis of which it shows so much that is no rim.
double AcceptanceChance(double inner_share) {
  constexpr double kSigma = 0.1;  // of InnerShare(), which asks few rays
  const double least = perception::VerifyConfig().min_inner;
  return 0.5 * std::erfc((least - inner_share) / (std::numbers::sqrt2 * kSigma));
}

AspectScore Analyse(const world::VoxelSpace& space, const geometry::CameraModel& real_camera,
                    double scale, const AspectTarget& target, const Pose& X_WC,
                    const AspectGraphConfig& config) {
  const geometry::CameraModel camera = real_camera.Scaled(scale);
  const double pixels_a_ray = 1.0 / (scale * scale);
  AspectScore score;
  score.novelty = Novelty(DirectionOf(target, X_WC), target, config);
  const BoxRays cast = CastToBox(space, camera, X_WC, target.box_W, config);
  const std::vector<BoxRay>& rays = cast.rays;
  score.box_rays = static_cast<int>(rays.size());
  score.blocked = cast.blocked;
  score.through_unknown = cast.through_unknown;
  score.surviving = cast.surviving;
  std::vector<std::vector<geometry::RayHit>> hits;
  for (const PosedModel& model : target.hypotheses) {
    hits.push_back(CastAt(model, X_WC, rays));
    score.models.push_back(Visibility(model, camera, rays, hits.back()));
  }
  score.view_score = CompromiseScore(score.models);
  if (target.hypotheses.empty()) {  // the box stands for the model
    score.view_score = score.box_rays * (1.0 - score.blocked) /
                       (static_cast<double>(camera.width) * camera.height);
  }

  const int none = std::max<int>(1, static_cast<int>(hits.size()));
  Prospects prospects(target.id < 0 ? 0 : none + 1, pixels_a_ray, score.novelty, config);
  if (hits.empty() && target.id >= 0) prospects.Set(0, none, RaysTo(nullptr, rays), config.unlike);
  const std::vector<double> beliefs = Beliefs(target.hypotheses);
  double pairs = 0.0;
  for (int i = 0; i < static_cast<int>(hits.size()); ++i) {
    prospects.Set(i, none, RaysTo(&hits[i], rays), config.unlike);
    for (int j = 0; j < i; ++j) {
      const NewsRays differing =
          DifferingRays(target.hypotheses[i], hits[i], target.hypotheses[j], hits[j], rays, config);
      prospects.Set(i, j, differing, 1.0);
      const double weight = beliefs[i] * beliefs[j];
      if (!(weight > 0.0)) continue;
      pairs += weight;
      if (differing.all > 0.0) score.difference += weight * differing.arriving / differing.all;
    }
  }
  if (pairs > 0.0) score.difference /= pairs;
  for (int i = 0; i < static_cast<int>(hits.size()); ++i) {
    const double inner = InnerShare(target.hypotheses[i], real_camera, X_WC, rays, hits[i]);
    prospects.Doubt(i, AcceptanceChance(inner));
  }
  score.prospects = prospects.List();
  return score;
}

/// The mean of `share` of the hypotheses, by belief.
double MeanShare(const AspectTarget& target, const AspectScore& score,
                 double ModelVisibility::*share) {
  if (target.hypotheses.empty()) return score.surviving;
  const std::vector<double> beliefs = Beliefs(target.hypotheses);
  double mean = 0.0;
  for (std::size_t i = 0; i < beliefs.size(); ++i) mean += beliefs[i] * score.models[i].*share;
  return mean;
}

/// The expected drop of the loss by a look with this score.
double Gain(const AspectTarget& target, const Belief& belief, const AspectScore& score,
            double visibility, const AspectGraphConfig& config) {
  if (target.id < 0) return config.loss.incomplete * score.novelty * visibility;
  return Loss(belief, config.loss) - ExpectedLoss(Outcomes(belief, score.prospects), config.loss);
}

/// Gains per second, one a look; 0 where a look is not feasible.
std::vector<double> ScoresLookingAhead(const AspectTarget& target, const Belief& belief,
                                       const AspectGraph& graph, const AspectGraphConfig& config) {
  std::vector<double> scores(graph.looks.size(), 0.0);
  std::vector<int> feasible;
  std::vector<LookOption> options;
  for (int i = 0; i < static_cast<int>(graph.looks.size()); ++i) {
    const world::Look& look = graph.looks[i];
    if (!look.feasible) continue;
    const double seconds = look.seconds + config.look_seconds;
    scores[i] = look.gain / seconds;
    feasible.push_back(i);
    options.push_back({seconds, graph.scores[i].prospects});
  }
  if (target.id < 0) return scores;
  const auto after = [&](int first, int second) -> Sequel {
    const world::Look& a = graph.looks[feasible[first]];
    const world::Look& b = graph.looks[feasible[second]];
    const double novelty = NoveltyAt(
        AngleBetween(DirectionOf(target, a.X_WC), DirectionOf(target, b.X_WC)), target, config);
    const double before = graph.scores[feasible[second]].novelty;
    // Round the target, not through what it stands on.
    const Eigen::Vector2d center = target.box_W.center().head<2>();
    const Eigen::Vector2d to_a = Eigen::Vector2d(a.X_WB.x, a.X_WB.y) - center;
    const Eigen::Vector2d to_b = Eigen::Vector2d(b.X_WB.x, b.X_WB.y) - center;
    const double turn =
        std::abs(WrapAngle(std::atan2(to_b.y(), to_b.x()) - std::atan2(to_a.y(), to_a.x())));
    const double metres = turn * to_a.norm() + std::abs(to_b.norm() - to_a.norm());
    const double seconds = b.way == world::LookWay::kArm ? b.seconds : metres / config.ahead_speed;
    return {seconds + config.look_seconds, std::min(1.0, novelty / before)};
  };
  const std::vector<double> gains =
      GainsLookingAhead(belief, options, after, config.loss, config.look_ahead);
  for (std::size_t i = 0; i < feasible.size(); ++i) scores[feasible[i]] = gains[i];
  return scores;
}

/// What the strategy "fixed step" scores: 2 in the direction it wants, 0 opposite to it.
double StepScore(const AspectTarget& target, const world::Look& look,
                 const AspectGraphConfig& config) {
  if (target.seen_from_W.empty()) return 1.0;
  const Eigen::Vector3d last_W = target.seen_from_W.back();
  const double wanted = std::atan2(last_W.y(), last_W.x()) + config.fixed_step_deg * kDegree;
  const Eigen::Vector3d way_W = look.X_WC.translation() - target.box_W.center();
  return 1.0 + std::cos(std::atan2(way_W.y(), way_W.x()) - wanted);
}

double StrategyScore(LookStrategy strategy, const AspectTarget& target, const AspectScore& score,
                     const world::Look& look, const AspectGraphConfig& config, Rng* rng) {
  switch (strategy) {
    case LookStrategy::kExpectedLoss:
      return look.score;  // ScoresLookingAhead()
    case LookStrategy::kMcGreavy:
      return score.view_score;
    case LookStrategy::kNearest:
      return 1.0 / (1.0 + look.seconds);
    case LookStrategy::kRandom:
      return rng->Uniform(0.0, 1.0);
    case LookStrategy::kFixedStep:
      return StepScore(target, look, config);
  }
  return 0.0;
}

/// Does the look see enough, and bring enough for its time?
void CheckWorth(const AspectTarget& target, const AspectScore& score,
                const AspectGraphConfig& config, world::Look* look) {
  const double seen = MeanShare(target, score, &ModelVisibility::seen);
  look->feasible &= AddCheck(
      "visible", seen >= config.min_visibility,
      fmt::format("{:.0f} % of the target by {} rays to its box ({:.0f} % blocked, {:.0f} % "
                  "through unknown space); at least {:.0f} % wanted",
                  100.0 * seen, score.box_rays, 100.0 * score.blocked,
                  100.0 * score.through_unknown, 100.0 * config.min_visibility),
      look);
  if (!look->feasible) return;
  look->feasible &= AddCheck(
      "worth its time", look->score >= config.loss.per_second,
      fmt::format("{:.2g} a second, {:.2g} of it by the first look; at least {:.2g} wanted",
                  look->score, look->gain / (look->seconds + config.look_seconds),
                  config.loss.per_second),
      look);
}

}  // namespace

AspectGraph ScoreAspectGraph(const world::VoxelSpace& space, const geometry::CameraModel& camera,
                             const AspectTarget& target, std::vector<world::Look> looks, Rng* rng,
                             const AspectGraphConfig& config) {
  config.Validate();
  camera.Validate("of the aspect graph");
  RequireValid(target);
  const LookStrategy strategy = ParseLookStrategy(config.strategy);
  const int columns = target.id < 0 ? config.region_ray_columns : config.ray_columns;
  const double scale = static_cast<double>(columns) / camera.width;
  const Belief belief = BeliefOf(target);
  AspectGraph graph{std::move(looks), {}};
  const int count = static_cast<int>(graph.looks.size());
  graph.scores.resize(count);
  ParallelFor(count, [&](int i) {
    world::Look& look = graph.looks[i];
    if (!look.feasible) return;
    AspectScore& score = graph.scores[i];
    score = Analyse(space, camera, scale, target, look.X_WC, config);
    look.visibility = MeanShare(target, score, &ModelVisibility::box_share);
    look.gain = Gain(target, belief, score, look.visibility, config);
  });
  if (strategy == LookStrategy::kExpectedLoss) {
    const std::vector<double> scores = ScoresLookingAhead(target, belief, graph, config);
    for (int i = 0; i < count; ++i) graph.looks[i].score = scores[i];
  }
  for (int i = 0; i < count; ++i) {
    world::Look& look = graph.looks[i];
    if (!look.feasible) continue;
    look.score = StrategyScore(strategy, target, graph.scores[i], look, config, rng);
    if (strategy == LookStrategy::kExpectedLoss) CheckWorth(target, graph.scores[i], config, &look);
  }
  return graph;
}

}  // namespace secondlook::planning

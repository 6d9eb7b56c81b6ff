#include "lib/planning/aspect_graph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/common/parallel.h"
#include "lib/geometry/point_image.h"
#include "lib/planning/look_check.h"

namespace secondlook::planning {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

constexpr std::array<std::pair<const char*, LookStrategy>, 5> kStrategies = {
    {{"expected loss", LookStrategy::kExpectedLoss},
     {"McGreavy", LookStrategy::kMcGreavy},
     {"nearest", LookStrategy::kNearest},
     {"random", LookStrategy::kRandom},
     {"fixed step", LookStrategy::kFixedStep}}};

/// A ray of the modelled camera that meets the target's box.
struct BoxRay {
  Eigen::Vector3d direction_W;  ///< 1 along the optical axis, so distances are depths.
  double chance{};              ///< To arrive at the box, in [0, 1]; 0: stopped.
  bool stopped{};
  bool through_unknown{};
};

/// Where the ray from `from_W` enters the box; empty when it misses it. 0 from inside.
std::optional<double> Entry(const Eigen::AlignedBox3d& box_W, const Eigen::Vector3d& from_W,
                            const Eigen::Vector3d& direction_W) {
  double enter = 0.0;
  double leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box_W.min()[axis] - from_W[axis];
    const double high = box_W.max()[axis] - from_W[axis];
    if (direction_W[axis] == 0.0) {
      if (low > 0.0 || high < 0.0) return std::nullopt;
      continue;
    }
    const double a = low / direction_W[axis];
    const double b = high / direction_W[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave) return std::nullopt;
  return enter;
}

/// The pixels, first and last along each axis, outside of which no ray meets the box.
struct PixelRange {
  Eigen::Vector2i first;
  Eigen::Vector2i last;
};

PixelRange Projection(const Eigen::AlignedBox3d& box_W, const geometry::CameraModel& camera,
                      const Pose& X_WC) {
  const Eigen::Vector2i end(camera.width - 1, camera.height - 1);
  Eigen::AlignedBox2d pixels;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p_CQ =
        X_WC.inverse() * box_W.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    if (p_CQ.z() < 1e-3) return {Eigen::Vector2i::Zero(), end};  // beside or behind the lens
    pixels.extend(Eigen::Vector2d(camera.fx * p_CQ.x() / p_CQ.z() + camera.cx,
                                  camera.fy * p_CQ.y() / p_CQ.z() + camera.cy));
  }
  const auto clamp = [&](const Eigen::Array2d& pixel) -> Eigen::Vector2i {
    return pixel.max(-1.0).min(end.cast<double>().array() + 1.0).cast<int>();
  };
  return {clamp(pixels.min().array().ceil()).cwiseMax(0),
          clamp(pixels.max().array().floor()).cwiseMin(end)};
}

/// The environment analysis of one candidate.
std::vector<BoxRay> SurvivingRays(const world::VoxelSpace& space,
                                  const geometry::CameraModel& camera, const Pose& X_WC,
                                  const Eigen::AlignedBox3d& box_W, const AspectGraphConfig& config,
                                  AspectScore* score) {
  // Not grown downwards: what lies below the target holds it and belongs to it nowhere.
  Eigen::AlignedBox3d around_W = box_W;
  around_W.min().head<2>().array() -= config.box_margin_m;
  around_W.max().array() += config.box_margin_m;

  const Eigen::Vector3d p_WC = X_WC.translation();
  const PixelRange range = Projection(box_W, camera, X_WC);
  const Eigen::Vector2i size = (range.last - range.first + Eigen::Vector2i::Ones()).cwiseMax(0);
  world::RayFan fan{camera, X_WC, range.first, size, {}};
  std::vector<BoxRay> rays;
  std::vector<std::size_t> pixels;  // of the fan, one a ray
  for (int v = range.first.y(); v <= range.last.y(); ++v) {
    for (int u = range.first.x(); u <= range.last.x(); ++u) {
      const Eigen::Vector3d direction_W = X_WC.linear() * camera.Ray(u, v);
      fan.depth.push_back(0.0);
      if (!Entry(box_W, p_WC, direction_W)) continue;
      fan.depth.back() = Entry(around_W, p_WC, direction_W).value_or(0.0);
      pixels.push_back(fan.depth.size() - 1);
      rays.push_back({direction_W, 1.0});
    }
  }
  const std::vector<world::Passage> passages = space.Cast(fan);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const world::Passage& passage = passages[pixels[i]];
    const bool through_unknown = !passage.blocked && passage.unknown > config.unknown_m;
    rays[i].stopped = passage.blocked;
    rays[i].through_unknown = through_unknown;
    rays[i].chance = passage.blocked ? 0.0 : through_unknown ? config.unknown_survival : 1.0;
    score->blocked += passage.blocked ? 1.0 : 0.0;
    score->through_unknown += through_unknown ? 1.0 : 0.0;
    score->surviving += rays[i].chance;
  }
  score->box_rays = static_cast<int>(rays.size());
  if (rays.empty()) return rays;
  score->blocked /= score->box_rays;
  score->through_unknown /= score->box_rays;
  score->surviving /= score->box_rays;
  return rays;
}

std::vector<geometry::RayHit> CastAt(const PosedModel& model, const Pose& X_WC,
                                     const std::vector<BoxRay>& rays) {
  const Pose X_MW = model.X_WM.inverse();
  const Eigen::Vector3f p_MC = (X_MW * X_WC.translation()).cast<float>();
  std::vector<geometry::Ray> rays_M;
  rays_M.reserve(rays.size());
  for (const BoxRay& ray : rays) {
    rays_M.push_back({p_MC, (X_MW.linear() * ray.direction_W).cast<float>()});
  }
  return model.caster->Cast(rays_M);
}

/// The model analysis of one candidate for one hypothesis.
ModelVisibility Visibility(const PosedModel& model, const geometry::CameraModel& camera,
                           const std::vector<BoxRay>& rays,
                           const std::vector<geometry::RayHit>& hits) {
  ModelVisibility visibility;
  const Eigen::Matrix3d R_MW = model.X_WM.linear().transpose();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits[i].triangle < 0 || rays[i].stopped) continue;
    visibility.box_share += rays[i].chance;
    visibility.view_share += 1.0;
    // A pixel's patch of a surface at depth z: z^2 / (fx fy |n . direction|).
    const double slant = std::abs(hits[i].normal_M.cast<double>().dot(R_MW * rays[i].direction_W));
    const double z = hits[i].distance;
    if (slant > 1e-3) visibility.area += rays[i].chance * z * z / (camera.fx * camera.fy * slant);
  }
  if (!rays.empty()) visibility.box_share /= static_cast<double>(rays.size());
  visibility.view_share /= static_cast<double>(camera.width) * camera.height;
  return visibility;
}

/// Sum minus the differences (McGreavy 2016, Multi-object Disambiguation).
double CompromiseScore(const std::vector<ModelVisibility>& models) {
  double score = 0.0;
  for (std::size_t i = 0; i < models.size(); ++i) {
    score += models[i].view_share;
    for (std::size_t j = 0; j < i; ++j) {
      score -= std::abs(models[i].view_share - models[j].view_share);
    }
  }
  return score;
}

/// True when the camera would measure something else on the two models.
bool Differs(const PosedModel& a, const geometry::RayHit& hit_a, const PosedModel& b,
             const geometry::RayHit& hit_b, const AspectGraphConfig& config) {
  if (hit_a.triangle < 0 || hit_b.triangle < 0) return true;  // one of them lets the ray by
  const double sigma = geometry::DepthSigma(0.5 * (hit_a.distance + hit_b.distance));
  if (std::abs(hit_a.distance - hit_b.distance) > config.depth_sigmas * sigma) return true;
  const Eigen::Vector3f color_a = geometry::ColorAt(*a.mesh, hit_a.triangle, hit_a.weights);
  const Eigen::Vector3f color_b = geometry::ColorAt(*b.mesh, hit_b.triangle, hit_b.weights);
  return (color_a - color_b).cwiseAbs().maxCoeff() > config.color_difference;
}

/// Of the rays to something, how many there are and on how many something new is seen: only past
/// what is known to be free, or also through what is unknown.
struct NewsRays {
  double all{};
  double through_free{};
  double arriving{};

  void Add(const BoxRay& ray, bool news) {
    all += 1.0;
    if (!news || ray.stopped) return;
    arriving += 1.0;
    if (!ray.through_unknown) through_free += 1.0;
  }
};

/// The rays to either model, and those on which they differ.
NewsRays DifferingRays(const PosedModel& a, const std::vector<geometry::RayHit>& hits_a,
                       const PosedModel& b, const std::vector<geometry::RayHit>& hits_b,
                       const std::vector<BoxRay>& rays, const AspectGraphConfig& config) {
  NewsRays differing;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits_a[i].triangle < 0 && hits_b[i].triangle < 0) continue;
    differing.Add(rays[i], !rays[i].stopped && Differs(a, hits_a[i], b, hits_b[i], config));
  }
  return differing;
}

/// The rays to the model; to the box when there is none.
NewsRays RaysTo(const std::vector<geometry::RayHit>* hits, const std::vector<BoxRay>& rays) {
  NewsRays seen;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (hits == nullptr || (*hits)[i].triangle >= 0) seen.Add(rays[i], true);
  }
  return seen;
}

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

AspectScore Analyse(const world::VoxelSpace& space, const geometry::CameraModel& camera,
                    double pixels_a_ray, const AspectTarget& target, const Pose& X_WC,
                    const AspectGraphConfig& config) {
  AspectScore score;
  score.novelty = Novelty(DirectionOf(target, X_WC), target, config);
  const std::vector<BoxRay> rays = SurvivingRays(space, camera, X_WC, target.box_W, config, &score);
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
  score.prospects = prospects.List();
  return score;
}

double MeanVisibility(const AspectTarget& target, const AspectScore& score) {
  if (target.hypotheses.empty()) return score.surviving;
  const std::vector<double> beliefs = Beliefs(target.hypotheses);
  double mean = 0.0;
  for (std::size_t i = 0; i < beliefs.size(); ++i) mean += beliefs[i] * score.models[i].box_share;
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

void Check(const AspectTarget& target) {
  const Eigen::AlignedBox3d& box_W = target.box_W;
  if (!box_W.min().allFinite() || !box_W.max().allFinite() || box_W.isEmpty() ||
      !(box_W.sizes().minCoeff() >= 0.001)) {
    Throw<InvalidArgument>(
        "aspect graph: the box of target {} from ({}, {}, {}) to ({}, {}, {}) m must be finite and "
        "at least 1 mm wide",
        target.id, box_W.min().x(), box_W.min().y(), box_W.min().z(), box_W.max().x(),
        box_W.max().y(), box_W.max().z());
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < target.hypotheses.size(); ++i) {
    const PosedModel& model = target.hypotheses[i];
    if (!IsValid(model.X_WM)) {
      Throw<InvalidArgument>(
          "aspect graph: X_WM of hypothesis {} of target {} is not finite and "
          "rigid",
          i, target.id);
    }
    if (model.mesh == nullptr || model.caster == nullptr) {
      Throw<InvalidArgument>("aspect graph: hypothesis {} of target {} has no mesh", i, target.id);
    }
    if (!(model.belief >= 0.0 && model.needed >= 0.0 && model.needed < 1.0)) {
      Throw<InvalidArgument>(
          "aspect graph: hypothesis {} of target {} with belief {}, of which {} is needed; they "
          "must "
          "lie in 0..1",
          i, target.id, model.belief, model.needed);
    }
    sum += model.belief;
  }
  if (!(sum <= 1.0 + 1e-6 && target.none >= 0.0 && target.none <= 1.0)) {
    Throw<InvalidArgument>(
        "aspect graph: the beliefs in the hypotheses of target {} sum to {}, and in none to {}; at "
        "most 1 each",
        target.id, sum, target.none);
  }
  for (const Eigen::Vector3d& seen_W : target.seen_from_W) {
    if (!(std::abs(seen_W.norm() - 1.0) < 1e-6)) {
      Throw<InvalidArgument>(
          "aspect graph: the direction ({}, {}, {}) from which target {} was "
          "seen is no unit vector",
          seen_W.x(), seen_W.y(), seen_W.z(), target.id);
    }
  }
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
void CheckWorth(const AspectScore& score, const AspectGraphConfig& config, world::Look* look) {
  look->feasible &= AddCheck(
      "visible", look->visibility >= config.min_visibility,
      fmt::format("{:.0f} % of {} rays to the box ({:.0f} % blocked, {:.0f} % through unknown "
                  "space); at least {:.0f} % wanted",
                  100.0 * look->visibility, score.box_rays, 100.0 * score.blocked,
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

LookStrategy ParseLookStrategy(const std::string& text) {
  std::string expected;
  for (const auto& [name, strategy] : kStrategies) {
    if (text == name) return strategy;
    expected += fmt::format("{}'{}'", expected.empty() ? "" : ", ", name);
  }
  Throw<ConfigError>("strategy '{}' is none of {}", text, expected);
}

void AspectGraphConfig::Validate() const {
  ParseLookStrategy(strategy);
  if (ray_columns < 8 || ray_columns > 4096) {
    Throw<ConfigError>("ray_columns = {} must lie in 8..4096", ray_columns);
  }
  CheckRange(box_margin_m, 0.0, 1.0, "box_margin_m");
  CheckRange(unknown_m, 0.0, 10.0, "unknown_m");
  CheckRange(unknown_survival, 0.0, 1.0, "unknown_survival");
  CheckRange(min_visibility, 0.0, 1.0, "min_visibility");
  CheckRange(same_view_deg, 0.0, 179.0, "same_view_deg");
  CheckRange(new_view_deg, same_view_deg + 1.0, 180.0, "new_view_deg");
  CheckRange(new_view_unknown_deg, same_view_deg + 1.0, 180.0, "new_view_unknown_deg");
  CheckRange(same_view_novelty, 0.0, 1.0, "same_view_novelty");
  CheckRange(look_seconds, 0.01, 3600.0, "look_seconds");
  CheckRange(depth_sigmas, 0.0, 100.0, "depth_sigmas");
  CheckRange(color_difference, 0.0, 1.0, "color_difference");
  loss.Validate();
  look_ahead.Validate();
  CheckRange(evidence, 0.0, 1e6, "evidence");
  CheckRange(unlike, 0.0, 1.0, "unlike");
  CheckRange(few_px, 0.0, 1e9, "few_px");
  CheckRange(ahead_speed, 0.01, 100.0, "ahead_speed");
  CheckRange(fixed_step_deg, -360.0, 360.0, "fixed_step_deg");
}

AspectGraph ScoreAspectGraph(const world::VoxelSpace& space, const geometry::CameraModel& camera,
                             const AspectTarget& target, std::vector<world::Look> looks, Rng* rng,
                             const AspectGraphConfig& config) {
  config.Validate();
  camera.Validate("of the aspect graph");
  Check(target);
  const LookStrategy strategy = ParseLookStrategy(config.strategy);
  const double scale = static_cast<double>(config.ray_columns) / camera.width;
  const geometry::CameraModel modelled = camera.Scaled(scale);
  const Belief belief = BeliefOf(target);
  AspectGraph graph{std::move(looks), {}};
  const int count = static_cast<int>(graph.looks.size());
  graph.scores.resize(count);
  ParallelFor(count, [&](int i) {
    world::Look& look = graph.looks[i];
    if (!look.feasible) return;
    AspectScore& score = graph.scores[i];
    score = Analyse(space, modelled, 1.0 / (scale * scale), target, look.X_WC, config);
    look.visibility = MeanVisibility(target, score);
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
    if (strategy == LookStrategy::kExpectedLoss) CheckWorth(graph.scores[i], config, &look);
  }
  return graph;
}

}  // namespace secondlook::planning

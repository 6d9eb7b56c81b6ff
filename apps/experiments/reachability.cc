#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/random_scene.h"
#include "apps/experiments/sight.h"
#include "apps/experiments/true_footing.h"
#include "apps/mission_config.h"
#include "apps/scene_understanding.h"
#include "lib/planning/collision.h"
#include "lib/planning/cost_map.h"
#include "lib/planning/path.h"
#include "lib/planning/views.h"

namespace secondlook::apps {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMaxViews = 4;
constexpr int kMaxFurtherCrates = 4;
/// What is free by so much more was refused for another reason than the size of voxels [m].
constexpr double kWideMargin = 0.05;

/// A random scene with more crates around its table.
sim::Scene DrawCrampedScene(const Repertoire& repertoire, Rng* rng) {
  sim::Scene scene = DrawScene(repertoire, rng);
  const int further = rng->Index(kMaxFurtherCrates + 1);
  for (int i = 0; i < further; ++i) AddCrate(fmt::format("further crate {}", i + 1), &scene, rng);
  return scene;
}

/// The robot on a random side of the table, looking at it, where it truly has room.
Stance DrawStance(const sim::Scene& scene, const planning::CameraCarrier& carrier,
                  const TrueFooting& footing, Rng* rng) {
  const Vector3d p_WT(scene.table.position.x(), scene.table.position.y(), scene.table.height);
  Stance stance{{scene.robot.position.x(), scene.robot.position.y(),
                 scene.robot.yaw_deg * std::numbers::pi / 180.0},
                {},
                {}};
  for (int attempt = 0; attempt < 50; ++attempt) {
    const double side = rng->Uniform(-std::numbers::pi, std::numbers::pi);
    const double distance = rng->Uniform(1.1, 2.2);
    const Vector2d p_W = p_WT.head<2>() + distance * Vector2d(std::cos(side), std::sin(side));
    if (!footing.Free(p_W, carrier.base.radius + 0.1, 0.0, carrier.base.height)) continue;
    stance.X_WB = {p_W.x(), p_W.y(), WrapAngle(side + std::numbers::pi)};
    break;
  }
  const auto aim = kinematics::AimAt(carrier.head, ToPose(stance.X_WB).inverse() * p_WT);
  if (aim) stance.head = {aim->pan, aim->tilt};
  return stance;
}

/// True when the map knows at every point of the disc the floor, or something that stands on it.
bool Observed(const world::VoxelSpace& space, const Vector2d& p_W, double radius, double top) {
  constexpr double kFloorBand = 0.03;  // [m]
  const double step = space.surroundings().voxel();
  const auto observed = [&](const Vector2d& q_W) {
    for (double z = -kFloorBand; z < kFloorBand; z += step) {
      if (space.At({q_W.x(), q_W.y(), z}) != world::Occupancy::kUnknown) return true;
    }
    for (double z = kFloorBand; z < top; z += step) {
      if (space.At({q_W.x(), q_W.y(), z}) == world::Occupancy::kOccupied) return true;
    }
    return false;
  };
  for (double x = -radius; x <= radius; x += 2.0 * step) {
    for (double y = -radius; y <= radius; y += 2.0 * step) {
      if (std::hypot(x, y) <= radius && !observed(p_W + Vector2d(x, y))) return false;
    }
  }
  return true;
}

/// What became of the candidates of one scene.
struct Tally {
  int candidates{}, refused{};
  int accepted{}, accepted_touching{};
  int accepted_observed{}, accepted_observed_touching{};
  int for_collision{}, free_all{};  ///< Refused for a collision; of these free with all margins.
  int observed{}, free_observed{}, free_widely{}, free_bare{};  ///< Of those whose floor was seen.

  Json ToJson() const {
    return {{"candidates", candidates},
            {"refused", refused},
            {"accepted", accepted},
            {"accepted_touching", accepted_touching},
            {"accepted_observed", accepted_observed},
            {"accepted_observed_touching", accepted_observed_touching},
            {"refused_for_collision", for_collision},
            {"refused_though_free", free_all},
            {"observed", observed},
            {"observed_though_free", free_observed},
            {"observed_though_free_widely", free_widely},
            {"observed_though_base_alone_fits", free_bare}};
  }
};

/// Judges one candidate by the true meshes.
class CandidateJudge {
 public:
  CandidateJudge(const TrueFooting& footing, const world::VoxelSpace& space,
                 const planning::CostMapConfig& config, const hal::BaseInfo& base,
                 const sim::NoiseConfig& noise, const Pose& X_TrueBelieved, Rng* rng)
      : footing_(footing),
        space_(space),
        config_(config),
        base_(base),
        noise_(noise),
        X_TrueBelieved_(X_TrueBelieved),
        rng_(rng) {}

  void Judge(const world::Look& look, Tally* tally) {
    ++tally->candidates;
    if (!look.feasible) ++tally->refused;
    const Vector2d believed_W(look.X_WB.x, look.X_WB.y);
    if (look.feasible) {
      ++tally->accepted;
      // Where the base would stop, by its own localisation.
      const Pose2 stop = DrawTruth(look.X_WB, noise_, rng_);
      const bool touches = !footing_.Free({stop.x, stop.y}, base_.radius, 0.0, base_.height);
      tally->accepted_touching += touches;
      if (!Observed(space_, believed_W, base_.radius, base_.height)) return;
      ++tally->accepted_observed;
      tally->accepted_observed_touching += touches;
      return;
    }
    if (look.checks.back().name != "collision") return;
    ++tally->for_collision;
    // The same place among the things as they truly stand.
    const Vector2d p_W =
        (X_TrueBelieved_ * Vector3d(believed_W.x(), believed_W.y(), 0.0)).head<2>();
    const auto free = [&](double radius) {
      return footing_.Free(p_W, radius, config_.min_height_m, base_.height);
    };
    const double safe = planning::SafeRadius(base_, config_);
    const bool is_free = free(safe);
    tally->free_all += is_free;
    if (!Observed(space_, believed_W, safe, base_.height)) return;
    ++tally->observed;
    tally->free_observed += is_free;
    tally->free_widely += is_free && free(safe + kWideMargin);
    tally->free_bare += free(base_.radius);
  }

 private:
  const TrueFooting& footing_;
  const world::VoxelSpace& space_;
  const planning::CostMapConfig& config_;
  const hal::BaseInfo& base_;
  const sim::NoiseConfig& noise_;
  Pose X_TrueBelieved_;
  Rng* rng_;
};

Json RunTrial(const Repertoire& repertoire, std::uint64_t seed) {
  Rng rng(seed);
  const sim::Scene scene = DrawCrampedScene(repertoire, &rng);
  FreeCamera camera(scene, seed);
  const planning::CameraCarrier carrier = CarrierOf(camera);
  const TrueFooting footing(camera.world().fixtures());

  SceneUnderstanding known({}, {}, world::ObjectDatabase(std::vector<world::ObjectModel>{}));
  const int views = 1 + rng.Index(kMaxViews);
  Stance stance;
  Pose X_TrueBelieved = Pose::Identity();
  for (int i = 0; i < views; ++i) {
    stance = DrawStance(scene, carrier, footing, &rng);
    const Sight sight = LookFrom(stance, &rng, &camera);
    const bool first = known.belief().views.empty();
    if (!known.Add(sight.capture).empty() || !first) continue;
    X_TrueBelieved = sight.photo.X_WC * known.belief().views.front().X_WC.inverse();
  }
  Tally tally;
  if (known.belief().plane_W) {
    const planning::CostMapConfig config;
    const std::vector<world::SupportPlane> supports_W{*known.belief().plane_W};
    planning::CostMap map(known.space(), supports_W, carrier.base, scene.table.position, config);
    const planning::CollisionChecker collision(known.space(), supports_W, carrier.base, config);
    const planning::Routes routes(map, stance.X_WB, carrier.base);
    CandidateJudge judge(footing, known.space(), config, carrier.base, camera.world().noise(),
                         X_TrueBelieved, &rng);
    for (const world::ObjectBelief& object : known.belief().objects) {
      for (const world::Look& look : planning::CandidateViews(
               object.extent_W.center(), object.id, carrier, {collision, routes, stance.head})) {
        judge.Judge(look, &tally);
      }
    }
  }
  Json trial;
  trial["seed"] = seed;
  trial["views"] = known.belief().views.size();
  trial.update(tally.ToJson());
  return trial;
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  const auto sum = [&](const char* key) {
    int total = 0;
    for (const Json& trial : trials) total += trial.at(key).get<int>();
    return total;
  };
  const auto share = [&](const char* hits, const char* of) {
    return Proportion(sum(hits), sum(of));
  };
  std::vector<double> refused_of_38;
  for (const Json& trial : trials) {
    if (trial.at("candidates") == 0) continue;
    refused_of_38.push_back(38.0 * trial.at("refused").get<double>() /
                            trial.at("candidates").get<double>());
  }
  return {{"accepted poses that touch something, floor observed",
           share("accepted_observed_touching", "accepted_observed")},
          {"accepted poses that touch something, floor observed or not",
           share("accepted_touching", "accepted")},
          {"refused for a collision and free, floor observed",
           share("observed_though_free", "observed")},
          {"… and free by 5 cm more", share("observed_though_free_widely", "observed")},
          {"refused for a collision, base alone would fit, floor observed",
           share("observed_though_base_alone_fits", "observed")},
          {"refused for a collision and free, floor observed or not",
           share("refused_though_free", "refused_for_collision")},
          {"refused of 38 candidates", Mean(refused_of_38), 17.0}};
}

}  // namespace

void RunReachabilityExperiment(const ExperimentOptions& options) {
  spdlog::set_level(spdlog::level::warn);  // a thousand scenes at once tell no one anything
  const Repertoire repertoire = LoadRepertoire(options.models, options.unfamiliar);
  RunTrials(
      "reachability", options,
      [&](int t) {
        return RunTrial(repertoire, ForkSeed(options.seed, fmt::format("reachability {}", t)));
      },
      Summarise);
}

}  // namespace secondlook::apps

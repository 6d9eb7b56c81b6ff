#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/free_camera.h"
#include "apps/experiments/pedestal.h"
#include "apps/experiments/random_scene.h"
#include "apps/experiments/single_view.h"
#include "apps/scene_understanding.h"
#include "lib/fusion/pose_fusion.h"
#include "lib/perception/equivalent_pose.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
using perception::PoseDistance;
using perception::RecognitionModel;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::array<int, 5> kViews{1, 2, 5, 10, 20};  // after which the fused pose is judged

/// View `k` of a plan: all around the pedestal by the golden angle, so that the first few are
/// spread as well as all are, at changing heights and distances.
Pose PlannedView(const sim::Table& table, int k) {
  constexpr double kGolden = std::numbers::pi * (3.0 - 2.2360679774997896);
  const double elevation = (25.0 + 35.0 * (k % 3) / 2.0) * kDegree;
  const double distance = 0.8 + 0.15 * (k % 2);
  const Vector3d target(table.position.x(), table.position.y(), table.height + 0.05);
  const Vector3d towards(std::cos(elevation) * std::cos(k * kGolden),
                         std::cos(elevation) * std::sin(k * kGolden), std::sin(elevation));
  return LookAt(target + distance * towards, target);
}

/// Where a robot below the camera believes it to be, with the errors of localisation, of the head
/// and of its mount `X_CCm`, which is the same in all views.
Capture Believed(const Photo& photo, const geometry::CameraModel& camera, const Pose& X_CCm,
                 const sim::NoiseConfig& noise, Rng* rng) {
  const Vector3d& p_WC = photo.X_WC.translation();
  Pose X_WB = Pose::Identity();
  X_WB.translation() << p_WC.x(), p_WC.y(), 0.0;
  Pose X_WBn = X_WB;
  X_WBn.translation().x() += rng->Gaussian(noise.localisation_sigma);
  X_WBn.translation().y() += rng->Gaussian(noise.localisation_sigma);
  X_WBn.linear() =
      RotationFromVector({0.0, 0.0, rng->Gaussian(noise.localisation_sigma_deg * kDegree)});
  Capture capture;
  capture.frame = photo.frame;
  capture.camera = camera;
  capture.X_WC =
      X_WBn * X_WB.inverse() * photo.X_WC * X_CCm * SmallMotion(0.0, noise.pan_tilt_sigma_deg, rng);
  capture.p_CB_W = X_WBn.translation() - capture.X_WC.translation();
  return capture;
}

/// The pose of the object in every view that recognised it, brought to one of its equivalents, and
/// how much each view knows of it.
std::vector<fusion::PoseEstimate> ToOneEquivalent(std::vector<fusion::PoseEstimate> estimates,
                                                  const RecognitionModel& model) {
  for (fusion::PoseEstimate& e : estimates) {
    e.X_WM = perception::NearestEquivalent(estimates.front().X_WM, e.X_WM, model.symmetry, true);
  }
  return estimates;
}

/// The mean of the largest cluster, as in Section IV-C of the paper.
Pose FusedLargestCluster(const std::vector<fusion::PoseEstimate>& estimates,
                         const RecognitionModel& model) {
  const fusion::PoseCutOff cut_off;
  const std::vector<int> members =
      fusion::LargestCluster(static_cast<int>(estimates.size()), [&](int a, int b) {
        const PoseDistance d = perception::DistanceUpToSymmetry(
            estimates[a].X_WM, estimates[b].X_WM, model.symmetry, model.center_M, true);
        return d.translation <= cut_off.max_m && d.rotation <= cut_off.max_rad;
      });
  std::vector<fusion::PoseEstimate> cluster;
  for (const int i : members) cluster.push_back(estimates[i]);
  return fusion::FusePoses(ToOneEquivalent(std::move(cluster), model)).X_WM;
}

/// What one view found of the object.
struct SingleView {
  Pose X_WM;      ///< By the view's registered pose.
  double weight;  ///< Score and visible fraction, as the mission weighs its views.
};

std::optional<SingleView> FindIn(const std::vector<world::Hypothesis>& chosen,
                                 const std::string& name, const Pose& X_WC) {
  for (const world::Hypothesis& h : chosen) {
    if (h.model != name) continue;
    return SingleView{X_WC * h.X_CM, std::max(1e-3, h.score * h.verification.visible_fraction)};
  }
  return std::nullopt;
}

/// What the mission believes of the object, or null.
const world::PoseHypothesis* BelievedPose(const world::SceneBelief& belief,
                                          const std::string& name) {
  for (const world::ObjectBelief& object : belief.objects) {
    if (object.state != world::ObjectState::kVerified) continue;
    if (object.Best()->model == name) return object.Best();
  }
  return nullptr;
}

class Trial {
 public:
  Trial(const sim::Scene& scene, const world::ObjectDatabase& database, std::uint64_t seed)
      : scene_(scene),
        models_(ModelsOf(scene, database)),
        camera_(scene, seed),
        rng_(ForkSeed(seed, "pose averaging")),
        understanding_({}, {}, OneModel(scene, database)) {
    const sim::NoiseConfig& noise = camera_.world().noise();
    X_CCm_ = SmallMotion(noise.extrinsics_sigma, noise.extrinsics_sigma_deg, &rng_);
  }

  Json Run(int views) {
    Json result{{"object", model().name}, {"single", Json::array()}, {"fused", Json::array()}};
    for (int k = 0; k < views; ++k) {
      Look(k, &result["single"]);
      if (std::find(kViews.begin(), kViews.end(), k + 1) == kViews.end()) continue;
      result["fused"].push_back(JudgeAfter(k + 1));
    }
    return result;
  }

 private:
  static world::ObjectDatabase OneModel(const sim::Scene& scene,
                                        const world::ObjectDatabase& database) {
    return world::ObjectDatabase({*database.Find(scene.objects.front().name)});
  }

  const RecognitionModel& model() const { return models_.front(); }

  void Look(int k, Json* single) {
    const Photo photo = camera_.Take(PlannedView(scene_.table, k));
    const Capture capture =
        Believed(photo, camera_.info().model, X_CCm_, camera_.world().noise(), &rng_);
    if (!understanding_.Add(capture).empty()) return;
    const Pose& X_WC = understanding_.belief().views.back().X_WC;
    // W is where the first view believed itself to be; so it is judged in that view's camera frame.
    if (understanding_.belief().views.size() == 1) X_WTrueW_ = X_WC * photo.X_WC.inverse();
    const perception::Regrouped seen = Detect(photo, camera_.info().model, models_);
    const auto found = FindIn(Chosen(seen), model().name, X_WC);
    if (!found) return;
    found_.push_back(*found);
    single->push_back(ToJson(ErrorOf(found->X_WM)));
  }

  /// Of the object's pose, up to its symmetry.
  PoseDistance ErrorOf(const Pose& X_WM) const {
    return perception::DistanceUpToSymmetry(X_WTrueW_ * camera_.world().objects().front().X_WM,
                                            X_WM, model().symmetry, model().center_M, true);
  }

  Json JudgeAfter(int views) const {
    Json entry{{"views", views}, {"mean", nullptr}, {"weighted", nullptr}, {"joint", nullptr}};
    if (!found_.empty()) {
      std::vector<fusion::PoseEstimate> estimates;
      for (const SingleView& view : found_) estimates.push_back({view.X_WM});
      for (fusion::PoseEstimate& e : estimates) e.information.setIdentity() *= kInformation;
      entry["mean"] = ToJson(ErrorOf(FusedLargestCluster(estimates, model())));
      for (std::size_t i = 0; i < found_.size(); ++i) estimates[i].information *= found_[i].weight;
      entry["weighted"] = ToJson(ErrorOf(FusedLargestCluster(estimates, model())));
    }
    const world::PoseHypothesis* best = BelievedPose(understanding_.belief(), model().name);
    if (best != nullptr) entry["joint"] = ToJson(ErrorOf(best->X_WM));
    return entry;
  }

  static Json ToJson(const PoseDistance& error) {
    return {{"error_mm", error.translation * 1e3}, {"error_deg", error.rotation / kDegree}};
  }

  static constexpr double kInformation = 1e5;  // any: only the weights' ratios count

  sim::Scene scene_;
  std::vector<RecognitionModel> models_;
  FreeCamera camera_;
  Rng rng_;
  SceneUnderstanding understanding_;
  Pose X_CCm_{Pose::Identity()};
  Pose X_WTrueW_{Pose::Identity()};
  std::vector<SingleView> found_;
};

/// The `error` of `method` after `views` views, of the trials that have one.
std::vector<double> Errors(const std::vector<Json>& trials, int views, const char* method,
                           const char* error) {
  std::vector<double> errors;
  for (const Json& trial : trials) {
    for (const Json& fused : trial.at("fused")) {
      if (fused.at("views") != views || fused.at(method).is_null()) continue;
      errors.push_back(fused.at(method).at(error));
    }
  }
  return errors;
}

std::vector<double> SingleErrors(const std::vector<Json>& trials, const char* error) {
  std::vector<double> errors;
  for (const Json& trial : trials) {
    for (const Json& view : trial.at("single")) errors.push_back(view.at(error));
  }
  return errors;
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  std::vector<Row> rows{
      {"position error, single views [mm]", Mean(SingleErrors(trials, "error_mm"))},
      {"rotation error, single views [deg]", Mean(SingleErrors(trials, "error_deg"))}};
  for (const int views : kViews) {
    if (Errors(trials, views, "mean", "error_mm").empty()) continue;
    const auto row = [&](const char* what, const char* method, const char* name, const char* unit,
                         const char* error, double paper) {
      Row fused{
          fmt::format("{}, {}, {} view{} [{}]", what, name, views, views == 1 ? "" : "s", unit),
          Mean(Errors(trials, views, method, error))};
      if (views == kViews.back()) fused.paper = paper;  // "less than"
      fused.baseline = Mean(Errors(trials, views, "mean", error)).value;
      rows.push_back(std::move(fused));
    };
    row("position error", "weighted", "weighted mean", "mm", "error_mm", 4.0);
    row("rotation error", "weighted", "weighted mean", "deg", "error_deg", 1.0);
    row("position error", "joint", "fused", "mm", "error_mm", 4.0);
    row("rotation error", "joint", "fused", "deg", "error_deg", 1.0);
  }
  return rows;
}

}  // namespace

void RunPoseAveragingExperiment(const ExperimentOptions& options) {
  const auto database = world::ObjectDatabase::Load(options.models);
  Rng rng(ForkSeed(options.seed, "objects"));
  const auto known = LoadRepertoire(options.models, "").known;
  const auto order = DrawObjects(known, static_cast<int>(known.size()), &rng);
  RunTrials(
      "pose-averaging", options,
      [&](int t) {
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("trial {}", t));
        sim::SceneObject object = order[t % order.size()];
        object.yaw_deg = Rng(ForkSeed(seed, "scene")).Uniform(-180.0, 180.0);
        return Trial(OnPedestal(std::move(object)), database, seed).Run(options.views);
      },
      Summarise);
}

}  // namespace secondlook::apps

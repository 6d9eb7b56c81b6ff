#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/free_camera.h"
#include "apps/experiments/random_scene.h"
#include "apps/experiments/reliability.h"
#include "apps/experiments/single_view.h"
#include "lib/perception/symmetry.h"
#include "lib/world/object_database.h"
#include "sim/scene_renderer.h"

namespace secondlook::apps {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
using perception::RecognitionModel;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kObjects = 7;
/// A detection is right within these, up to the symmetry in shape and colour.
constexpr double kMaxError_m = 0.030;
constexpr double kMaxError_rad = 15.0 * kDegree;
/// The paper's threshold of q_h (Kriegel 2013, III-C).
constexpr double kPaperQuality = 0.4;

/// Those that the paper's rule chooses: of each cluster the highest quality, when it exceeds 0.4.
std::vector<world::Hypothesis> ChosenByQuality(const std::vector<world::Detection>& detections) {
  std::vector<world::Hypothesis> chosen;
  for (const world::Detection& detection : detections) {
    const auto best = std::max_element(detection.hypotheses.begin(), detection.hypotheses.end(),
                                       [](const auto& a, const auto& b) {
                                         return a.verification.quality < b.verification.quality;
                                       });
    if (best == detection.hypotheses.end()) continue;
    if (best->verification.quality > kPaperQuality) chosen.push_back(*best);
  }
  return chosen;
}

/// Judges what is chosen in one view. Each thing can be detected once; a second time is an error.
class ViewJudge {
 public:
  ViewJudge(const std::vector<sim::PlacedObject>& things,
            const std::vector<RecognitionModel>& models, const Pose& X_WC)
      : things_(things), models_(models), X_WC_(X_WC) {}

  /// Notes in `found` (one for each thing) what is right; returns an entry for each of `chosen`.
  Json Judge(const std::vector<world::Hypothesis>& chosen, std::vector<char>* found) const {
    Json entries = Json::array();
    for (const world::Hypothesis& h : chosen) {
      Json entry{{"model", h.model}, {"right", false}, {"near", false}};
      for (std::size_t i = 0; i < things_.size(); ++i) {
        if (things_[i].name != h.model || (*found)[i]) continue;
        const perception::PoseDistance error = ErrorOf(h, things_[i]);
        const bool near = error.translation <= kMaxError_m;
        const bool right = IsRight(error);
        entry["near"] = near;
        entry["right"] = right;
        entry["error_mm"] = error.translation * 1e3;
        entry["error_deg"] = error.rotation / kDegree;
        (*found)[i] = right ? 1 : 0;
      }
      entries.push_back(std::move(entry));
    }
    return entries;
  }

  /// All that each cluster may be, and what of it is right.
  Json JudgeAll(const std::vector<world::Detection>& detections) const {
    Json clusters = Json::array();
    for (const world::Detection& detection : detections) {
      Json hypotheses = Json::array();
      for (const world::Hypothesis& h : detection.hypotheses) {
        hypotheses.push_back({{"model", h.model},
                              {"score", h.score},
                              {"log_odds", perception::LogOdds(h.score)},
                              {"accepted", h.verification.accepted},
                              {"probability", h.probability},
                              {"right", IsRightOfAny(h)}});
      }
      clusters.push_back(std::move(hypotheses));
    }
    return clusters;
  }

  /// Why the thing `index` of `photo` is not found.
  Json WhyMissed(std::size_t index, const Photo& photo, const perception::Regrouped& seen) const {
    const std::vector<world::Detection>& detections = seen.detections;
    const sim::PlacedObject& thing = things_[index];
    bool cut_out = false;
    const world::Hypothesis* best = nullptr;
    const perception::Choice* choice = nullptr;
    for (std::size_t d = 0; d < detections.size(); ++d) {
      const int id = sim::kFirstObjectId + static_cast<int>(index);
      if (!IsMostly(id, detections[d].cluster, photo.id)) continue;
      cut_out = true;
      for (const world::Hypothesis& h : detections[d].hypotheses) {
        if (h.model != thing.name || !IsRight(ErrorOf(h, thing))) continue;
        if (best != nullptr && best->score >= h.score) continue;
        best = &h;
        choice = &seen.choices[d];
      }
    }
    if (!cut_out) return {{"kind", "no cluster"}};
    if (best == nullptr) return {{"kind", "not proposed"}};
    if (!best->verification.accepted) {
      return {{"kind", "rejected"}, {"reason", best->verification.reason}};
    }
    if (choice->hypothesis < 0) return {{"kind", "open"}, {"reason", choice->reason}};
    return {{"kind", "outdone"}};
  }

 private:
  bool IsRightOfAny(const world::Hypothesis& h) const {
    return std::any_of(things_.begin(), things_.end(), [&](const sim::PlacedObject& thing) {
      return thing.name == h.model && IsRight(ErrorOf(h, thing));
    });
  }

  static bool IsRight(const perception::PoseDistance& error) {
    return error.translation <= kMaxError_m && error.rotation <= kMaxError_rad;
  }

  static bool IsMostly(int id, const world::Cluster& cluster, const cv::Mat& ids) {
    const auto own = std::count_if(cluster.pixels.begin(), cluster.pixels.end(), [&](int pixel) {
      return ids.at<std::uint16_t>(pixel / ids.cols, pixel % ids.cols) == id;
    });
    return 2 * own > static_cast<std::ptrdiff_t>(cluster.pixels.size());
  }

  perception::PoseDistance ErrorOf(const world::Hypothesis& h,
                                   const sim::PlacedObject& thing) const {
    const RecognitionModel* model = perception::FindModel(models_, h.model);
    return perception::DistanceUpToSymmetry(X_WC_.inverse() * thing.X_WM, h.X_CM, model->symmetry,
                                            model->center_M, true);
  }

  const std::vector<sim::PlacedObject>& things_;
  const std::vector<RecognitionModel>& models_;
  Pose X_WC_;
};

/// Why each cluster that is not recognised is not, and what it is nearest to.
Json Open(const perception::Regrouped& seen) {
  Json open = Json::array();
  for (std::size_t i = 0; i < seen.detections.size(); ++i) {
    if (seen.choices[i].hypothesis >= 0) continue;
    Json entry{{"reason", seen.choices[i].reason}};
    const std::vector<world::Hypothesis>& hypotheses = seen.detections[i].hypotheses;
    if (!hypotheses.empty()) {
      entry["nearest"] = hypotheses.front().model;
      entry["score"] = hypotheses.front().score;
    }
    open.push_back(std::move(entry));
  }
  return open;
}

Json RunTrial(const sim::Scene& scene, const world::ObjectDatabase& database, int views,
              std::uint64_t seed) {
  const std::vector<RecognitionModel> models = ModelsOf(scene, database);
  FreeCamera camera(scene, seed);
  const std::vector<sim::PlacedObject>& things = camera.world().objects();
  Rng rng(ForkSeed(seed, "views"));
  Json trial{{"seed", seed}, {"views", Json::array()}};
  for (int view = 0; view < views; ++view) {
    const Photo photo = camera.Take(DrawView(scene.table, &rng));
    const perception::Regrouped seen = Detect(photo, camera.info().model, models);
    const ViewJudge judge(things, models, photo.X_WC);
    std::vector<char> found(things.size(), 0);
    std::vector<char> found_by_quality(things.size(), 0);
    Json entry;
    entry["detections"] = judge.Judge(Chosen(seen), &found);
    entry["baseline_detections"] = judge.Judge(ChosenByQuality(seen.detections), &found_by_quality);
    entry["objects"] = Json::array();
    const std::vector<double> visible = camera.VisibleShares(photo);
    for (std::size_t i = 0; i < things.size(); ++i) {
      Json object{{"name", things[i].name},
                  {"visible", visible[i]},
                  {"found", found[i] != 0},
                  {"baseline_found", found_by_quality[i] != 0}};
      if (found[i] == 0 && visible[i] > 0.0) {
        object["missed"] = judge.WhyMissed(i, photo, seen);
      }
      entry["objects"].push_back(std::move(object));
    }
    entry["open"] = Open(seen);
    entry["clusters"] = judge.JudgeAll(seen.detections);
    trial["views"].push_back(std::move(entry));
  }
  return trial;
}

/// The share of objects whose visible share is in (low, high] that are found.
Row Recall(const char* metric, const std::vector<Json>& trials, double low, double high) {
  int count = 0;
  int found = 0;
  int by_quality = 0;
  for (const Json& trial : trials) {
    for (const Json& view : trial.at("views")) {
      for (const Json& object : view.at("objects")) {
        const double visible = object.at("visible");
        if (!(visible > low && visible <= high)) continue;
        ++count;
        if (object.at("found")) ++found;
        if (object.at("baseline_found")) ++by_quality;
      }
    }
  }
  return {metric, Proportion(found, count), {}, Proportion(by_quality, count).value};
}

/// The share of detections that are not `what` ("right" or "near").
Row Wrong(const char* metric, const std::vector<Json>& trials, const char* what) {
  const auto share = [&](const char* detections) {
    int count = 0;
    int wrong = 0;
    for (const Json& trial : trials) {
      for (const Json& view : trial.at("views")) {
        for (const Json& detection : view.at(detections)) {
          ++count;
          if (!detection.at(what)) ++wrong;
        }
      }
    }
    return Proportion(wrong, count);
  };
  return {metric, share("detections"), {}, share("baseline_detections").value};
}

/// The mean `error` of the right detections.
Row ErrorOfRight(const char* metric, const std::vector<Json>& trials, const char* error) {
  std::vector<double> errors;
  for (const Json& trial : trials) {
    for (const Json& view : trial.at("views")) {
      for (const Json& detection : view.at("detections")) {
        if (detection.at("right")) errors.push_back(detection.at(error));
      }
    }
  }
  return {metric, Mean(errors)};
}

/// Of each trial, how likely the likeliest hypothesis of each cluster was said to be by
/// `probability`
/// ("score" or "probability"), and whether it was right.
std::vector<Predictions> PredictionsBy(const char* probability, const std::vector<Json>& trials) {
  std::vector<Predictions> predictions;
  for (const Json& trial : trials) {
    Predictions& of_trial = predictions.emplace_back();
    for (const Json& view : trial.at("views")) {
      for (const Json& hypotheses : view.at("clusters")) {
        const auto best = std::max_element(
            hypotheses.begin(), hypotheses.end(), [&](const Json& a, const Json& b) {
              return a.at(probability).get<double>() < b.at(probability).get<double>();
            });
        if (best != hypotheses.end()) {
          of_trial.push_back({best->at(probability), best->at("right")});
        }
      }
    }
  }
  return predictions;
}

/// Whether the probabilities hold. The baseline takes the scores for probabilities.
void AddReliability(const std::vector<Json>& trials, std::vector<Row>* rows) {
  const std::vector<Predictions> ours = PredictionsBy("probability", trials);
  const std::vector<Predictions> scores = PredictionsBy("score", trials);
  rows->push_back({"calibration error of the probability",
                   CalibrationError(ours),
                   {},
                   CalibrationError(scores).value});
  rows->push_back(
      {"Brier score of the probability", BrierScore(ours), {}, BrierScore(scores).value});
  for (int bin = 0; bin < kReliabilityBins; ++bin) {
    rows->push_back({fmt::format("right where the probability is {:.1f} to {:.1f}",
                                 1.0 * bin / kReliabilityBins, (bin + 1.0) / kReliabilityBins),
                     ShareRight(ours, bin),
                     {},
                     ShareRight(scores, bin).value});
  }
}

std::vector<Row> Summarise(const std::vector<Json>& trials) {
  std::vector<Row> rows{
      Recall("recall, more than 50 % visible", trials, 0.5, 1.0),
      Recall("recall, 20 to 50 % visible", trials, 0.2, 0.5),
      Recall("recall, all not completely hidden", trials, 0.0, 1.0),
      Wrong("wrong detections (30 mm, 15 deg)", trials, "right"),
      Wrong("wrong detections (30 mm alone)", trials, "near"),
      ErrorOfRight("position error of right ones [mm]", trials, "error_mm"),
      ErrorOfRight("rotation error of right ones [deg]", trials, "error_deg"),
  };
  rows[2].paper = 245.0 / 326.0;
  rows[4].paper = 8.0 / 253.0;
  AddReliability(trials, &rows);
  return rows;
}

}  // namespace

void RunRecognitionExperiment(const ExperimentOptions& options) {
  const auto database = world::ObjectDatabase::Load(options.models);
  const Repertoire repertoire = LoadRepertoire(options.models, "");
  RunTrials(
      "recognition", options,
      [&](int t) {
        const std::uint64_t seed = ForkSeed(options.seed, fmt::format("trial {}", t));
        Rng rng(ForkSeed(seed, "scene"));
        const sim::Scene scene =
            options.scene.empty()
                ? DrawCrowdedTable(DrawObjects(repertoire.known, kObjects, &rng), &rng)
                : sim::LoadScene(options.scene);
        return RunTrial(scene, database, options.views, seed);
      },
      Summarise);
}

}  // namespace secondlook::apps

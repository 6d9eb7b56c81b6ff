#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/experiments/experiment.h"
#include "apps/experiments/nbv_distortion.h"
#include "apps/experiments/nbv_summary.h"
#include "apps/experiments/npy.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/perception/appearance/classifier.h"
#include "lib/perception/appearance/training_images.h"

namespace secondlook::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using planning::ObjectCrop;

constexpr std::array kFronts{"Front_Down", "Front_Up"};
constexpr int kSetsInABlock = 40;  // of one light and background

struct SetFiles {
  int number{};
  fs::path folder;
  std::string truth;
};

std::string FirstWord(const std::string& text) {
  return text.substr(0, text.find_first_of(" \t\r\n"));
}

/// The sets in `data` or in its Test_Files, by number.
std::vector<SetFiles> FindSets(const fs::path& data) {
  const fs::path folder = fs::is_directory(data / "Test_Files") ? data / "Test_Files" : data;
  if (!fs::is_directory(folder)) {
    Throw<ConfigError>("--data {}: no such folder; nbv-dataset needs the data set's Test_Files",
                       data.string());
  }
  std::vector<SetFiles> sets;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    SetFiles set{0, entry.path(), ""};
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), set.number);
    if (error != std::errc() || end != name.data() + name.size()) continue;
    set.truth = FirstWord(ReadFile(entry.path() / "label.txt"));
    sets.push_back(set);
  }
  if (sets.empty()) Throw<ConfigError>("--data {}: holds no numbered set", data.string());
  std::sort(sets.begin(), sets.end(),
            [](const SetFiles& a, const SetFiles& b) { return a.number < b.number; });
  return sets;
}

/// Six decimals are enough, and keep the file small.
Json Rounded(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) {
    json.push_back(std::isfinite(value) ? Json(std::round(value * 1e6) * 1e-6) : Json(nullptr));
  }
  return json;
}

std::vector<double> ReadNumbers(const Json& json) {
  std::vector<double> values;
  for (const Json& value : json) {
    values.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN()
                                     : value.get<double>());
  }
  return values;
}

/// Rounding leaves them not summing to 1 exactly.
std::vector<double> ReadProbabilities(const Json& json) {
  std::vector<double> p = ReadNumbers(json);
  const double sum = std::accumulate(p.begin(), p.end(), 0.0);
  for (double& probability : p) probability /= sum;
  return p;
}

/// Each crop shows an object, so that the background's share goes to all classes alike.
class ObjectClassifier {
 public:
  explicit ObjectClassifier(const std::string& path)
      : classifier_(perception::LoadClassifier(path)) {
    for (std::size_t c = 0; c < classifier_->classes().size(); ++c) {
      if (classifier_->classes()[c] == perception::kBackgroundClass) continue;
      kept_.push_back(c);
      shared_.classes.push_back(classifier_->classes()[c]);
    }
    shared_.reliability = classifier_->held_out_accuracy();
  }

  const NbvClassifier& shared() const { return shared_; }

  std::vector<double> Classify(const cv::Mat& image) const {
    const std::vector<double> all = classifier_->Classify(image);
    std::vector<double> kept;
    double sum = 0.0;
    for (const std::size_t c : kept_) sum += kept.emplace_back(std::max(all[c], 1e-9));
    for (double& probability : kept) probability /= sum;
    return kept;
  }

  int LabelOf(const SetFiles& set) const {
    const auto found = std::find(shared_.classes.begin(), shared_.classes.end(), set.truth);
    if (found == shared_.classes.end()) {
      Throw<ConfigError>(
          "{}: '{}' is no class of the classifier; train it on the data set's classes",
          (set.folder / "label.txt").string(), set.truth);
    }
    return static_cast<int>(found - shared_.classes.begin());
  }

 private:
  std::unique_ptr<perception::Classifier> classifier_;
  std::vector<std::size_t> kept_;
  NbvClassifier shared_;
};

ObjectCrop ReadCrop(const fs::path& folder, const std::string& name) {
  ObjectCrop crop;
  crop.color = perception::ReadImage(folder / (name + ".jpg"));
  crop.depth = ReadNpy(folder / (name + ".npy"));
  if (crop.depth.size() != crop.color.size()) {
    Throw<ConfigError>("{}: {} has a depth of another size", folder.string(), name);
  }
  return crop;
}

/// The index of each side's view in a world seen in a mirror.
constexpr std::array<int, kSideCount> kMirroredSide{2, 1, 0, 4, 3};

class NbvTrial {
 public:
  NbvTrial(const ObjectClassifier& classifier, const std::vector<SetFiles>& sets,
           std::uint64_t seed, bool mirror)
      : classifier_(classifier), sets_(sets), seed_(seed), mirror_(mirror) {}

  Json Run(int t) const {
    const SetFiles& set = sets_[t];
    Rng rng(ForkSeed(seed_, fmt::format("set {}", set.number)));
    const bool mirrored = mirror_ && rng.Index(2) == 1;
    Json trial{{"set", set.number}, {"truth", set.truth}, {"mirrored", mirrored}};
    for (std::size_t s = 0; s < kSideCount; ++s) {
      const int file = mirrored ? kMirroredSide[s] + 1 : static_cast<int>(s) + 1;
      ObjectCrop side;
      side.color = perception::ReadImage(set.folder / fmt::format("{}.jpg", file));
      if (mirrored) side = Mirrored(side);
      trial["sides"].push_back(Rounded(classifier_.Classify(side.color)));
    }
    for (const char* front : kFronts) {
      ObjectCrop crop = ReadCrop(set.folder, front);
      if (mirrored) crop = Mirrored(crop);
      for (int d = 0; d < std::ssize(kDistortions); ++d) {
        const ObjectCrop other = OtherObject(set, front, &rng);
        trial["cases"].push_back(Case(Distorted(crop, d, other, &rng), front, d));
      }
    }
    return trial;
  }

 private:
  /// The same view of a set of another class; of the same where there is no other.
  ObjectCrop OtherObject(const SetFiles& set, const std::string& front, Rng* rng) const {
    std::vector<const SetFiles*> others;
    for (const SetFiles& other : sets_) {
      if (other.truth != set.truth) others.push_back(&other);
    }
    if (others.empty()) others.push_back(&set);
    return ReadCrop(others[rng->Index(static_cast<int>(others.size()))]->folder, front);
  }

  Json Case(const ObjectCrop& crop, const std::string& front, int distortion) const {
    planning::TileClassification classes;
    classes.object = classifier_.Classify(crop.color);
    for (const planning::Tile tile : kSides) {
      const cv::Rect rect = TileRect(crop.color.size(), tile);
      if (!rect.empty()) {
        classes.tiles[static_cast<std::size_t>(tile)] = classifier_.Classify(crop.color(rect));
      }
    }
    const std::vector<planning::ScoredTile> tiles = ScoreTiles(crop, &classes);
    Json json{{"view", front},
              {"distortion", kDistortions[distortion]},
              {"front", Rounded(classes.object)}};
    for (const planning::Tile tile : kSides) {
      const planning::ScoredTile& scored = tiles[static_cast<std::size_t>(tile)];
      json["tiles"].push_back({{"scores", Rounded({scored.scores.begin(), scored.scores.end()})},
                               {"foreground", Rounded({scored.foreground})[0]},
                               {"refusal", scored.refusal}});
    }
    return json;
  }

  const ObjectClassifier& classifier_;
  const std::vector<SetFiles>& sets_;
  std::uint64_t seed_;
  bool mirror_;
};

NbvSet ParseTrial(const Json& trial, const std::vector<std::string>& classes) {
  NbvSet set;
  set.block = trial.at("set").get<int>() / kSetsInABlock;
  set.truth = static_cast<int>(
      std::find(classes.begin(), classes.end(), trial.at("truth").get<std::string>()) -
      classes.begin());
  for (std::size_t s = 0; s < kSideCount; ++s)
    set.sides[s] = ReadProbabilities(trial.at("sides").at(s));
  for (const Json& json : trial.at("cases")) {
    NbvCase& one = set.cases.emplace_back();
    const std::string name = json.at("distortion");
    one.distortion = static_cast<int>(std::find(kDistortions.begin(), kDistortions.end(), name) -
                                      kDistortions.begin());
    one.front = ReadProbabilities(json.at("front"));
    for (std::size_t s = 0; s < kSideCount; ++s) {
      const Json& tile = json.at("tiles").at(s);
      one.sides[s].tile = kSides[s];
      const std::vector<double> scores = ReadNumbers(tile.at("scores"));
      std::copy(scores.begin(), scores.end(), one.sides[s].scores.begin());
      one.sides[s].foreground = ReadNumbers(Json::array({tile.at("foreground")}))[0];
      one.sides[s].refusal = tile.at("refusal");
    }
  }
  return set;
}

}  // namespace

void RunNbvDatasetExperiment(const ExperimentOptions& given) {
  if (given.classifier.empty()) {
    Throw<ConfigError>("nbv-dataset needs --classifier FILE; make one with `secondlook train`");
  }
  const std::vector<SetFiles> sets = FindSets(given.data);
  const ObjectClassifier classifier(given.classifier);
  for (const SetFiles& set : sets) classifier.LabelOf(set);
  if (!given.report.empty()) fs::create_directories(given.report);
  ExperimentOptions options = given;
  options.trials = std::min(given.trials, static_cast<int>(sets.size()));
  options.models = given.classifier;  // what a result is resumed by
  const NbvTrial trial(classifier, sets, given.seed, given.mirror);
  RunTrials(
      "nbv-dataset", options, [&](int t) { return trial.Run(t); },
      [&](const std::vector<Json>& trials) {
        std::vector<NbvSet> done;
        for (const Json& json : trials) {
          done.push_back(ParseTrial(json, classifier.shared().classes));
        }
        return SummariseNbv(done, classifier.shared(),
                            std::ssize(trials) == options.trials ? options.report : "");
      });
}

}  // namespace secondlook::apps

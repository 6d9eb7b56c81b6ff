#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include "apps/commands/commands.h"
#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/perception/appearance/feature_classifier.h"
#include "lib/perception/appearance/network_classifier.h"

namespace secondlook::apps {
namespace {

namespace fs = std::filesystem;
using perception::FeatureClassifier;
using perception::FeatureClassifierKind;
using perception::TrainingSet;

constexpr const char* kNetworkScript = "tools/train_network/run";
constexpr int kNetworkInput_px = 128;

/// Those that are learnt here; all others are networks.
const std::map<std::string, FeatureClassifierKind> kFeatureKinds{
    {"svm", FeatureClassifierKind::kSvm},
    {"svm2021", FeatureClassifierKind::kSvm2021},
    {"forest", FeatureClassifierKind::kForest}};

struct TrainOptions {
  std::string images;
  std::string classifier;
  std::string out;
  std::string background;
  perception::FeatureTrainingConfig features;
  int copies = 11;
};

void Say(const std::string& line) { spdlog::info("{}", line); }

/// In single quotes, as the shell takes it literally.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// The index of the class that shows no object; -1 for none.
int BackgroundLabel(const TrainingSet& set, const std::string& background) {
  const auto found = std::find(set.classes.begin(), set.classes.end(), background);
  return found == set.classes.end() ? -1 : static_cast<int>(found - set.classes.begin());
}

/// One image of each class at least is kept out, and one is left to learn from.
void RequireTwoOfEach(const TrainingSet& set) {
  std::vector<int> counts(set.classes.size(), 0);
  for (const perception::TrainingImage& image : set.images) ++counts[image.label];
  const auto few = std::find_if(counts.begin(), counts.end(), [](int count) { return count < 2; });
  if (few == counts.end()) return;
  Throw<ConfigError>("class '{}' has {} image; a network needs at least 2, as one is kept out",
                     set.classes[few - counts.begin()], *few);
}

/// The network is trained by a program of its own, which gets the list of the images.
void TrainNetwork(const TrainingSet& set, const TrainOptions& options) {
  RequireTwoOfEach(set);
  if (!fs::exists(kNetworkScript)) {
    Throw<ConfigError>("{}: not found; start from the root of the repository", kNetworkScript);
  }
  const fs::path onnx = fs::path(options.out).replace_extension(".onnx");
  const fs::path list = fs::path(options.out).replace_extension(".list");
  const fs::path result = fs::path(options.out).replace_extension(".json");
  std::string lines;
  for (const perception::TrainingImage& image : set.images) {
    lines += fmt::format("{}\t{}\n", image.label, fs::absolute(image.path).string());
  }
  WriteFile(list, lines);
  const std::string command = fmt::format(
      "{} --network {} --list {} --out {} --result {} --background-class {} --copies {} --seed {}",
      kNetworkScript, options.classifier, Quoted(list.string()), Quoted(onnx.string()),
      Quoted(result.string()), BackgroundLabel(set, options.background), options.copies,
      options.features.seed);
  const int status = std::system(command.c_str());
  fs::remove(list);
  if (status != 0) {
    Throw<ConfigError>(
        "{} failed; it needs the Debian packages python3 and python3-venv, and from PyPI what "
        "tools/train_network/requirements.txt lists",
        kNetworkScript);
  }
  const nlohmann::json found = nlohmann::json::parse(ReadFile(result));
  fs::remove(result);
  perception::WriteNetworkFile(options.out,
                               {options.classifier, set.classes, set.hash,
                                static_cast<int>(set.images.size()), found.at("held_out_accuracy")},
                               onnx, kNetworkInput_px);
}

void Train(const TrainOptions& options) {
  const TrainingSet set = perception::ReadTrainingSet(options.images);
  for (const std::string& reason : set.left_out) spdlog::warn("left out: {}", reason);
  Say(fmt::format("{} images of {} classes", set.images.size(), set.classes.size()));
  const auto features = kFeatureKinds.find(options.classifier);
  if (features == kFeatureKinds.end()) {
    TrainNetwork(set, options);
  } else {
    FeatureClassifier::Train(features->second, set, options.features, Say)->Save(options.out);
  }
  const perception::ClassifierHeader header = perception::ReadClassifierHeader(options.out);
  fmt::print("{}: {}, {} classes, {} images ({}), {:.3f} of those kept out right\n", options.out,
             header.kind, header.classes.size(), header.images, header.training_hash,
             header.held_out_accuracy);
}

}  // namespace

void AddTrain(CLI::App* app, int*) {
  CLI::App* train = app->add_subcommand("train", "Trains a classifier of crops on images");
  const auto options = std::make_shared<TrainOptions>();  // outlives this function in the callback
  options->background = perception::kBackgroundClass;
  train
      ->add_option("--images", options->images, "Folder with a sub-folder of images for each class")
      ->required();
  train->add_option("--classifier", options->classifier, "Which kind")
      ->required()
      ->check(CLI::IsMember({"svm", "svm2021", "forest", "cnn1", "cnn2", "cnn3", "backbone"}));
  train->add_option("--out", options->out, "Model file; a network's ONNX file goes beside it")
      ->required();
  train->add_option("--background", options->background, "The class that shows no object, if any");
  train->add_option("--folds", options->features.folds, "Of the cross-validation");
  train->add_option("--copies", options->copies, "Of each image, for a network")
      ->check(CLI::Range(1, 1000));
  train->add_option("--seed", options->features.seed, "Of everything that is drawn");
  train->callback([options] { Train(*options); });
}

}  // namespace secondlook::apps

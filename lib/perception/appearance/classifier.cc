#include "lib/perception/appearance/classifier.h"

#include <algorithm>
#include <set>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/perception/appearance/classifier_file.h"
#include "lib/perception/appearance/feature_classifier.h"
#include "lib/perception/appearance/network_classifier.h"

namespace secondlook::perception {
namespace {

namespace fs = std::filesystem;

constexpr int kVersion = 1;

cv::FileStorage Open(const fs::path& path) {
  const std::string text = ReadFile(path);
  cv::FileStorage file;
  try {
    file.open(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
  } catch (const cv::Exception&) {
    Throw<ConfigError>("{}: no model file of a classifier; make one with `secondlook train`",
                       path.string());
  }
  if (!file.isOpened() || file["second_look_classifier"].empty()) {
    Throw<ConfigError>("{}: no model file of a classifier; make one with `secondlook train`",
                       path.string());
  }
  return file;
}

ClassifierHeader ReadHeader(const cv::FileStorage& file, const fs::path& path) {
  const int version = static_cast<int>(file["second_look_classifier"]);
  if (version != kVersion) {
    Throw<ConfigError>("{}: a model file of version {}, this program reads {}; train it anew",
                       path.string(), version, kVersion);
  }
  ClassifierHeader header;
  file["kind"] >> header.kind;
  file["classes"] >> header.classes;
  file["training_hash"] >> header.training_hash;
  file["images"] >> header.images;
  file["held_out_accuracy"] >> header.held_out_accuracy;
  const std::set<std::string> different(header.classes.begin(), header.classes.end());
  if (different.size() < 2 || different.size() != header.classes.size()) {
    Throw<ConfigError>(
        "{}: has {} classes, {} of them different; at least two, all different, are "
        "needed",
        path.string(), header.classes.size(), different.size());
  }
  return header;
}

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

ClassifierHeader ReadClassifierHeader(const fs::path& path) { return ReadHeader(Open(path), path); }

std::unique_ptr<Classifier> LoadClassifier(const fs::path& path) {
  const cv::FileStorage file = Open(path);
  const ClassifierHeader header = ReadHeader(file, path);
  try {
    if (header.kind == "backbone" || header.kind == "cnn1" || header.kind == "cnn2" ||
        header.kind == "cnn3") {
      return std::make_unique<NetworkClassifier>(header, file.root(), path.parent_path());
    }
    if (header.kind == "svm" || header.kind == "svm2021" || header.kind == "forest") {
      return std::make_unique<FeatureClassifier>(header, file.root());
    }
  } catch (const cv::Exception& error) {
    Throw<ConfigError>("{}: damaged: {}", path.string(), error.err);
  }
  Throw<ConfigError>(
      "{}: a classifier of kind '{}'; known: svm, svm2021, forest, cnn1, cnn2, cnn3, backbone",
      path.string(), header.kind);
}

void CheckClasses(const Classifier& classifier, const std::vector<std::string>& classes,
                  const fs::path& path) {
  const std::set<std::string> wanted(classes.begin(), classes.end());
  std::set<std::string> known(classifier.classes().begin(), classifier.classes().end());
  known.erase(kUnknownClass);
  if (wanted != known) {
    Throw<ConfigError>("{}: tells of {}; needed are {}; train it on these", path.string(),
                       Listed({known.begin(), known.end()}),
                       Listed({wanted.begin(), wanted.end()}));
  }
}

void WriteClassifierFile(const fs::path& path, const ClassifierHeader& header,
                         const std::function<void(cv::FileStorage*)>& content) {
  cv::FileStorage file(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "second_look_classifier" << kVersion << "kind" << header.kind << "classes"
       << header.classes << "training_hash" << header.training_hash << "images" << header.images
       << "held_out_accuracy" << header.held_out_accuracy;
  content(&file);
  WriteFile(path, file.releaseAndGetString());
}

}  // namespace secondlook::perception

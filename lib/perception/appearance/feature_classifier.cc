#include "lib/perception/appearance/feature_classifier.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "lib/common/check_range.h"
#include "lib/common/error.h"
#include "lib/common/parallel.h"
#include "lib/common/rng.h"
#include "lib/perception/appearance/classifier_file.h"

namespace secondlook::perception {
namespace {

using Say = std::function<void(const std::string&)>;

/// What is learnt from: a row of features for each sample.
struct Samples {
  cv::Mat rows;
  std::vector<int> labels;
  std::vector<int> folds;      ///< All copies of an image are in one.
  std::vector<bool> original;  ///< An image itself under its own class.
};

const char* Name(FeatureClassifierKind kind) {
  constexpr std::array kNames{"svm", "svm2021", "forest"};
  return kNames[static_cast<std::size_t>(kind)];
}

FeatureKind FeaturesOf(FeatureClassifierKind kind) {
  constexpr std::array kKinds{FeatureKind::kHogAndColors, FeatureKind::kHogAndHu,
                              FeatureKind::kVisualWords};
  return kKinds[static_cast<std::size_t>(kind)];
}

/// In other light, mirrored: what may change without the object becoming another.
cv::Mat Varied(const cv::Mat& image, Rng* rng) {
  cv::Mat varied;
  cv::flip(image, varied, 1);
  varied.convertTo(varied, -1, rng->Uniform(0.7, 1.3), rng->Uniform(-30.0, 30.0));
  return varied;
}

Samples Describe(const TrainingSet& set, const FeatureExtractor& features, bool unknown,
                 const FeatureTrainingConfig& config) {
  const auto count = static_cast<int>(set.images.size());
  std::vector<cv::Mat> rows(static_cast<std::size_t>(count) * config.copies);
  ParallelFor(count, [&](int i) {
    Rng rng(ForkSeed(config.seed, fmt::format("image {}", i)));
    for (int copy = 0; copy < config.copies; ++copy) {
      const cv::Mat& image = set.images[i].image;
      rows[i * config.copies + copy] = features.Describe(copy == 0 ? image : Varied(image, &rng));
    }
  });
  Samples samples;
  std::map<int, int> seen;  // of each class
  const auto unknown_label = static_cast<int>(set.classes.size());
  // Every second image, so that each fold has some of them.
  const auto is_of_half = [&](int number) {
    return (number + (config.folds % 2 == 0 ? number / config.folds : 0)) % 2 == 1;
  };
  const auto add = [&](const cv::Mat& row, int label, int fold, bool original) {
    samples.rows.push_back(row);
    samples.labels.push_back(label);
    samples.folds.push_back(fold);
    samples.original.push_back(original);
  };
  for (int i = 0; i < count; ++i) {
    const int label = set.images[i].label;
    const int number = seen[label]++;
    for (int copy = 0; copy < config.copies; ++copy) {
      const cv::Mat& row = rows[i * config.copies + copy];
      add(row, label, number % config.folds, copy == 0);
      if (unknown && is_of_half(number)) add(row, unknown_label, number % config.folds, false);
    }
  }
  return samples;
}

Samples Subset(const Samples& all, const std::function<bool(int)>& wanted) {
  Samples some;
  for (int i = 0; i < all.rows.rows; ++i) {
    if (!wanted(i)) continue;
    some.rows.push_back(all.rows.row(i));
    some.labels.push_back(all.labels[i]);
    some.folds.push_back(all.folds[i]);
    some.original.push_back(all.original[i]);
  }
  return some;
}

using TrainScorer = std::function<Scorer(const Samples&)>;

/// The scores of each sample by what was trained without its fold.
cv::Mat HeldOutScores(const Samples& samples, int folds, int classes, const TrainScorer& train) {
  cv::Mat scores(samples.rows.rows, classes, CV_32F);
  for (int fold = 0; fold < folds; ++fold) {
    const Scorer scorer = train(Subset(samples, [&](int i) { return samples.folds[i] != fold; }));
    const auto held_out = [&](int i) { return samples.folds[i] == fold; };
    const cv::Mat found = scorer.Score(Subset(samples, held_out).rows);
    for (int i = 0, row = 0; i < scores.rows; ++i) {
      if (held_out(i)) found.row(row++).copyTo(scores.row(i));
    }
  }
  return scores;
}

/// Of the images themselves; the first `named` classes are what can be said.
double Accuracy(const cv::Mat& scores, const Samples& samples, int named) {
  int right = 0;
  int count = 0;
  for (int i = 0; i < scores.rows; ++i) {
    if (!samples.original[i]) continue;
    const float* row = scores.ptr<float>(i);
    if (std::max_element(row, row + named) - row == samples.labels[i]) ++right;
    ++count;
  }
  return static_cast<double>(right) / count;
}

/// The best of a grid, on the images alone without their copies.
KernelParameters FindParameters(const Samples& samples, int named, int classes, int folds,
                                const Say& say) {
  const Samples few =
      Subset(samples, [&](int i) { return samples.original[i] || samples.labels[i] == named; });
  KernelParameters best;
  double most = -1.0;
  for (const double c : {1.0, 10.0}) {
    for (const double width : {0.3, 1.0, 3.0}) {
      const KernelParameters parameters{c, width / few.rows.cols};
      const cv::Mat scores = HeldOutScores(few, folds, classes, [&](const Samples& s) {
        return Scorer::TrainMachines(s.rows, s.labels, classes, parameters);
      });
      const double accuracy = Accuracy(scores, few, named);
      say(fmt::format("C {:g}, gamma {:.2g}: {:.3f} right in {} folds", c, parameters.gamma,
                      accuracy, folds));
      if (accuracy <= most) continue;
      most = accuracy;
      best = parameters;
    }
  }
  return best;
}

void CheckCounts(const TrainingSet& set, int folds) {
  std::vector<int> counts(set.classes.size(), 0);
  for (const TrainingImage& image : set.images) ++counts[image.label];
  for (std::size_t c = 0; c < counts.size(); ++c) {
    if (counts[c] < folds) {
      Throw<ConfigError>("class '{}' has {} images; {} folds need at least as many", set.classes[c],
                         counts[c], folds);
    }
  }
}

}  // namespace

void FeatureTrainingConfig::Validate() const {
  CheckRange(folds, 2, 20, "folds");
  CheckRange(copies, 1, 100, "copies");
}

std::unique_ptr<FeatureClassifier> FeatureClassifier::Train(FeatureClassifierKind kind,
                                                            const TrainingSet& set,
                                                            const FeatureTrainingConfig& config,
                                                            const Say& say) {
  config.Validate();
  CheckCounts(set, config.folds);
  const bool unknown = kind == FeatureClassifierKind::kSvm;
  std::unique_ptr<FeatureClassifier> classifier(new FeatureClassifier);
  ClassifierHeader& header = classifier->header_;
  header = {Name(kind), set.classes, set.hash, static_cast<int>(set.images.size()), 0.0};
  if (unknown) header.classes.emplace_back(kUnknownClass);
  const auto named = static_cast<int>(set.classes.size());
  const auto classes = static_cast<int>(header.classes.size());

  std::vector<cv::Mat> images;
  for (const TrainingImage& image : set.images) images.push_back(image.image);
  classifier->features_ = FeatureExtractor(FeaturesOf(kind), images);
  const Samples samples = Describe(set, classifier->features_, unknown, config);
  say(fmt::format("{} samples of {} features", samples.rows.rows, samples.rows.cols));

  TrainScorer train = [&](const Samples& s) {
    return Scorer::TrainForest(s.rows, s.labels, classes);
  };
  if (kind != FeatureClassifierKind::kForest) {
    const KernelParameters parameters = FindParameters(samples, named, classes, config.folds, say);
    train = [=](const Samples& s) {
      return Scorer::TrainMachines(s.rows, s.labels, classes, parameters);
    };
  }
  const cv::Mat scores = HeldOutScores(samples, config.folds, classes, train);
  header.held_out_accuracy = Accuracy(scores, samples, named);
  say(fmt::format("{:.3f} of the images right when kept out", header.held_out_accuracy));
  for (int c = 0; c < classes; ++c) {
    std::vector<double> score;
    std::vector<bool> positive;
    for (int i = 0; i < scores.rows; ++i) {
      score.push_back(scores.at<float>(i, c));
      positive.push_back(samples.labels[i] == c);
    }
    classifier->sigmoids_.push_back(FitPlatt(score, positive));
  }
  classifier->scorer_ = train(samples);
  return classifier;
}

FeatureClassifier::FeatureClassifier(ClassifierHeader header, const cv::FileNode& node)
    : header_(std::move(header)) {
  features_.Read(node);
  scorer_.Read(node);
  std::vector<double> a;
  std::vector<double> b;
  node["sigmoid_a"] >> a;
  node["sigmoid_b"] >> b;
  if (a.size() != header_.classes.size() || b.size() != a.size()) {
    Throw<ConfigError>("a model file of {} classes has sigmoids for {}; train it anew",
                       header_.classes.size(), a.size());
  }
  for (std::size_t i = 0; i < a.size(); ++i) sigmoids_.push_back({a[i], b[i]});
}

std::vector<double> FeatureClassifier::Classify(const cv::Mat& image) const {
  const cv::Mat scores = scorer_.Score(features_.Describe(image));
  std::vector<double> probabilities;
  double sum = 0.0;
  for (int c = 0; c < scores.cols; ++c) {
    probabilities.push_back(std::max(sigmoids_[c](scores.at<float>(c)), 1e-9));
    sum += probabilities.back();
  }
  for (double& probability : probabilities) probability /= sum;
  return probabilities;
}

void FeatureClassifier::Save(const std::filesystem::path& path) const {
  std::vector<double> a;
  std::vector<double> b;
  for (const PlattSigmoid& sigmoid : sigmoids_) {
    a.push_back(sigmoid.a);
    b.push_back(sigmoid.b);
  }
  WriteClassifierFile(path, header_, [&](cv::FileStorage* file) {
    features_.Write(file);
    scorer_.Write(file);
    *file << "sigmoid_a" << a << "sigmoid_b" << b;
  });
}

}  // namespace secondlook::perception

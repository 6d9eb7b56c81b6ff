#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lib/perception/appearance/classifier.h"
#include "lib/perception/appearance/features.h"
#include "lib/perception/appearance/platt.h"
#include "lib/perception/appearance/scorer.h"
#include "lib/perception/appearance/training_images.h"

namespace secondlook::perception {

enum class FeatureClassifierKind {
  kSvm,      ///< Hoseini 2018: HOG and colours, and the class "unknown".
  kSvm2021,  ///< Hoseini 2021: HOG and Hu moments.
  kForest,   ///< Hoseini 2021: 150 trees on 150 visual words.
};

struct FeatureTrainingConfig {
  int folds{3};   ///< Of the cross-validation that sets parameters and probabilities.
  int copies{2};  ///< Of each image: itself, and so many less one mirrored and in other light.
  std::uint64_t seed{1};

  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// A classifier on features worked out by hand: one score for each class against all others, made a
/// probability by a sigmoid that was fitted to images kept out of training, and normalised.
class FeatureClassifier : public Classifier {
 public:
  /// @param say Told of the progress, a line at a time.
  /// @throws ConfigError when `config` is not valid, or a class has fewer images than folds.
  static std::unique_ptr<FeatureClassifier> Train(
      FeatureClassifierKind kind, const TrainingSet& set, const FeatureTrainingConfig& config,
      const std::function<void(const std::string&)>& say);

  /// Of an open model file.
  FeatureClassifier(ClassifierHeader header, const cv::FileNode& node);

  const std::vector<std::string>& classes() const override { return header_.classes; }
  std::vector<double> Classify(const cv::Mat& image) const override;
  double held_out_accuracy() const override { return header_.held_out_accuracy; }

  /// Writes the model file. @throws ConfigError when it cannot be written.
  void Save(const std::filesystem::path& path) const;

 private:
  FeatureClassifier() = default;

  ClassifierHeader header_;
  FeatureExtractor features_;
  Scorer scorer_;
  std::vector<PlattSigmoid> sigmoids_;  // a class each
};

}  // namespace secondlook::perception

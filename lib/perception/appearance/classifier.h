#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace secondlook::perception {

/// The name of the class that stands for all classes together: its probability is m(Omega) (Hoseini
/// 2018, 2.2). Only a classifier that was trained with it has it, as its last class.
inline constexpr const char* kUnknownClass = "unknown";

/// The name of the class of crops that show no object.
inline constexpr const char* kBackgroundClass = "Background";

/// Says of which class an object is by what it looks like.
class Classifier {
 public:
  Classifier() = default;
  Classifier(const Classifier&) = delete;
  Classifier& operator=(const Classifier&) = delete;
  virtual ~Classifier() = default;

  /// What Classify() tells of, in this order. Constant.
  virtual const std::vector<std::string>& classes() const = 0;

  /// The probability of each class for an object's crop `image` (CV_8UC3, RGB, any size): >= 0, sum
  /// to 1. The same image gives the same probabilities. May be called from several threads.
  /// @throws InvalidArgument for what is no such image.
  virtual std::vector<double> Classify(const cv::Mat& image) const = 0;

  /// The share of images kept out of training that were classified rightly: how far what it says of
  /// one view is to be trusted. In [0, 1].
  virtual double held_out_accuracy() const = 0;
};

/// What every model file begins with.
struct ClassifierHeader {
  std::string kind;                  ///< svm, svm2021, forest, cnn1, cnn2, cnn3 or backbone.
  std::vector<std::string> classes;  ///< At least two, all different.
  std::string training_hash;         ///< Of names and contents of the images it was trained on.
  int images{};                      ///< How many these were.
  double held_out_accuracy{};
};

/// The header of the model file `path`.
/// @throws ConfigError naming the file when it is missing, no model file, of another version, or
/// incomplete.
ClassifierHeader ReadClassifierHeader(const std::filesystem::path& path);

/// The classifier of the model file `path`, whatever its kind.
/// @throws ConfigError as ReadClassifierHeader(), and for a file that is damaged or of another
/// kind.
std::unique_ptr<Classifier> LoadClassifier(const std::filesystem::path& path);

/// @throws ConfigError naming file and classes unless `classifier` tells exactly of `classes`, in
/// any order; kUnknownClass may be one more.
void CheckClasses(const Classifier& classifier, const std::vector<std::string>& classes,
                  const std::filesystem::path& path);

}  // namespace secondlook::perception

#pragma once

#include <vector>

#include <opencv2/ml.hpp>

namespace secondlook::perception {

/// Of the support vector machines: how dear errors are, and one over how wide the kernel is.
struct KernelParameters {
  double c{1.0};
  double gamma{1.0};
};

/// Scores of all classes for rows of features: larger is likelier, in no unit.
class Scorer {
 public:
  Scorer() = default;  ///< To be Read().

  /// A support vector machine for each class against the rest, errors weighed by how rare a class
  /// is. @param labels In [0, classes), each at least once.
  static Scorer TrainMachines(const cv::Mat& rows, const std::vector<int>& labels, int classes,
                              const KernelParameters& parameters);

  /// A forest of 150 trees by Gini impurity; the score is the share of trees.
  static Scorer TrainForest(const cv::Mat& rows, const std::vector<int>& labels, int classes);

  /// [n, classes] CV_32F.
  cv::Mat Score(const cv::Mat& rows) const;

  void Write(cv::FileStorage* file) const;
  void Read(const cv::FileNode& node);

 private:
  std::vector<cv::Ptr<cv::ml::SVM>> machines_;  // a class each; or
  cv::Ptr<cv::ml::RTrees> forest_;
};

}  // namespace secondlook::perception

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace secondlook::apps {

/// How often things of each class (row) were said to be of each class (column), as in Hoseini 2018,
/// Section 3. The last row and column are the background: its column counts things that were not
/// detected at all, its row whatever was detected where no thing is, or a second time.
class ConfusionMatrix {
 public:
  static constexpr int kBackground = -1;

  /// @pre `classes` > 0.
  explicit ConfusionMatrix(int classes)
      : counts_(Eigen::MatrixXd::Zero(classes + 1, classes + 1)) {}

  /// @pre Both are classes or kBackground, and not both the background.
  void Add(int truth, int said);
  ConfusionMatrix& operator+=(const ConfusionMatrix& other);

  /// [classes + 1, classes + 1].
  const Eigen::MatrixXd& counts() const { return counts_; }

  double Accuracy() const;   ///< True detections among all things that there are.
  double Precision() const;  ///< Mean over classes, as are the next; of a class never said it is 0.
  double Recall() const;
  double F1() const;  ///< Harmonic mean of the two (as in the paper).
  double FalseDetections() const { return counts_.bottomRows(1).sum(); }

 private:
  int At(int c) const { return c == kBackground ? static_cast<int>(counts_.rows()) - 1 : c; }

  Eigen::MatrixXd counts_;
};

/// Writes `matrix` as a PNG: each row's shares as shades, counts as numbers.
/// @throws ConfigError when it cannot be written.
void WritePicture(const ConfusionMatrix& matrix, const std::vector<std::string>& classes,
                  const std::string& title, const std::filesystem::path& path);

}  // namespace secondlook::apps

#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/persistence.hpp>

namespace secondlook::perception {

enum class FeatureKind {
  kHogAndColors,  ///< Gradients and the three histograms of R, G and B (Hoseini 2018, 2).
  kHogAndHu,      ///< 60 principal components of gradients, Hu moments of R, G and B (2021, 5.3).
  kVisualWords,   ///< How often each of 150 words occurs; SIFT, for SURF is not in Debian's OpenCV.
};

/// Turns an image of any size into a row of numbers, each of mean 0 and deviation 1 over the images
/// that it was learnt from.
class FeatureExtractor {
 public:
  FeatureExtractor() = default;  ///< To be Read().

  /// Learns components, words and scales from `images` (CV_8UC3, RGB). The same images give the
  /// same extractor.
  FeatureExtractor(FeatureKind kind, const std::vector<cv::Mat>& images);

  /// [1, n] CV_32F. @throws InvalidArgument for what is no CV_8UC3 image with pixels.
  cv::Mat Describe(const cv::Mat& image) const;

  void Write(cv::FileStorage* file) const;
  void Read(const cv::FileNode& node);

 private:
  cv::Mat Raw(const cv::Mat& image) const;

  FeatureKind kind_{};
  cv::Mat pca_mean_, pca_vectors_;  // of kHogAndHu
  cv::Mat words_;                   // of kVisualWords, one a row
  cv::Mat mean_, scale_;
};

}  // namespace secondlook::perception

#include "lib/perception/appearance/features.h"

#include <array>
#include <cmath>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include "lib/common/error.h"

namespace secondlook::perception {
namespace {

constexpr int kComponents = 60;
constexpr int kWords = 150;
constexpr int kColorBins = 16;
constexpr int kSide_px = 128;

cv::Mat AsRow(const std::vector<float>& values) { return cv::Mat(values, true).reshape(1, 1); }

cv::Mat Hog(const cv::Mat& image, int side_px) {
  const cv::HOGDescriptor hog({side_px, side_px}, {32, 32}, {16, 16}, {16, 16}, 9);
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_RGB2GRAY);
  cv::resize(gray, gray, {side_px, side_px}, 0.0, 0.0, cv::INTER_LINEAR);
  std::vector<float> values;
  hog.compute(gray, values);
  return AsRow(values);
}

cv::Mat ColorHistograms(const cv::Mat& image) {
  std::vector<float> shares(3 * kColorBins, 0.0F);
  const float share = 1.0F / static_cast<float>(image.total());
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const auto& pixel = image.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c) shares[c * kColorBins + pixel[c] * kColorBins / 256] += share;
    }
  }
  return AsRow(shares);
}

/// On a logarithmic scale, as they span many decades.
cv::Mat HuMoments(const cv::Mat& image) {
  std::array<cv::Mat, 3> planes;
  cv::split(image, planes.data());
  std::vector<float> values;
  for (const cv::Mat& plane : planes) {
    std::array<double, 7> hu{};
    cv::HuMoments(cv::moments(plane), hu.data());
    for (const double h : hu) {
      values.push_back(
          static_cast<float>(std::copysign(std::log10(std::abs(h) + 1e-30) + 30.0, h)));
    }
  }
  return AsRow(values);
}

/// SIFT descriptors, one a row; none for an image without keypoints.
cv::Mat KeypointDescriptors(const cv::Mat& image) {
  cv::Mat gray;
  cv::cvtColor(image, gray, cv::COLOR_RGB2GRAY);
  cv::resize(gray, gray, {kSide_px, kSide_px}, 0.0, 0.0, cv::INTER_LINEAR);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  cv::SIFT::create(0, 3, 0.02, 15.0)->detectAndCompute(gray, cv::noArray(), keypoints, descriptors);
  return descriptors;
}

cv::Mat LearnWords(const std::vector<cv::Mat>& images) {
  cv::Mat all;
  for (const cv::Mat& image : images) {
    const cv::Mat descriptors = KeypointDescriptors(image);
    if (!descriptors.empty()) all.push_back(descriptors);
  }
  if (all.rows < kWords) {
    Throw<InvalidArgument>("{} keypoints in {} images; {} visual words need more of them", all.rows,
                           images.size(), kWords);
  }
  cv::theRNG().state = 1;  // k-means draws from the one of its thread
  cv::Mat labels;
  cv::Mat words;
  cv::kmeans(all, kWords, labels, {cv::TermCriteria::MAX_ITER + cv::TermCriteria::EPS, 15, 1e-3}, 1,
             cv::KMEANS_PP_CENTERS, words);
  return words;
}

/// The share of each word among the keypoints.
cv::Mat WordShares(const cv::Mat& image, const cv::Mat& words) {
  cv::Mat shares = cv::Mat::zeros(1, words.rows, CV_32F);
  const cv::Mat descriptors = KeypointDescriptors(image);
  for (int i = 0; i < descriptors.rows; ++i) {
    int nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int w = 0; w < words.rows; ++w) {
      const double distance = cv::norm(descriptors.row(i), words.row(w), cv::NORM_L2SQR);
      if (distance < least) {
        least = distance;
        nearest = w;
      }
    }
    shares.at<float>(nearest) += 1.0F / static_cast<float>(descriptors.rows);
  }
  return shares;
}

}  // namespace

FeatureExtractor::FeatureExtractor(FeatureKind kind, const std::vector<cv::Mat>& images)
    : kind_(kind) {
  if (kind == FeatureKind::kHogAndHu) {
    cv::Mat gradients;
    for (const cv::Mat& image : images) gradients.push_back(Hog(image, kSide_px));
    const cv::PCA pca(gradients, cv::noArray(), cv::PCA::DATA_AS_ROW, kComponents);
    pca_mean_ = pca.mean;
    pca_vectors_ = pca.eigenvectors;
  }
  if (kind == FeatureKind::kVisualWords) words_ = LearnWords(images);
  cv::Mat all;
  for (const cv::Mat& image : images) all.push_back(Raw(image));
  cv::reduce(all, mean_, 0, cv::REDUCE_AVG);
  scale_ = cv::Mat::ones(1, all.cols, CV_32F);
  for (int c = 0; c < all.cols; ++c) {
    const double deviation =
        cv::norm(all.col(c) - mean_.at<float>(c)) / std::sqrt(static_cast<double>(all.rows));
    if (deviation > 1e-9) scale_.at<float>(c) = static_cast<float>(1.0 / deviation);
  }
}

cv::Mat FeatureExtractor::Raw(const cv::Mat& image) const {
  cv::Mat features;
  switch (kind_) {
    case FeatureKind::kHogAndColors:
      cv::hconcat(Hog(image, kSide_px / 2), ColorHistograms(image), features);
      break;
    case FeatureKind::kHogAndHu: {
      const cv::Mat reduced = (Hog(image, kSide_px) - pca_mean_) * pca_vectors_.t();
      cv::hconcat(reduced, HuMoments(image), features);
      break;
    }
    case FeatureKind::kVisualWords:
      features = WordShares(image, words_);
      break;
  }
  return features;
}

cv::Mat FeatureExtractor::Describe(const cv::Mat& image) const {
  if (image.empty() || image.type() != CV_8UC3) {
    Throw<InvalidArgument>(
        "an image of {} x {} pixels of type {}: an RGB image of 8 bits is needed", image.cols,
        image.rows, image.type());
  }
  return (Raw(image) - mean_).mul(scale_);
}

void FeatureExtractor::Write(cv::FileStorage* file) const {
  *file << "feature_kind" << static_cast<int>(kind_) << "pca_mean" << pca_mean_ << "pca_vectors"
        << pca_vectors_ << "words" << words_ << "mean" << mean_ << "scale" << scale_;
}

void FeatureExtractor::Read(const cv::FileNode& node) {
  kind_ = static_cast<FeatureKind>(static_cast<int>(node["feature_kind"]));
  node["pca_mean"] >> pca_mean_;
  node["pca_vectors"] >> pca_vectors_;
  node["words"] >> words_;
  node["mean"] >> mean_;
  node["scale"] >> scale_;
}

}  // namespace secondlook::perception

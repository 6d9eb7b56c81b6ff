#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include <opencv2/dnn.hpp>

#include "lib/perception/appearance/classifier.h"

namespace secondlook::perception {

/// A convolutional network by OpenCV's DNN module, trained by tools/train_network:
/// EfficientNet-Lite0 fine-tuned, or one of the three of Hoseini 2021. Its model file names the
/// ONNX file beside it, and that file's hash. It is shown each image and its mirror image, and says
/// the mean: a thing seen in a mirror is of the same class.
class NetworkClassifier : public Classifier {
 public:
  /// Of an open model file in `folder`. @throws ConfigError naming the ONNX file when it is
  /// missing, another one than the model file was made with, cannot be read, or tells of another
  /// number of classes.
  NetworkClassifier(ClassifierHeader header, const cv::FileNode& node,
                    const std::filesystem::path& folder);

  const std::vector<std::string>& classes() const override { return header_.classes; }
  std::vector<double> Classify(const cv::Mat& image) const override;
  double held_out_accuracy() const override { return header_.held_out_accuracy; }

 private:
  ClassifierHeader header_;
  int input_px_{};
  mutable std::mutex mutex_;  // forward() writes into the network
  mutable cv::dnn::Net net_;
};

/// Writes the model file `path` of the network `onnx`, which must lie in the same folder; its input
/// is RGB in 0..255, [1, 3, input_px, input_px], its output the probabilities of header.classes.
/// @throws ConfigError when a file cannot be read or written.
void WriteNetworkFile(const std::filesystem::path& path, const ClassifierHeader& header,
                      const std::filesystem::path& onnx, int input_px);

}  // namespace secondlook::perception

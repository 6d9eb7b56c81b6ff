#include "lib/perception/appearance/network_classifier.h"

#include <utility>

#include <opencv2/imgproc.hpp>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "lib/common/hash.h"
#include "lib/perception/appearance/classifier_file.h"

namespace secondlook::perception {
namespace {

/// A word in front, as a number of digits alone would be read as a number.
std::string ContentHash(const std::string& bytes) { return "fnv1a " + HexDigits(Fnv1a(bytes)); }

}  // namespace

NetworkClassifier::NetworkClassifier(ClassifierHeader header, const cv::FileNode& node,
                                     const std::filesystem::path& folder)
    : header_(std::move(header)), input_px_(static_cast<int>(node["input_px"])) {
  const std::filesystem::path onnx = folder / static_cast<std::string>(node["network"]);
  const std::string bytes = ReadFile(onnx);
  if (ContentHash(bytes) != static_cast<std::string>(node["network_hash"])) {
    Throw<ConfigError>("{}: is not the network that the model file was made with; train it anew",
                       onnx.string());
  }
  try {
    net_ = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
  } catch (const cv::Exception& error) {
    Throw<ConfigError>("{}: cannot be read as ONNX: {}", onnx.string(), error.err);
  }
  const std::size_t outputs = Classify(cv::Mat(input_px_, input_px_, CV_8UC3, cv::Scalar())).size();
  if (outputs != header_.classes.size()) {
    Throw<ConfigError>("{}: tells of {} classes, its model file of {}", onnx.string(), outputs,
                       header_.classes.size());
  }
}

std::vector<double> NetworkClassifier::Classify(const cv::Mat& image) const {
  if (image.empty() || image.type() != CV_8UC3) {
    Throw<InvalidArgument>(
        "an image of {} x {} pixels of type {}: an RGB image of 8 bits is needed", image.cols,
        image.rows, image.type());
  }
  cv::Mat input;
  cv::resize(image, input, {input_px_, input_px_}, 0.0, 0.0, cv::INTER_LINEAR);
  cv::Mat mirrored;
  cv::flip(input, mirrored, 1);
  std::vector<double> probabilities;
  const std::lock_guard lock(mutex_);
  for (const cv::Mat& shown : {input, mirrored}) {
    net_.setInput(cv::dnn::blobFromImage(shown));
    const cv::Mat output = net_.forward();
    probabilities.resize(output.total(), 0.0);
    for (std::size_t c = 0; c < probabilities.size(); ++c) {
      probabilities[c] += 0.5 * output.at<float>(static_cast<int>(c));
    }
  }
  for (std::size_t c = 0; c < probabilities.size(); ++c) {
    if (!(probabilities[c] >= 0.0)) {
      Throw<ConfigError>("a network of kind '{}' gives class {} the probability {}; train it anew",
                         header_.kind, c + 1, probabilities[c]);
    }
  }
  return probabilities;
}

void WriteNetworkFile(const std::filesystem::path& path, const ClassifierHeader& header,
                      const std::filesystem::path& onnx, int input_px) {
  const std::string hash = ContentHash(ReadFile(onnx));
  WriteClassifierFile(path, header, [&](cv::FileStorage* file) {
    *file << "input_px" << input_px << "network" << onnx.filename().string() << "network_hash"
          << hash;
  });
}

}  // namespace secondlook::perception

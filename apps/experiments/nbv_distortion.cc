#include "apps/experiments/nbv_distortion.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace secondlook::apps {
namespace {

using planning::ObjectCrop;

constexpr double kCorner = 0.6;  // of the length and of the width

void Blank(ObjectCrop* crop, const cv::Rect& half, int level) {
  crop->color(half).setTo(cv::Scalar::all(level));
  if (crop->depth.empty()) return;
  const cv::Scalar mean = cv::mean(crop->depth, crop->depth > 0.0F);
  crop->depth(half).setTo(mean);
}

void Cover(ObjectCrop* crop, const ObjectCrop& other, bool top, bool left) {
  const cv::Size size = crop->color.size();
  const cv::Size patch(static_cast<int>(kCorner * size.width),
                       static_cast<int>(kCorner * size.height));
  if (patch.empty()) return;
  const cv::Rect corner({left ? 0 : size.width - patch.width, top ? 0 : size.height - patch.height},
                        patch);
  cv::Mat color;
  cv::resize(other.color, color, size, 0.0, 0.0, cv::INTER_LINEAR);
  color(corner).copyTo(crop->color(corner));
  if (crop->depth.empty() || other.depth.empty()) return;
  cv::Mat depth;
  cv::resize(other.depth, depth, size, 0.0, 0.0, cv::INTER_NEAREST);
  depth(corner).copyTo(crop->depth(corner));
}

void AddNoise(cv::Mat* color, double sigma, Rng* rng) {
  for (int v = 0; v < color->rows; ++v) {
    for (int u = 0; u < color->cols; ++u) {
      for (int c = 0; c < 3; ++c) {
        auto& level = color->at<cv::Vec3b>(v, u)[c];
        level = cv::saturate_cast<std::uint8_t>(level + rng->Gaussian(sigma));
      }
    }
  }
}

}  // namespace

ObjectCrop Distorted(const ObjectCrop& crop, int distortion, const ObjectCrop& other, Rng* rng) {
  ObjectCrop result{crop.color.clone(), crop.depth.clone(), crop.focal_length_px};
  const int width = crop.color.cols;
  const int height = crop.color.rows;
  switch (distortion) {
    case 1:
      Blank(&result, {0, 0, width, height / 2}, 255);
      break;
    case 2:
      Blank(&result, {0, height - height / 2, width, height / 2}, 255);
      break;
    case 3:
      Blank(&result, {0, 0, width / 2, height}, 0);
      break;
    case 4:
      Blank(&result, {width - width / 2, 0, width / 2, height}, 0);
      break;
    case 5:
    case 6:
      AddNoise(&result.color, distortion == 5 ? 20.0 : 30.0, rng);
      break;
    case 7:
    case 8:
    case 9:
    case 10:
      Cover(&result, other, distortion <= 8, distortion % 2 == 1);
      break;
    case 11:
    case 12: {
      const int size = distortion == 11 ? 5 : 9;
      cv::GaussianBlur(result.color, result.color, {size, size}, 0.0);
      break;
    }
    case 13:
    case 14:
      result.color.convertTo(result.color, -1, 1.0, distortion == 13 ? 150.0 : -150.0);
      break;
    default:
      break;
  }
  return result;
}

ObjectCrop Mirrored(const ObjectCrop& crop) {
  ObjectCrop mirrored{{}, {}, crop.focal_length_px};
  cv::flip(crop.color, mirrored.color, 1);
  if (!crop.depth.empty()) cv::flip(crop.depth, mirrored.depth, 1);
  return mirrored;
}

}  // namespace secondlook::apps

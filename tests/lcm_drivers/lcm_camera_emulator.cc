#include "tests/lcm_drivers/lcm_camera_emulator.h"

#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/deflate.h"
#include "lib/hal/drivers/sender_time.h"

namespace secondlook::hal {
namespace {

using bot_core::image_t;
using bot_core::images_t;
using Bytes = std::vector<std::uint8_t>;

image_t Described(const RgbdFrame& frame, std::int32_t format, std::int32_t row_stride,
                  Bytes data) {
  image_t image{};
  image.utime = Microseconds(frame.time);
  image.width = frame.color.cols;
  image.height = frame.color.rows;
  image.row_stride = row_stride;
  image.pixelformat = format;
  image.size = static_cast<std::int32_t>(data.size());
  image.data = std::move(data);
  return image;
}

Bytes BytesOf(const cv::Mat& image) {
  const cv::Mat dense = image.isContinuous() ? image : image.clone();
  return {dense.data, dense.data + dense.total() * dense.elemSize()};
}

/// Millimetres, 0 = none.
Bytes DepthBytes(const cv::Mat& depth) {
  cv::Mat millimetres(depth.size(), CV_16UC1);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const double z = std::round(1e3 * depth.at<float>(v, u));
      const bool fits = z > 0.0 && z <= std::numeric_limits<std::uint16_t>::max();
      millimetres.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(fits ? z : 0.0);
    }
  }
  return BytesOf(millimetres);
}

void Append(std::int16_t type, image_t image, images_t* message) {
  message->utime = image.utime;
  message->image_types.push_back(type);
  message->images.push_back(std::move(image));
  message->n_images = static_cast<std::int32_t>(message->images.size());
}

}  // namespace

images_t WriteImages(const RgbdFrame& frame) {
  images_t message{};
  cv::Mat bgr;
  cv::cvtColor(frame.color, bgr, cv::COLOR_RGB2BGR);
  Bytes jpeg;
  cv::imencode(".jpg", bgr, jpeg, {cv::IMWRITE_JPEG_QUALITY, 95});
  Append(images_t::LEFT, Described(frame, image_t::PIXEL_FORMAT_MJPEG, 0, std::move(jpeg)),
         &message);
  if (frame.depth.empty()) return message;
  Append(images_t::DEPTH_MM_ZIPPED,
         Described(frame, image_t::PIXEL_FORMAT_LE_GRAY16, 2 * frame.depth.cols,
                   Deflate(DepthBytes(frame.depth))),
         &message);
  return message;
}

images_t WriteRawImages(const RgbdFrame& frame) {
  images_t message{};
  Append(images_t::LEFT,
         Described(frame, image_t::PIXEL_FORMAT_RGB, 3 * frame.color.cols, BytesOf(frame.color)),
         &message);
  if (frame.depth.empty()) return message;
  Append(images_t::DEPTH_MM,
         Described(frame, image_t::PIXEL_FORMAT_LE_GRAY16, 2 * frame.depth.cols,
                   DepthBytes(frame.depth)),
         &message);
  return message;
}

LcmCameraEmulator::LcmCameraEmulator(LcmLink* link, std::string channel,
                                     std::function<RgbdFrame()> see)
    : link_(link), channel_(std::move(channel)), see_(std::move(see)) {
  thread_ = std::thread([this] { Run(); });
}

LcmCameraEmulator::~LcmCameraEmulator() {
  quit_ = true;
  thread_.join();
}

void LcmCameraEmulator::Run() {
  while (!quit_) {
    std::this_thread::sleep_for(std::chrono::milliseconds(33));
    if (silent_) continue;
    bot_core::images_t message = WriteImages(see_());
    {
      const std::scoped_lock lock(mutex_);
      if (spoil_) spoil_(&message);
    }
    link_->Publish(transport::Pack(channel_.c_str(), message));
  }
}

}  // namespace secondlook::hal

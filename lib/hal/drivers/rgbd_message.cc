#include "lib/hal/drivers/rgbd_message.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/deflate.h"
#include "lib/common/error.h"
#include "lib/hal/drivers/sender_time.h"

namespace secondlook::hal {
namespace {

using bot_core::image_t;
using bot_core::images_t;
using Bytes = std::vector<std::uint8_t>;

static_assert(std::endian::native == std::endian::little, "depth is read as it was sent");

/// The image of one of the `types`; null when there is none.
const image_t* Find(const images_t& message, std::initializer_list<int> types, int* type) {
  const std::size_t count = std::min(message.images.size(), message.image_types.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (std::find(types.begin(), types.end(), message.image_types[i]) == types.end()) continue;
    *type = message.image_types[i];
    return &message.images[i];
  }
  return nullptr;
}

void RequireSize(const std::string& what, cv::Size found, const CameraModel& wanted) {
  if (found.width == wanted.width && found.height == wanted.height) return;
  Throw<ProtocolError>(
      "{} is {} x {}, and the intrinsics are those of {} x {}: send it in that size, depth "
      "registered to colour, or set width, height and intrinsics",
      what, found.width, found.height, wanted.width, wanted.height);
}

/// Rows of `row_bytes` each out of a buffer whose rows are `stride` apart.
cv::Mat FromRows(const std::string& what, const Bytes& data, int stride, cv::Size size, int type) {
  const std::size_t row_bytes = static_cast<std::size_t>(size.width) * CV_ELEM_SIZE(type);
  const std::size_t step = stride == 0 ? row_bytes : static_cast<std::size_t>(stride);
  if (stride < 0 || step < row_bytes ||
      data.size() < step * static_cast<std::size_t>(size.height - 1) + row_bytes) {
    Throw<ProtocolError>("{}: {} bytes with {} a row do not hold {} x {} pixels", what, data.size(),
                         stride, size.width, size.height);
  }
  return cv::Mat(size, type, const_cast<std::uint8_t*>(data.data()), step).clone();
}

cv::Mat ReadColor(const image_t& image, const CameraModel& model) {
  RequireSize("colour", {image.width, image.height}, model);
  if (image.pixelformat == image_t::PIXEL_FORMAT_RGB) {
    return FromRows("colour", image.data, image.row_stride, {image.width, image.height}, CV_8UC3);
  }
  if (image.pixelformat != image_t::PIXEL_FORMAT_MJPEG) {
    Throw<ProtocolError>("colour has pixel format {}: send MJPEG ({}) or RGB ({})",
                         image.pixelformat, std::int32_t{image_t::PIXEL_FORMAT_MJPEG},
                         std::int32_t{image_t::PIXEL_FORMAT_RGB});
  }
  const std::optional<cv::Size> size = JpegSize(image.data);
  if (!size) Throw<ProtocolError>("colour is sent as MJPEG, and its {} bytes are none", image.size);
  RequireSize("the JPEG of colour", *size, model);
  const cv::Mat bgr = cv::imdecode(image.data, cv::IMREAD_COLOR);
  if (bgr.size() != *size) Throw<ProtocolError>("colour: its JPEG cannot be decoded");
  cv::Mat rgb;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

cv::Mat ReadDepth(const image_t& image, bool zipped, const CameraInfo& info) {
  RequireSize("depth", {image.width, image.height}, info.model);
  const cv::Size size(image.width, image.height);
  // Known by its image type: senders write all sorts of things into its pixel format.
  Bytes inflated;
  if (zipped) inflated = Inflate(image.data, static_cast<std::size_t>(size.area()) * 2);
  const cv::Mat millimetres = zipped
                                  ? FromRows("depth", inflated, 0, size, CV_16UC1)
                                  : FromRows("depth", image.data, image.row_stride, size, CV_16UC1);
  cv::Mat depth(size, CV_32FC1);
  for (int v = 0; v < size.height; ++v) {
    const auto* row = millimetres.ptr<std::uint16_t>(v);
    auto* out = depth.ptr<float>(v);
    for (int u = 0; u < size.width; ++u) {
      const double z = row[u] * 1e-3;
      out[u] = static_cast<float>(z >= info.min_depth && z <= info.max_depth ? z : NAN);
    }
  }
  return depth;
}

}  // namespace

std::optional<cv::Size> JpegSize(const Bytes& bytes) {
  const auto word = [&](std::size_t i) { return bytes[i] << 8 | bytes[i + 1]; };
  if (bytes.size() < 4 || word(0) != 0xffd8) return std::nullopt;
  // Segments: marker, length (itself included), content. The size stands in the frame's header,
  // SOF0 to SOF15, of which three numbers are used for other things.
  for (std::size_t at = 2; at + 9 <= bytes.size() && bytes[at] == 0xff;) {
    const int marker = bytes[at + 1];
    const bool frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return cv::Size(word(at + 7), word(at + 5));
    at += marker == 0xff ? 1 : 2 + static_cast<std::size_t>(word(at + 2));
  }
  return std::nullopt;
}

ReceivedImages ReadImages(const images_t& message, const CameraInfo& info, Duration max_apart) {
  int type = 0;
  const image_t* color = Find(message, {images_t::LEFT}, &type);
  const image_t* depth = info.has_depth
                             ? Find(message, {images_t::DEPTH_MM, images_t::DEPTH_MM_ZIPPED}, &type)
                             : nullptr;
  if (color == nullptr || (info.has_depth && depth == nullptr)) {
    Throw<ProtocolError>("no {} among its {} images: send colour as LEFT ({}) {} in one message",
                         color == nullptr ? "colour" : "depth", message.images.size(),
                         std::int32_t{images_t::LEFT},
                         info.has_depth ? "and depth as DEPTH_MM (4) or DEPTH_MM_ZIPPED (6)" : "");
  }
  ReceivedImages images;
  images.stamp = StampOf(color->utime);
  images.color = ReadColor(*color, info.model);
  if (depth == nullptr) return images;
  const Duration apart = StampOf(depth->utime) - images.stamp;
  if (apart > max_apart || -apart > max_apart) {
    Throw<ProtocolError>(
        "colour and depth were taken {:.3f} s apart, at most {:.3f} s are taken for one frame: let "
        "the camera synchronise them",
        std::abs(ToSeconds(apart)), ToSeconds(max_apart));
  }
  images.depth = ReadDepth(*depth, type == images_t::DEPTH_MM_ZIPPED, info);
  return images;
}

}  // namespace secondlook::hal

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "lib/hal/camera.h"

#include "bot_core/images_t.hpp"

namespace secondlook::hal {

/// The images of one message, with the stamp that its sender gave them.
struct ReceivedImages {
  Duration stamp{};  ///< Since the epoch of the sender's clock.
  cv::Mat color;     ///< As RgbdFrame has both.
  cv::Mat depth;
};

/// Reads colour from LEFT (JPEG, or RGB, 8 bits each) and, for a camera that has it, depth from
/// DEPTH_MM or DEPTH_MM_ZIPPED (16 bits, little-endian, 0 = none; the latter a zlib stream), which
/// must be registered to colour. Sizes are checked before anything is decoded.
/// @param max_apart How far the stamps of colour and depth may differ.
/// @throws ProtocolError for an image that is missing, of another size or format than `info` and
/// this say, or cut off, and for stamps too far apart, with what to change at the sender.
ReceivedImages ReadImages(const bot_core::images_t& message, const CameraInfo& info,
                          Duration max_apart);

/// Columns and rows that the header of a JPEG file states; empty when it is none.
std::optional<cv::Size> JpegSize(const std::vector<std::uint8_t>& bytes);

}  // namespace secondlook::hal

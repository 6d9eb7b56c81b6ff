#pragma once

#include <vector>

#include "lib/hal/camera.h"

#include "second_look/rec_image_t.hpp"

namespace secondlook::hal {

/// The images of `frame`, lossless, in pieces that fit on the bus; without their utime.
///
/// Colour is a PNG. A depth sensor measures in steps, so its depth takes few different values:
/// these make a table, and a 16-bit PNG holds for each pixel where in it its depth stands. Depth of
/// more than 16,384 values is compressed as it is. Which NaN a pixel without depth holds is lost.
std::vector<second_look::rec_image_t> EncodeImages(const RgbdFrame& frame);

/// Puts the image whose pieces these are, in order, into `frame`.
/// @throws ProtocolError naming the frame when a piece is missing or they hold no such image.
void DecodeImage(const std::vector<second_look::rec_image_t>& pieces, RgbdFrame* frame);

}  // namespace secondlook::hal

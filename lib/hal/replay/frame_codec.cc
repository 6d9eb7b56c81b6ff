#include "lib/hal/replay/frame_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "lib/common/deflate.h"
#include "lib/common/error.h"

namespace secondlook::hal {
namespace {

using second_look::rec_image_t;
using Bytes = std::vector<std::uint8_t>;

/// A piece is no longer, its table of values aside.
constexpr std::size_t kPieceBytes = 30'000;
/// So many values and kPieceBytes stay under the longest message there may be.
constexpr std::size_t kMaxValues = 16'384;
/// No camera has more rows or columns [px].
constexpr int kMaxSide = 8192;

Bytes ToPng(const cv::Mat& image) {
  Bytes png;
  cv::imencode(".png", image, png, {cv::IMWRITE_PNG_COMPRESSION, 1});
  return png;
}

/// The different values of `depth`, ascending, NaN first; empty when there are too many.
std::vector<float> ValuesOf(const cv::Mat& depth,
                            std::unordered_map<std::uint32_t, std::uint16_t>* index) {
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      if (std::isnan(z)) continue;
      index->try_emplace(std::bit_cast<std::uint32_t>(z));
      if (index->size() >= kMaxValues) return {};
    }
  }
  std::vector<float> values{std::numeric_limits<float>::quiet_NaN()};
  for (const auto& [bits, unset] : *index) values.push_back(std::bit_cast<float>(bits));
  std::sort(values.begin() + 1, values.end(),
            [](float a, float b) { return a != b ? a < b : std::signbit(a) && !std::signbit(b); });
  for (std::size_t i = 1; i < values.size(); ++i) {
    (*index)[std::bit_cast<std::uint32_t>(values[i])] = static_cast<std::uint16_t>(i);
  }
  return values;
}

Bytes EncodeDepth(const cv::Mat& depth, rec_image_t* image) {
  std::unordered_map<std::uint32_t, std::uint16_t> index;
  image->values = ValuesOf(depth, &index);
  image->num_values = static_cast<std::int32_t>(image->values.size());
  if (image->values.empty()) {
    image->encoding = rec_image_t::ZLIB_FLOAT;
    const cv::Mat whole = depth.isContinuous() ? depth : depth.clone();
    return Deflate({whole.data, whole.total() * whole.elemSize()});
  }
  image->encoding = rec_image_t::PNG_INDEX;
  cv::Mat indices(depth.size(), CV_16UC1);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      indices.at<std::uint16_t>(v, u) =
          std::isnan(z) ? std::uint16_t{0} : index.at(std::bit_cast<std::uint32_t>(z));
    }
  }
  return ToPng(indices);
}

/// Appends `image` with `bytes` as its data, cut into pieces; the first has the values.
void AddPieces(rec_image_t image, const Bytes& bytes, std::vector<rec_image_t>* pieces) {
  image.pieces = static_cast<std::int32_t>((bytes.size() + kPieceBytes - 1) / kPieceBytes);
  for (image.piece = 0; image.piece < image.pieces; ++image.piece) {
    const std::size_t begin = static_cast<std::size_t>(image.piece) * kPieceBytes;
    const std::size_t end = std::min(begin + kPieceBytes, bytes.size());
    image.data.assign(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                      bytes.begin() + static_cast<std::ptrdiff_t>(end));
    image.size = static_cast<std::int32_t>(image.data.size());
    pieces->push_back(image);
    image.values.clear();
    image.num_values = 0;
  }
}

rec_image_t Describe(const RgbdFrame& frame, const cv::Mat& pixels, std::int8_t which) {
  rec_image_t image{};
  image.sequence = static_cast<std::int64_t>(frame.sequence);
  image.image = which;
  image.width = pixels.cols;
  image.height = pixels.rows;
  return image;
}

cv::Mat DecodePng(const Bytes& bytes, int type, const rec_image_t& image) {
  const cv::Mat pixels = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  if (pixels.type() != type || pixels.size() != cv::Size(image.width, image.height)) {
    Throw<ProtocolError>("it holds {} x {} pixels of type {}, not {} x {} of type {}", pixels.cols,
                         pixels.rows, pixels.type(), image.width, image.height, type);
  }
  return pixels;
}

cv::Mat DecodeColor(const Bytes& bytes, const rec_image_t& image) {
  if (image.encoding != rec_image_t::PNG) {
    Throw<ProtocolError>("encoding {} is none of colour's", image.encoding);
  }
  cv::Mat color;
  cv::cvtColor(DecodePng(bytes, CV_8UC3, image), color, cv::COLOR_BGR2RGB);
  return color;
}

cv::Mat DecodeDepth(const Bytes& bytes, const rec_image_t& image) {
  cv::Mat depth(image.height, image.width, CV_32FC1);
  if (image.encoding == rec_image_t::ZLIB_FLOAT) {
    const Bytes floats = Inflate(bytes, depth.total() * depth.elemSize());
    std::copy(floats.begin(), floats.end(), depth.data);
    return depth;
  }
  if (image.encoding != rec_image_t::PNG_INDEX) {
    Throw<ProtocolError>("encoding {} is none of depth's", image.encoding);
  }
  const cv::Mat indices = DecodePng(bytes, CV_16UC1, image);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const std::size_t i = indices.at<std::uint16_t>(v, u);
      if (i >= image.values.size()) {
        Throw<ProtocolError>("value {} at pixel ({}, {}), of {}", i, u, v, image.values.size());
      }
      depth.at<float>(v, u) = image.values[i];
    }
  }
  return depth;
}

/// The data of all pieces, which must be those of one image and all there.
Bytes Join(const std::vector<rec_image_t>& pieces) {
  const rec_image_t& first = pieces.front();
  if (first.width < 1 || first.height < 1 || first.width > kMaxSide || first.height > kMaxSide) {
    Throw<ProtocolError>("it would have {} x {} pixels", first.width, first.height);
  }
  if (first.pieces != static_cast<std::int32_t>(pieces.size())) {
    Throw<ProtocolError>("{} of its {} pieces are there", pieces.size(), first.pieces);
  }
  Bytes bytes;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const rec_image_t& piece = pieces[i];
    if (piece.piece != static_cast<std::int32_t>(i) || piece.sequence != first.sequence ||
        piece.image != first.image) {
      Throw<ProtocolError>("its piece {} is missing", i);
    }
    bytes.insert(bytes.end(), piece.data.begin(), piece.data.end());
  }
  return bytes;
}

}  // namespace

std::vector<rec_image_t> EncodeImages(const RgbdFrame& frame) {
  std::vector<rec_image_t> pieces;
  cv::Mat bgr;
  cv::cvtColor(frame.color, bgr, cv::COLOR_RGB2BGR);
  rec_image_t color = Describe(frame, frame.color, rec_image_t::COLOR);
  color.encoding = rec_image_t::PNG;
  AddPieces(std::move(color), ToPng(bgr), &pieces);
  if (frame.depth.empty()) return pieces;
  rec_image_t depth = Describe(frame, frame.depth, rec_image_t::DEPTH);
  const Bytes bytes = EncodeDepth(frame.depth, &depth);
  AddPieces(std::move(depth), bytes, &pieces);
  return pieces;
}

void DecodeImage(const std::vector<rec_image_t>& pieces, RgbdFrame* frame) {
  if (pieces.empty()) return;
  const rec_image_t& first = pieces.front();
  const bool is_color = first.image == rec_image_t::COLOR;
  try {
    const Bytes bytes = Join(pieces);
    (is_color ? frame->color : frame->depth) =
        is_color ? DecodeColor(bytes, first) : DecodeDepth(bytes, first);
  } catch (const std::exception& error) {  // cv::Exception is no Error of ours
    Throw<ProtocolError>("the {} of recorded frame {} is damaged: {}",
                         is_color ? "colour" : "depth", frame->sequence, error.what());
  }
}

}  // namespace secondlook::hal

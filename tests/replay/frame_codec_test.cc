#include "lib/hal/replay/frame_codec.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "lib/common/error.h"
#include "lib/transport/channels.h"
#include "lib/transport/message.h"
#include "tests/support/expect_throws.h"

namespace secondlook::hal {
namespace {

using second_look::rec_image_t;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Colour noise, which nothing compresses, and the depth that `z` makes of a random number.
template <class Depth>
RgbdFrame NoisyFrame(int width, int height, Depth z) {
  RgbdFrame frame;
  frame.sequence = 7;
  frame.color.create(height, width, CV_8UC3);
  frame.depth.create(height, width, CV_32FC1);
  std::mt19937 random(5);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      for (int c = 0; c < 3; ++c) {
        frame.color.at<cv::Vec3b>(v, u)[c] = static_cast<std::uint8_t>(random());
      }
      frame.depth.at<float>(v, u) = z(random());
    }
  }
  return frame;
}

RgbdFrame Decoded(const std::vector<rec_image_t>& pieces) {
  std::vector<rec_image_t> color;
  std::vector<rec_image_t> depth;
  for (const rec_image_t& piece : pieces) {
    (piece.image == rec_image_t::COLOR ? color : depth).push_back(piece);
  }
  RgbdFrame frame;
  frame.sequence = 7;
  DecodeImage(color, &frame);
  DecodeImage(depth, &frame);
  return frame;
}

bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

std::int8_t DepthEncoding(const std::vector<rec_image_t>& pieces) {
  EXPECT_EQ(pieces.back().image, rec_image_t::DEPTH);
  return pieces.back().encoding;
}

TEST(FrameCodec, KeepsDepthInStepsBitForBit) {
  // As a stereo camera measures: disparities are multiples of 1/8 px.
  const RgbdFrame frame = NoisyFrame(320, 240, [](unsigned random) {
    const unsigned eighths = random % 400;
    return eighths < 40 ? kNone : 577.0F * 0.075F / (static_cast<float>(eighths) * 0.125F);
  });
  const auto pieces = EncodeImages(frame);
  EXPECT_EQ(DepthEncoding(pieces), rec_image_t::PNG_INDEX);
  const RgbdFrame decoded = Decoded(pieces);
  EXPECT_TRUE(SameBytes(frame.color, decoded.color));
  EXPECT_TRUE(SameBytes(frame.depth, decoded.depth));
}

TEST(FrameCodec, KeepsDepthOfAnyValuesBitForBit) {
  const RgbdFrame frame = NoisyFrame(320, 240, [](unsigned random) {
    return random % 10 == 0 ? kNone : static_cast<float>(random) * 1e-9F;
  });
  const auto pieces = EncodeImages(frame);
  EXPECT_EQ(DepthEncoding(pieces), rec_image_t::ZLIB_FLOAT);
  EXPECT_TRUE(SameBytes(frame.depth, Decoded(pieces).depth));
}

TEST(FrameCodec, KeepsOddValuesOfDepth) {
  const float values[] = {0.0F,
                          -0.0F,
                          -1.0F,
                          kNone,
                          std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::denorm_min()};
  const RgbdFrame frame =
      NoisyFrame(16, 16, [&](unsigned random) { return values[random % std::size(values)]; });
  EXPECT_TRUE(SameBytes(frame.depth, Decoded(EncodeImages(frame)).depth));
}

TEST(FrameCodec, KeepsAFrameWithoutDepth) {
  RgbdFrame frame = NoisyFrame(32, 16, [](unsigned) { return 1.0F; });
  frame.depth.release();
  const RgbdFrame decoded = Decoded(EncodeImages(frame));
  EXPECT_TRUE(SameBytes(frame.color, decoded.color));
  EXPECT_TRUE(decoded.depth.empty());
}

TEST(FrameCodec, MakesPiecesThatFitOnTheBus) {
  // As many values as the table takes at most.
  const RgbdFrame frame = NoisyFrame(640, 480, [](unsigned random) {
    return 0.5F + 0.001F * static_cast<float>(random % 16'382);
  });
  const auto pieces = EncodeImages(frame);
  EXPECT_EQ(DepthEncoding(pieces), rec_image_t::PNG_INDEX);
  for (const rec_image_t& piece : pieces) {
    EXPECT_LE(transport::Encode(piece).size(), transport::kMaxMessageBytes);
  }
}

TEST(FrameCodec, ColourIsAPngThatOthersRead) {
  RgbdFrame frame = NoisyFrame(4, 4, [](unsigned) { return 1.0F; });
  frame.color.setTo(cv::Scalar(200, 100, 50));  // red, green, blue
  const auto pieces = EncodeImages(frame);
  const cv::Mat bgr = cv::imdecode(pieces.front().data, cv::IMREAD_COLOR);
  EXPECT_EQ(bgr.at<cv::Vec3b>(0, 0), cv::Vec3b(50, 100, 200));
}

TEST(FrameCodec, RefusesWhatIsNotWhole) {
  const RgbdFrame frame = NoisyFrame(
      320, 240, [](unsigned random) { return 0.5F + 0.01F * static_cast<float>(random % 100); });
  std::vector<rec_image_t> color;
  for (const rec_image_t& piece : EncodeImages(frame)) {
    if (piece.image == rec_image_t::COLOR) color.push_back(piece);
  }
  ASSERT_GE(color.size(), 3U);
  RgbdFrame decoded;
  decoded.sequence = 7;

  std::vector<rec_image_t> pieces = color;
  pieces.erase(pieces.begin() + 1);
  EXPECT_THROWS(DecodeImage(pieces, &decoded), ProtocolError,
                "the colour of recorded frame 7 is damaged");
  pieces = color;
  pieces[1].data[1000] ^= 0x40;
  EXPECT_THROWS(DecodeImage(pieces, &decoded), ProtocolError, "is damaged");
  pieces = color;
  pieces[0].width = 2'000'000'000;
  EXPECT_THROWS(DecodeImage(pieces, &decoded), ProtocolError, "it would have 2000000000 x 240");
  pieces = color;
  pieces[0].encoding = 9;
  EXPECT_THROWS(DecodeImage(pieces, &decoded), ProtocolError, "encoding 9");
}

TEST(FrameCodec, RefusesAnIndexBeyondTheTable) {
  const RgbdFrame frame =
      NoisyFrame(16, 16, [](unsigned random) { return 0.5F + static_cast<float>(random % 10); });
  std::vector<rec_image_t> depth{EncodeImages(frame).back()};
  depth[0].values.resize(3);
  RgbdFrame decoded;
  EXPECT_THROWS(DecodeImage(depth, &decoded), ProtocolError, "of 3");
}

}  // namespace
}  // namespace secondlook::hal

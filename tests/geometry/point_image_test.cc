#include "lib/geometry/point_image.h"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "lib/common/files.h"
#include "lib/geometry/pcd.h"

namespace secondlook::geometry {
namespace {

/// The depth image [mm, CV_16UC1] of a PCLZF file: a header of 37 bytes ("PCLZF", width, height, 16
/// letters of type, packed and unpacked size), then an LZF block.
cv::Mat ReadPclzf(const std::filesystem::path& file) {
  const std::string content = ReadFile(file);
  const auto number = [&](std::size_t at) {
    std::int32_t value = 0;
    std::memcpy(&value, content.data() + at, 4);
    return value;
  };
  std::string out;
  for (std::size_t i = 37; i < content.size();) {
    const auto next = [&] {
      return static_cast<std::size_t>(static_cast<std::uint8_t>(content.at(i++)));
    };
    const std::size_t control = next();
    if (control < 32) {
      out += content.substr(i, control + 1);
      i += control + 1;
      continue;
    }
    const std::size_t length = 2 + ((control >> 5) == 7 ? 7 + next() : control >> 5);
    const std::size_t distance = ((control & 31) << 8) + next() + 1;
    for (std::size_t k = 0; k < length; ++k) out += out.at(out.size() - distance);
  }
  cv::Mat image(number(9), number(5), CV_16UC1);
  EXPECT_EQ(out.size(), image.total() * 2);
  std::memcpy(image.data, out.data(), std::min(out.size(), image.total() * 2));
  return image;
}

TEST(Deproject, ReproducesTheCloudsOfARecordedCameraWithinAMillimetre) {
  const char* data = std::getenv("SECONDLOOK_DATA");
  if (data == nullptr) GTEST_SKIP() << "SECONDLOOK_DATA is not set";
  const CameraModel camera{640, 480, 525.0, 525.0, 320.0, 240.0};
  int frames = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(data) / "xtion")) {
    if (entry.path().extension() != ".pcd") continue;
    std::filesystem::path raw = entry.path();
    raw.replace_extension();
    raw += "_depth.pclzf";
    cv::Mat depth;
    ReadPclzf(raw).convertTo(depth, CV_32FC1, 0.001);
    depth.setTo(std::numeric_limits<float>::quiet_NaN(), depth == 0.0F);
    const PointImage ours = Deproject(depth, camera);
    const PointImage reference = ReadPcd(entry.path());
    ASSERT_EQ(ours.points_C.size(), reference.points_C.size());
    float worst = 0.0F;
    for (std::size_t i = 0; i < ours.points_C.size(); ++i) {
      ASSERT_EQ(IsMeasured(ours.points_C[i]), IsMeasured(reference.points_C[i])) << "point " << i;
      if (!IsMeasured(ours.points_C[i])) continue;
      worst = std::max(worst, (ours.points_C[i] - reference.points_C[i]).norm());
    }
    EXPECT_LT(worst, 0.001F) << entry.path();
    ++frames;
  }
  EXPECT_EQ(frames, 3);
}

}  // namespace
}  // namespace secondlook::geometry

#include "lib/perception/nearest_pixel.h"

#include <vector>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::perception {
namespace {

TEST(NearestPixel, IsTheOneThatTryingAllOfThemFinds) {
  constexpr int kWidth = 31;
  constexpr int kHeight = 23;
  constexpr int kReach = 8;
  Rng rng(4);
  for (const double share : {0.0, 0.002, 0.02, 0.3, 1.0}) {
    std::vector<char> mask(kWidth * kHeight);
    for (char& pixel : mask) pixel = rng.Uniform(0.0, 1.0) < share ? 1 : 0;
    const NearestPixel nearest(mask, kWidth, kHeight, kReach);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        int least = kReach * kReach;
        for (int v = 0; v < kHeight; ++v) {
          for (int u = 0; u < kWidth; ++u) {
            if (mask[v * kWidth + u] == 0) continue;
            least = std::min(least, (u - x) * (u - x) + (v - y) * (v - y));
          }
        }
        const auto found = nearest.To(x, y);
        ASSERT_EQ(found.has_value(), least < kReach * kReach) << x << " " << y << " " << share;
        if (!found) continue;
        EXPECT_EQ(mask[found->y * kWidth + found->x], 1);
        EXPECT_EQ((found->x - x) * (found->x - x) + (found->y - y) * (found->y - y), least);
      }
    }
  }
}

TEST(NearestPixel, TakesTheTopmostAndThenTheLeftOfTheEquallyNear) {
  const std::vector<char> mask{0, 1, 0,  //
                               1, 0, 1,  //
                               0, 1, 0};
  EXPECT_EQ(*NearestPixel(mask, 3, 3, 4).To(1, 1), cv::Point(1, 0));
  const std::vector<char> sides{1, 0, 1};
  EXPECT_EQ(*NearestPixel(sides, 3, 1, 4).To(1, 0), cv::Point(0, 0));
}

}  // namespace
}  // namespace secondlook::perception

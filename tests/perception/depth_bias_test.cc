#include "lib/perception/depth_bias.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

namespace secondlook::perception {
namespace {

constexpr geometry::PixelRect kWindow{10, 20, 200, 160};
constexpr double kPixel = 0.001;  // [m]: the object is 0.2 m wide

/// A window of differences, by place on the object [m] from its middle.
std::vector<float> Draw(const std::function<double(double, double)>& difference) {
  std::vector<float> drawn;
  for (int y = 0; y < kWindow.height; ++y) {
    for (int x = 0; x < kWindow.width; ++x) {
      drawn.push_back(static_cast<float>(difference(kPixel * (x - 100), kPixel * (y - 80))));
    }
  }
  return drawn;
}

DepthBias Fit(const std::vector<float>& difference) {
  return DepthBias(difference, std::vector<char>(difference.size(), 1), kWindow, kPixel, 0.02);
}

TEST(DepthBias, FollowsASmoothBend) {
  const DepthBias bias = Fit(Draw([](double u, double) { return 0.5 * u * u; }));
  // 0.5 /m bend by 5 mm over 0.1 m; what is forgiven is most of it.
  EXPECT_NEAR(bias.At(0, 80) - bias.At(100, 80), 0.005, 0.0015);
  EXPECT_NEAR(bias.At(100, 0), bias.At(100, 159), 1e-3);
}

TEST(DepthBias, ForgivesAPoseNeitherOffsetNorTilt) {
  const DepthBias bias = Fit(Draw([](double u, double v) { return 0.006 + 0.05 * u - 0.03 * v; }));
  for (const int x : {0, 100, 199}) EXPECT_NEAR(bias.At(x, 40), 0.0, 5e-4) << x;
}

TEST(DepthBias, LeavesAStepInTheShapeAlone) {
  const DepthBias bias = Fit(Draw([](double u, double) { return u > 0.06 ? 0.01 : 0.0; }));
  EXPECT_LT(bias.At(190, 80), 0.006);
}

TEST(DepthBias, HoldsASmallThingToItsShape) {
  // A bend of 5 mm over a centimetre is another shape, not a bias.
  std::vector<float> difference = Draw(
      [](double u, double v) { return std::hypot(u, v) < 0.01 ? 50.0 * u * u : std::nan(""); });
  EXPECT_NEAR(Fit(difference).At(109, 80), 0.0, 5e-4);
}

TEST(DepthBias, OfNothingIsZero) {
  EXPECT_EQ(Fit(Draw([](double, double) { return std::nan(""); })).At(5, 5), 0.0);
}

}  // namespace
}  // namespace secondlook::perception

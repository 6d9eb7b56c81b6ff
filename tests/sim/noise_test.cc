#include "sim/noise.h"

#include <cmath>
#include <cstring>
#include <set>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/yaml_reader.h"
#include "tests/support/expect_throws.h"

namespace secondlook::sim {
namespace {

constexpr geometry::CameraModel kModel{320, 240, 577.3, 577.3, 159.5, 119.5};
constexpr DepthRange kRange;

/// A surface that fills the picture at `z` [m], hit at `incidence` [rad], light and dull.
Render Surface(double z, double incidence) {
  const cv::Size size(kModel.width, kModel.height);
  Render render;
  render.color = cv::Mat(size, CV_8UC3, cv::Scalar(120, 130, 140));
  render.depth = cv::Mat(size, CV_32FC1, cv::Scalar(z));
  render.cos_incidence = cv::Mat(size, CV_32FC1, cv::Scalar(std::cos(incidence)));
  render.luminance = cv::Mat(size, CV_32FC1, cv::Scalar(0.5));
  render.specular = cv::Mat(size, CV_32FC1, cv::Scalar(0.0));
  render.id = cv::Mat(size, CV_16UC1, cv::Scalar(1));
  return render;
}

struct Statistics {
  int count{};
  double mean{};
  double sigma{};
};

Statistics Measure(const cv::Mat& depth) {
  Statistics s;
  double sum = 0.0;
  double squares = 0.0;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const double z = depth.at<float>(v, u);
      if (std::isnan(z)) continue;
      ++s.count;
      sum += z;
      squares += z * z;
    }
  }
  s.mean = sum / s.count;
  s.sigma = std::sqrt(squares / s.count - s.mean * s.mean);
  return s;
}

NoiseConfig WithoutQuantisation() {
  NoiseConfig config;
  config.disparity_step_px = 0.0;
  return config;
}

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

TEST(DepthNoise, AxialSigmaIsThatOfNguyenAtEachDistance) {
  // By hand: 1.2 mm + 1.9 mm/m^2 (z - 0.4 m)^2.
  for (const auto& [z, sigma] : {std::pair{0.6, 0.001276},
                                 {1.0, 0.001884},
                                 {1.5, 0.003499},
                                 {2.0, 0.006064},
                                 {3.0, 0.014044}}) {
    EXPECT_NEAR(AxialSigma(z, 0.3), sigma, 1e-9);
    Rng rng(7);
    const Statistics s =
        Measure(DepthNoise(Surface(z, 0.3), kModel, kRange, WithoutQuantisation(), &rng));
    EXPECT_EQ(s.count, kModel.width * kModel.height);
    EXPECT_NEAR(s.sigma, sigma, 0.1 * sigma);
    EXPECT_NEAR(s.mean, z, 0.02 * sigma);
  }
}

TEST(DepthNoise, AxialSigmaGrowsBeyond60DegreesOfIncidence) {
  // At 75 degrees, 1 m: angle / (pi/2 - angle) = 75 / 15 = 5, so 0.1 mm * 25 = 2.5 mm more.
  const double steep = 75.0 / 180.0 * M_PI;
  EXPECT_NEAR(AxialSigma(1.0, steep), 0.001884 + 0.0025, 1e-9);
  Rng rng(7);
  const Statistics s =
      Measure(DepthNoise(Surface(1.0, steep), kModel, kRange, WithoutQuantisation(), &rng));
  EXPECT_NEAR(s.sigma, 0.004384, 0.0004384);
}

TEST(DepthNoise, DepthsAreQuantisedDisparities) {
  // f b / step = 577.3 * 0.075 * 8 = 346.38: near 1 m neighbouring values differ by 1 / 346.38.
  Rng rng(1);
  const cv::Mat depth = DepthNoise(Surface(1.0, 0.0), kModel, kRange, NoiseConfig{}, &rng);
  std::set<float> values;
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const float z = depth.at<float>(v, u);
      EXPECT_NEAR(346.38 / z, std::round(346.38 / z), 1e-3);
      values.insert(z);
    }
  }
  EXPECT_LT(values.size(), 12U);
  const auto near = values.lower_bound(1.0F);
  EXPECT_NEAR(*std::next(near) - *near, 1.0 / 346.38, 1e-4);
}

TEST(DepthNoise, AnOutlineJittersByTheLateralSigmaAndNeverMixesDepths) {
  // A step from 1 m to 2 m at column 160. Without edge loss, the column where each row changes
  // over is where u + shift(u) rounds past the edge: its spread is that of the shift.
  Render render = Surface(2.0, 0.0);
  render.depth.colRange(0, 160).setTo(1.0F);
  NoiseConfig config = NoiseConfig::None();
  config.depth_lateral_sigma_px = 0.8;
  double squares = 0.0;
  int rows = 0;
  for (int seed = 0; seed < 40; ++seed) {
    Rng rng(seed);
    const cv::Mat depth = DepthNoise(render, kModel, kRange, config, &rng);
    for (int v = 0; v < depth.rows; ++v) {
      int near = 0;
      for (int u = 0; u < depth.cols; ++u) {
        const float z = depth.at<float>(v, u);
        ASSERT_TRUE(z == 1.0F || z == 2.0F);
        near += z == 1.0F ? 1 : 0;
      }
      squares += (near - 160.0) * (near - 160.0);
      ++rows;
    }
  }
  // Rounding to whole pixels adds 1/12 px^2.
  EXPECT_NEAR(std::sqrt(squares / rows - 1.0 / 12.0), 0.8, 0.08);
}

TEST(DepthNoise, NothingReturnsBesideAStepInDepth) {
  Render render = Surface(2.0, 0.0);
  render.depth.colRange(0, 160).setTo(1.0F);
  NoiseConfig config = NoiseConfig::None();
  config.edge_jump = 0.02;
  Rng rng(1);
  const cv::Mat depth = DepthNoise(render, kModel, kRange, config, &rng);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      EXPECT_EQ(std::isnan(depth.at<float>(v, u)), u == 159 || u == 160);
    }
  }
}

TEST(DepthNoise, NothingReturnsBeyond80DegreesNearerThanTheRangeOrFromNothing) {
  NoiseConfig config = NoiseConfig::None();
  config.max_incidence_deg = 80.0;
  const auto returns = [&](const Render& render) {
    Rng rng(1);
    return Measure(DepthNoise(render, kModel, kRange, config, &rng)).count;
  };
  const int all = kModel.width * kModel.height;
  EXPECT_EQ(returns(Surface(1.0, 79.0 / 180.0 * M_PI)), all);
  EXPECT_EQ(returns(Surface(1.0, 81.0 / 180.0 * M_PI)), 0);
  EXPECT_EQ(returns(Surface(0.51, 0.0)), all);
  EXPECT_EQ(returns(Surface(0.49, 0.0)), 0);
  EXPECT_EQ(returns(Surface(6.01, 0.0)), 0);
  EXPECT_EQ(returns(Surface(std::nan(""), 0.0)), 0);
}

TEST(DepthNoise, DarkAndShinyMaterialLosesReturnsMoreTheMoreItIsBoth) {
  const auto lost = [&](double luminance, double specular, double incidence) {
    Render render = Surface(1.0, incidence);
    render.luminance.setTo(luminance);
    render.specular.setTo(specular);
    Rng rng(5);
    const int count = Measure(DepthNoise(render, kModel, kRange, NoiseConfig{}, &rng)).count;
    return 1.0 - count / static_cast<double>(kModel.width * kModel.height);
  };
  EXPECT_EQ(lost(0.5, 0.8, 0.6), 0.0);  // light and shiny
  EXPECT_EQ(lost(0.0, 0.0, 0.6), 0.0);  // black and dull
  EXPECT_NEAR(lost(0.0, 0.5, 0.9), 0.95, 0.01);
  EXPECT_NEAR(lost(0.0, 0.25, 0.9), 0.475, 0.01);   // half as shiny
  EXPECT_NEAR(lost(0.075, 0.5, 0.9), 0.475, 0.01);  // half as dark
  EXPECT_NEAR(lost(0.0, 0.5, 0.0), 0.475, 0.01);    // facing the camera
}

TEST(DepthNoise, WithoutErrorsTheDepthIsTheCleanOne) {
  Rng rng(1);
  const Render render = Surface(1.2345, 0.4);
  EXPECT_TRUE(Same(DepthNoise(render, kModel, kRange, NoiseConfig::None(), &rng), render.depth));
}

TEST(DepthNoise, TheSameSeedGivesTheSameBytesAndAnotherDoesNot) {
  const Render render = Surface(1.0, 0.2);
  Rng a(1);
  Rng b(1);
  Rng c(2);
  const cv::Mat depth = DepthNoise(render, kModel, kRange, NoiseConfig{}, &a);
  EXPECT_TRUE(Same(depth, DepthNoise(render, kModel, kRange, NoiseConfig{}, &b)));
  EXPECT_FALSE(Same(depth, DepthNoise(render, kModel, kRange, NoiseConfig{}, &c)));
}

TEST(ColorNoise, SensorNoiseHasItsSigma) {
  NoiseConfig config = NoiseConfig::None();
  config.color_sigma = 4.0;
  Rng rng(3);
  const cv::Mat color = ColorNoise(Surface(1.0, 0.0), config, &rng);
  double sum = 0.0;
  double squares = 0.0;
  for (int v = 0; v < color.rows; ++v) {
    for (int u = 0; u < color.cols; ++u) {
      const double value = color.at<cv::Vec3b>(v, u)[1] - 130.0;
      sum += value;
      squares += value * value;
    }
  }
  const double count = static_cast<double>(color.total());
  EXPECT_NEAR(sum / count, 0.0, 0.1);
  EXPECT_NEAR(std::sqrt(squares / count), 4.0, 0.4);
}

TEST(ColorNoise, GainsAreDrawnPerFrameAndValuesAreClippedNotWrapped) {
  NoiseConfig config = NoiseConfig::None();
  config.exposure_sigma = 0.06;
  config.white_balance_sigma = 0.02;
  double squares = 0.0;
  for (int seed = 0; seed < 400; ++seed) {
    Rng rng(seed);
    const cv::Vec3b value = ColorNoise(Surface(1.0, 0.0), config, &rng).at<cv::Vec3b>(9, 9);
    squares += std::pow(std::log(value[1] / 130.0), 2);
  }
  EXPECT_NEAR(std::sqrt(squares / 400), 0.06, 0.012);

  config.color_sigma = 30.0;
  Render render = Surface(1.0, 0.0);
  render.color.setTo(cv::Scalar(255, 0, 255));
  Rng rng(1);
  const cv::Mat color = ColorNoise(render, config, &rng);
  for (int v = 0; v < color.rows; ++v) {
    for (int u = 0; u < color.cols; ++u) {
      EXPECT_GT(color.at<cv::Vec3b>(v, u)[0], 60);
      EXPECT_LT(color.at<cv::Vec3b>(v, u)[1], 195);
    }
  }
}

TEST(NoiseConfig, DefaultsAndTheErrorFreeOneAreValid) {
  EXPECT_NO_THROW(NoiseConfig{}.Validate());
  EXPECT_NO_THROW(NoiseConfig::None().Validate());
}

TEST(NoiseConfig, NamesAValueOutOfRangeAndItsPlace) {
  NoiseConfig config;
  EXPECT_THROWS(ApplyLayer({YAML::Load("{max_incidence_deg: 95}"), "robot.yaml"}, &config),
                ConfigError, "robot.yaml:1:1: 'max_incidence_deg' = 95 must be in (0, 90]");
  EXPECT_THROWS(ApplyLayer({YAML::Load("{stamp_sigma: -1}"), "robot.yaml"}, &config), ConfigError,
                "'stamp_sigma' = -1 must be 0 or more");
}

}  // namespace
}  // namespace secondlook::sim

#include "lib/perception/color_match.h"

#include <cmath>

#include <gtest/gtest.h>

#include "lib/common/rng.h"

namespace secondlook::perception {
namespace {

/// Spots of a print of several colours on a curved surface, seen in light of `gain`.
std::vector<ColorPair> Print(std::uint64_t seed, const Eigen::Vector3f& gain, double noise) {
  Rng rng(seed);
  const std::vector<Eigen::Vector3f> inks{
      {0.7F, 0.1F, 0.1F}, {0.9F, 0.85F, 0.8F}, {0.1F, 0.2F, 0.5F}, {0.7F, 0.6F, 0.1F}};
  std::vector<ColorPair> pairs;
  for (int i = 0; i < 400; ++i) {
    ColorPair pair;
    pair.modelled = inks[static_cast<std::size_t>(rng.Index(4))];
    pair.normal_C = Eigen::Vector3d(rng.Uniform(-0.7, 0.7), 0.0, -1.0).normalized().cast<float>();
    const float shade = 0.75F - 0.25F * pair.normal_C.z();
    for (int k = 0; k < 3; ++k) {
      pair.measured[k] =
          gain[k] * shade * pair.modelled[k] + static_cast<float>(rng.Gaussian(noise));
    }
    pairs.push_back(pair);
  }
  return pairs;
}

TEST(CompareColors, TakesExposureShadingAndWhiteBalanceOut) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    const auto exposure = static_cast<float>(rng.Uniform(0.6, 1.1));
    const Eigen::Vector3f gain(exposure * static_cast<float>(rng.Uniform(0.93, 1.07)), exposure,
                               exposure * static_cast<float>(rng.Uniform(0.93, 1.07)));
    EXPECT_GT(CompareColors(Print(seed, gain, 0.015)), 0.85) << "seed " << seed;
  }
}

TEST(CompareColors, TellsRedFromBlueWhateverTheLight) {
  std::vector<ColorPair> pairs = Print(1, {1, 1, 1}, 0.01);
  for (ColorPair& pair : pairs) {
    pair.measured = {0.6F, 0.1F, 0.1F};
    pair.modelled = {0.1F, 0.1F, 0.6F};
  }
  EXPECT_LT(CompareColors(pairs), 0.05);
}

TEST(CompareColors, TellsBlackFromWhite) {
  std::vector<ColorPair> pairs = Print(1, {1, 1, 1}, 0.01);
  for (ColorPair& pair : pairs) {
    pair.measured = {0.03F, 0.03F, 0.03F};
    pair.modelled = {0.9F, 0.9F, 0.9F};
  }
  EXPECT_LT(CompareColors(pairs), 0.1);
}

TEST(CompareColors, TellsAShuffledPrintFromTheRightOne) {
  std::vector<ColorPair> pairs = Print(2, {0.9F, 0.9F, 0.9F}, 0.01);
  const double right = CompareColors(pairs);
  for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) {
    std::swap(pairs[i].modelled, pairs[i + 1].modelled);
  }
  EXPECT_LT(CompareColors(pairs), right - 0.3);
}

TEST(CompareColors, TakesTheSaturationOfTheCameraOut) {
  for (const float saturation : {0.85F, 1.3F}) {
    std::vector<ColorPair> pairs = Print(4, {0.8F, 0.8F, 0.8F}, 0.01);
    const double plain = CompareColors(pairs);
    for (ColorPair& pair : pairs) {
      const float grey = pair.measured.mean();
      pair.measured = (grey + saturation * (pair.measured.array() - grey)).cwiseMax(0.0F).matrix();
    }
    EXPECT_GT(CompareColors(pairs), plain - 0.12) << saturation;
  }
}

TEST(CompareColors, HoldsTheHueOfAClippedHighlightAgainstNoColour) {
  // Two fifths of a yellow thing shine: red and green end at 1, so the share of blue rises.
  std::vector<ColorPair> pairs = Print(5, {1, 1, 1}, 0.01);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const float highlight = i % 5 < 2 ? 0.5F : 0.0F;
    pairs[i].modelled = {0.8F, 0.65F, 0.2F};
    pairs[i].measured = (pairs[i].modelled.array() + highlight).cwiseMin(1.0F).matrix();
  }
  // Only their lightness counts, off by ln(1.05 / 0.73) = 0.36 or 1.2 units: 0.6 + 0.4 exp(-0.72).
  EXPECT_NEAR(CompareColors(pairs), 0.79, 0.04);
}

TEST(CompareColors, StillTellsAnotherColourFromAClippedOne) {
  // White that is clipped in all three is no yellow.
  std::vector<ColorPair> pairs = Print(6, {1, 1, 1}, 0.01);
  for (ColorPair& pair : pairs) {
    pair.modelled = {0.8F, 0.65F, 0.05F};
    pair.measured = {1.0F, 1.0F, 1.0F};
  }
  EXPECT_LT(CompareColors(pairs), 0.3);
}

TEST(CompareColors, OfTooFewPairsSaysNothing) {
  std::vector<ColorPair> pairs = Print(3, {1, 1, 1}, 0.01);
  pairs.resize(19);
  EXPECT_TRUE(std::isnan(CompareColors(pairs)));
  EXPECT_TRUE(std::isnan(CompareColors({})));
}

}  // namespace
}  // namespace secondlook::perception

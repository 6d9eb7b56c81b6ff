#include "lib/planning/tile_vote.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::planning {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// A grey crop of 30 x 30 pixels without depth.
ObjectCrop GreyCrop() {
  return {cv::Mat(30, 30, CV_8UC3, cv::Scalar(128, 128, 128)), cv::Mat(), 525.0};
}

/// A plane at 1 m whose depth grows by `slope_x` metres a metre to the right, on a far background
/// that frames it by two pixels.
cv::Mat PlaneDepth(double slope_x, double focal_length_px = 525.0) {
  cv::Mat depth(30, 30, CV_32FC1, cv::Scalar(2.0));
  for (int v = 2; v < 28; ++v) {
    for (int u = 2; u < 28; ++u) {
      // z = 1 + slope_x X with X = (u - 15) z / f
      depth.at<float>(v, u) =
          static_cast<float>(1.0 / (1.0 - slope_x * (u - 15) / focal_length_px));
    }
  }
  return depth;
}

ScoredTile Scored(Tile tile, double variance, double third_moment, double parallelism,
                  double dissimilarity) {
  ScoredTile scored{tile, {}, 1.0, ""};
  scored.scores = {variance, third_moment, parallelism, 0.0, 0.0, dissimilarity, 0.0, 0.0, 0.0};
  return scored;
}

TEST(TileRect, CoversEveryPixelButThoseOfTheMiddleOnce) {
  for (const cv::Size size : {cv::Size(30, 30), cv::Size(31, 47), cv::Size(3, 3), cv::Size(1, 9)}) {
    cv::Mat count = cv::Mat::zeros(size, CV_8UC1);
    for (int t = 0; t < kTiles; ++t) {
      const cv::Rect rect = TileRect(size, static_cast<Tile>(t));
      if (!rect.empty()) cv::add(count(rect), 1, count(rect));
    }
    EXPECT_EQ(cv::countNonZero(count > 1), 0);
    const int middle =
        (2 * size.width / 3 - size.width / 3) * (2 * size.height / 3 - size.height / 3);
    EXPECT_EQ(cv::countNonZero(count), size.area() - middle);
  }
}

TEST(TileRect, LiesWhereItsNameSays) {
  EXPECT_EQ(TileRect({30, 60}, Tile::kUpperLeft), cv::Rect(0, 0, 10, 20));
  EXPECT_EQ(TileRect({30, 60}, Tile::kRight), cv::Rect(20, 20, 10, 20));
  EXPECT_EQ(TileRect({30, 60}, Tile::kBottom), cv::Rect(10, 40, 10, 20));
}

TEST(ScoreTiles, GivesTheMomentsOfAHistogramWorkedOutByHand) {
  ObjectCrop crop = GreyCrop();
  // A quarter of the upper left tile is white, the rest black: mean 1/4, variance 3/16, third
  // moment (3/4)^3 / 4 - (1/4)^3 * 3/4 = 3/32; entropy 2 - 3/4 log2 3; uniformity 10/16.
  cv::Mat tile = crop.color(TileRect({30, 30}, Tile::kUpperLeft));
  tile.setTo(cv::Scalar(0, 0, 0));
  tile(cv::Rect(0, 0, 5, 5)).setTo(cv::Scalar(255, 255, 255));
  const ScoredTile scored = ScoreTiles(crop, nullptr).front();
  EXPECT_NEAR(scored.Of(Criterion::kVariance), 1.0 - 1.0 / (1.0 + 3.0 / 16.0), 1e-12);
  EXPECT_NEAR(scored.Of(Criterion::kThirdMoment), 1.0 / (1.0 + 3.0 / 32.0), 1e-12);
  EXPECT_NEAR(scored.Of(Criterion::kUniformity), 10.0 / 16.0, 1e-12);
  EXPECT_NEAR(scored.Of(Criterion::kEntropy), 2.0 - 0.75 * std::log2(3.0), 1e-12);
  EXPECT_TRUE(std::isnan(scored.Of(Criterion::kParallelism)));
  EXPECT_TRUE(std::isnan(scored.Of(Criterion::kDissimilarity)));
}

TEST(ScoreTiles, GivesAFrontoParallelSurfaceTheLeastParallelismAndSlantedOnesMore) {
  ObjectCrop crop = GreyCrop();
  crop.depth = PlaneDepth(0.0);
  // The bottom tile's last rows see the edge to the background, as Eq. 7 and 8 have it.
  EXPECT_NEAR(ScoreTiles(crop, nullptr)[0].Of(Criterion::kMetricParallelism), -1.0, 1e-6);
  crop.depth = cv::Mat(30, 30, CV_32FC1, cv::Scalar(1.0));
  crop.depth.at<float>(29, 29) = 2.0F;
  EXPECT_NEAR(ScoreTiles(crop, nullptr)[0].Of(Criterion::kParallelism), -1.0, 1e-6);
  crop.depth = PlaneDepth(1.0);
  const ScoredTile slanted = ScoreTiles(crop, nullptr)[3];
  EXPECT_NEAR(slanted.Of(Criterion::kMetricParallelism), -std::sqrt(0.5), 0.01);
  EXPECT_GT(slanted.Of(Criterion::kParallelism), -1.0);
}

TEST(ScoreTiles, CapsWhatIsTooSteepToBeSeen) {
  ObjectCrop crop = GreyCrop();
  crop.depth = PlaneDepth(20.0);
  TileScoresConfig config;
  config.max_slant_deg = 60.0;
  EXPECT_NEAR(ScoreTiles(crop, nullptr, config)[3].Of(Criterion::kMetricParallelism), -0.5, 1e-9);
}

TEST(ScoreTiles, FindsTheSideThatTheLightComesFrom) {
  // A matt ball of 60 mm at 0.8 m, lit from the upper left.
  ObjectCrop crop{cv::Mat(80, 80, CV_8UC3, cv::Scalar(0, 0, 0)),
                  cv::Mat(80, 80, CV_32FC1, cv::Scalar(1.5)), 525.0};
  const double px_m = 0.8 / crop.focal_length_px;
  for (int v = 0; v < 80; ++v) {
    for (int u = 0; u < 80; ++u) {
      const double x = (u - 40) * px_m;
      const double y = (v - 40) * px_m;
      const double height = 0.055 * 0.055 - x * x - y * y;
      if (height < 0.0) continue;
      crop.depth.at<float>(v, u) = static_cast<float>(0.8 - std::sqrt(height));
      const double light = (-0.5 * x - 0.5 * y + 0.7 * std::sqrt(height)) / 0.055;
      const double level = std::max(0.0, 200.0 * light);
      crop.color.at<cv::Vec3b>(v, u) = cv::Vec3b::all(static_cast<std::uint8_t>(level));
    }
  }
  const TileRanking ranking = RankTiles(ScoreTiles(crop, nullptr), {{Criterion::kLight}});
  EXPECT_EQ(ranking.tiles.front().tile, Tile::kUpperLeft);
}

TEST(ScoreTiles, TakesUnknownDepthForTheBackground) {
  cv::Mat depth(9, 9, CV_32FC1, cv::Scalar(1.0));
  depth.at<float>(8, 8) = 3.0F;
  depth.at<float>(0, 0) = 0.0F;
  depth.at<float>(0, 1) = kNone;
  const cv::Mat foreground = DepthForeground(depth);
  EXPECT_EQ(cv::countNonZero(foreground), 81 - 3);
  EXPECT_EQ(foreground.at<std::uint8_t>(0, 1), 0);
}

TEST(ScoreTiles, RefusesTilesThatShowNothingOfTheObject) {
  ObjectCrop crop = GreyCrop();
  crop.depth = cv::Mat(30, 30, CV_32FC1, cv::Scalar(2.0));
  crop.depth(cv::Rect(0, 0, 20, 30)).setTo(1.0);
  const std::vector<ScoredTile> tiles = ScoreTiles(crop, nullptr);
  EXPECT_EQ(tiles[static_cast<int>(Tile::kLeft)].refusal, "");
  EXPECT_EQ(tiles[static_cast<int>(Tile::kRight)].refusal,
            "shows none of the object: 0 % of its pixels, 5 % needed");
}

TEST(ScoreTiles, GoesByColourAloneWhereAlmostNoDepthIsKnown) {
  ObjectCrop crop = GreyCrop();
  crop.depth = cv::Mat::zeros(30, 30, CV_32FC1);
  crop.depth(cv::Rect(0, 0, 30, 2)).setTo(0.8);  // 93 % invalid
  for (const ScoredTile& tile : ScoreTiles(crop, nullptr)) {
    EXPECT_EQ(tile.refusal, "");
    EXPECT_TRUE(std::isnan(tile.Of(Criterion::kParallelism)));
    EXPECT_FALSE(std::isnan(tile.Of(Criterion::kVariance)));
  }
}

TEST(ScoreTiles, RefusesTheEmptyTilesOfACropOnePixelWide) {
  const ObjectCrop crop{cv::Mat(40, 1, CV_8UC3, cv::Scalar(9, 9, 9)), cv::Mat(), 525.0};
  const std::vector<ScoredTile> tiles = ScoreTiles(crop, nullptr);
  EXPECT_EQ(tiles[0].refusal, "a crop of 1 x 40 pixels has none in this tile");
  EXPECT_EQ(RankTiles(tiles, PaperVoters()).tiles.front().tile, Tile::kUpperRight);
}

TEST(ScoreTiles, ComparesTheClassesOfTilesWithTheObjects) {
  TileClassification classes;
  classes.object = {0.5, 0.5};
  classes.tiles.fill({0.5, 0.5});
  classes.tiles[1] = {1.0, 0.0};
  const std::vector<ScoredTile> tiles = ScoreTiles(GreyCrop(), &classes);
  EXPECT_NEAR(tiles[0].Of(Criterion::kDissimilarity), 0.0, 1e-12);
  EXPECT_NEAR(tiles[1].Of(Criterion::kDissimilarity), 1.0, 1e-12);
  EXPECT_NEAR(tiles[1].Of(Criterion::kInformationGain), 1.0, 1e-12);
}

TEST(ScoreTiles, RefusesWhatIsNoCrop) {
  EXPECT_THROWS(ScoreTiles({}, nullptr), InvalidArgument, "a crop of 0 x 0 pixels");
  ObjectCrop crop = GreyCrop();
  crop.depth = cv::Mat(3, 4, CV_32FC1);
  EXPECT_THROWS(ScoreTiles(crop, nullptr), InvalidArgument, "has a depth of 4 x 3");
  TileClassification classes;
  classes.object = {0.5, 0.5};
  classes.tiles[2] = {1.0};
  EXPECT_THROWS(ScoreTiles(GreyCrop(), &classes), InvalidArgument,
                "tile 'upper right' is classified by 1 classes, the object by 2");
  classes.tiles[2] = {std::numeric_limits<double>::quiet_NaN(), 1.0};
  EXPECT_THROWS(ScoreTiles(GreyCrop(), &classes), InvalidArgument,
                "tile 'upper right': class 1 has the probability nan");
  classes.tiles[2].clear();
  classes.object[1] = -0.5;
  EXPECT_THROWS(ScoreTiles(GreyCrop(), &classes), InvalidArgument,
                "the object: class 2 has the probability -0.5");
  TileScoresConfig config;
  config.max_slant_deg = 120.0;
  EXPECT_THROWS(ScoreTiles(GreyCrop(), nullptr, config), ConfigError, "max_slant_deg = 120");
}

TEST(RankTiles, GivesEachCriterionOneVote) {
  const TileRanking ranking = RankTiles(
      {Scored(Tile::kUpperLeft, 0.9, 0.1, -0.9, 0.1), Scored(Tile::kTop, 0.8, 0.9, -0.2, 0.2),
       Scored(Tile::kRight, 0.1, 0.2, -0.3, 1.9)},
      PaperVoters());
  ASSERT_EQ(ranking.tiles.size(), 3U);
  EXPECT_EQ(ranking.tiles[0].tile, Tile::kTop);
  EXPECT_EQ(ranking.tiles[0].votes, 2.0);
}

TEST(RankTiles, BreaksTiesByBordaPointsThenByOrder) {
  // Each wins one criterion; the second is never last.
  const std::vector<Voter> voters{{Criterion::kVariance}, {Criterion::kThirdMoment}};
  const TileRanking ranking =
      RankTiles({Scored(Tile::kUpperLeft, 0.9, 0.1, 0.0, 0.0),
                 Scored(Tile::kTop, 0.5, 0.9, 0.0, 0.0), Scored(Tile::kRight, 0.1, 0.5, 0.0, 0.0)},
                voters);
  EXPECT_EQ(ranking.tiles[0].tile, Tile::kTop);
  const TileRanking alike = RankTiles(
      {Scored(Tile::kTop, 0.5, 0.5, 0.0, 0.0), Scored(Tile::kRight, 0.5, 0.5, 0.0, 0.0)}, voters);
  EXPECT_EQ(alike.tiles[0].tile, Tile::kTop);
}

TEST(RankTiles, CountsPointsByBordaAndWeights) {
  const std::vector<ScoredTile> tiles{Scored(Tile::kUpperLeft, 0.9, 0.1, 0.0, 0.0),
                                      Scored(Tile::kTop, 0.5, 0.9, 0.0, 0.0)};
  const std::vector<Voter> voters{{Criterion::kVariance, 3.0}, {Criterion::kThirdMoment, 1.0}};
  EXPECT_EQ(RankTiles(tiles, voters, VoteRule::kBorda).tiles[0].tile, Tile::kUpperLeft);
  EXPECT_EQ(RankTiles(tiles, voters, VoteRule::kBorda).tiles[0].votes, 3.0);
  EXPECT_EQ(RankTiles(tiles, voters).tiles[1].votes, 1.0);
}

TEST(RankTiles, LeavesOutCriteriaThatSayNothing) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const TileRanking ranking = RankTiles(
      {Scored(Tile::kUpperLeft, 0.1, 0.5, none, none), Scored(Tile::kTop, 0.9, 0.5, none, none)},
      PaperVoters());
  EXPECT_EQ(ranking.tiles[0].tile, Tile::kTop);
  EXPECT_EQ(ranking.tiles[0].votes + ranking.tiles[1].votes, 2.0);
}

TEST(RankTiles, GoesOnToTheNextTileWhereTheWinnerCannotBeReached) {
  const TileRanking ranking = RankTiles(
      {Scored(Tile::kBottom, 0.9, 0.9, 0.0, 0.0), Scored(Tile::kLowerRight, 0.5, 0.5, 0.0, 0.0)},
      PaperVoters());
  EXPECT_EQ(ranking.Best([](Tile) { return true; }), Tile::kBottom);
  EXPECT_EQ(ranking.Best([](Tile tile) { return tile != Tile::kBottom; }), Tile::kLowerRight);
  EXPECT_FALSE(ranking.Best([](Tile) { return false; }));
}

TEST(RankTiles, SaysWhyNoTileIsLeft) {
  ScoredTile refused = Scored(Tile::kTop, 0.9, 0.9, 0.0, 0.0);
  refused.refusal = "shows none of the object";
  const TileRanking ranking = RankTiles({refused}, PaperVoters());
  EXPECT_TRUE(ranking.tiles.empty());
  EXPECT_EQ(ranking.reason, "all 1 tiles are refused; 'top' shows none of the object");
  EXPECT_THROWS(RankTiles({}, {}), InvalidArgument, "no criterion votes");
}

}  // namespace
}  // namespace secondlook::planning

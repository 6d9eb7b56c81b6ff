#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace secondlook::planning {

/// The tiles around the middle one of a 3x3 tiling of an object's bounding box, row by row. Each
/// stands for the views from that side, at the object's depth (Hoseini 2021, 4.1).
enum class Tile { kUpperLeft, kTop, kUpperRight, kLeft, kRight, kLowerLeft, kBottom, kLowerRight };
inline constexpr int kTiles = 8;

/// "upper left", …
const char* TileName(Tile tile);

/// The pixels of `tile` in an image of `size`. The nine tiles are disjoint and cover the image; one
/// of an image less than 3 pixels wide or high may be empty.
cv::Rect TileRect(cv::Size size, Tile tile);

/// Where the views of `tile` look from, seen from the middle of the image (x right, y down), of
/// length 1.
Eigen::Vector2d TileDirection(Tile tile);

/// What speaks for looking from the side of a tile; more is better for each.
enum class Criterion {
  kVariance,           ///< V, Eq. 3: contrast.
  kThirdMoment,        ///< L, Eq. 5: neither dark nor bright.
  kParallelism,        ///< P, Eq. 6: slanted surface; depth derivatives in metres a pixel.
  kLight,              ///< Shading says that a view from there sees well-lit surface.
  kMetricParallelism,  ///< The same with normals in space, capped where it is too steep to see.
  kDissimilarity,      ///< S, Eq. 9: the tile is classified otherwise than the object.
  kUniformity,         ///< Eq. 10; this and what follows are the paper's baselines.
  kEntropy,            ///< Eq. 11.
  kInformationGain,    ///< Eq. 12.
};
inline constexpr int kCriteria = 9;

/// One view of an object, cut to its bounding box.
struct ObjectCrop {
  cv::Mat color;  ///< [height, width] CV_8UC3, RGB.
  cv::Mat depth;  ///< [height, width] CV_32FC1, z_C [m]; NaN or 0 = none. Or empty: no depth.
  double focal_length_px{525.0};  ///< Of the camera.
};

/// Class probabilities of the object and of its tiles by Tile, from whatever classified them.
struct TileClassification {
  std::vector<double> object;
  std::array<std::vector<double>, kTiles> tiles;
};

struct TileScoresConfig {
  double min_foreground{0.05};  ///< A tile with a smaller share of the object is refused.
  double min_known_depth{0.1};  ///< Of the crop; with less, depth says nothing.
  double max_slant_deg{75.0};   ///< A surface steeper than this counts as if it were this steep.

  template <class A>
  void Serialize(A* a) {
    a->Visit("min_foreground", &min_foreground);
    a->Visit("min_known_depth", &min_known_depth);
    a->Visit("max_slant_deg", &max_slant_deg);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

struct ScoredTile {
  Tile tile{};
  std::array<double, kCriteria> scores{};  ///< By Criterion; NaN: it says nothing of this tile.
  double foreground{
      std::numeric_limits<double>::quiet_NaN()};  ///< Share of the object; NaN: unknown.
  std::string refusal;                            ///< Why this side is no candidate; "": it is one.

  double Of(Criterion criterion) const { return scores[static_cast<std::size_t>(criterion)]; }
};

/// The foreground of a depth map [m]: pixels nearer than Otsu's threshold, unknown ones taken for
/// the farthest (Hoseini 2021, 4.4). [height, width] CV_8UC1, 255 or 0; all 0 where all depth is
/// alike.
cv::Mat DepthForeground(const cv::Mat& depth);

/// All tiles of a crop, in the order of Tile. Intensities are levels in [0, 1], 256 bins. Without
/// depth, or with too little of it, no tile is refused for want of foreground and both kinds of
/// parallelism are NaN; without `classification` what compares classes is NaN. Tiles without pixels
/// are refused.
/// @throws InvalidArgument for a crop without pixels, of another type, or whose depth is of another
/// size; for probabilities of another number of classes; ConfigError when `config` is not valid.
std::vector<ScoredTile> ScoreTiles(const ObjectCrop& crop, const TileClassification* classification,
                                   const TileScoresConfig& config = {});

}  // namespace secondlook::planning

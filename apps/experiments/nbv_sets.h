#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "lib/planning/tile_scores.h"

namespace secondlook::apps {

/// The sides that the data set has views from, in the order of its files 1.jpg to 5.jpg.
inline constexpr std::array kSides{planning::Tile::kUpperLeft, planning::Tile::kTop,
                                   planning::Tile::kUpperRight, planning::Tile::kLeft,
                                   planning::Tile::kRight};
inline constexpr std::size_t kSideCount = kSides.size();

/// One initial view in one case.
struct NbvCase {
  int distortion{};
  std::vector<double> front;  ///< Probabilities by class.
  std::array<planning::ScoredTile, kSideCount> sides;
};

/// A test situation of the data set, as a classifier sees it.
struct NbvSet {
  int block{};  ///< Sets of one block share light and background.
  int truth{};  ///< Index of the class.
  std::array<std::vector<double>, kSideCount> sides;
  std::vector<NbvCase> cases;
};

/// What all sets have in common.
struct NbvClassifier {
  std::vector<std::string> classes;  ///< Of every vector of probabilities; "unknown" is the last.
  double reliability{};              ///< By which belief masses of a view are discounted.
};

}  // namespace secondlook::apps

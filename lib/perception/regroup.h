#pragma once

#include <vector>

#include "lib/perception/recognise.h"

namespace secondlook::perception {

/// The things of a view, as recognition cuts and joins what segmentation took for one.
struct Regrouped {
  std::vector<world::Detection> detections;  ///< One for each thing; none is empty.
  std::vector<Choice> choices;               ///< ChooseTogether() of them.
  /// Of each, the given clusters that it comes from, ascending.
  std::vector<std::vector<int>> sources;
};

/// Recognises `clusters` (Recognise(), ChooseTogether()), and where a cluster stays open lets
/// recognition say whether it is several things, or a part of one:
/// - what a chosen thing leaves of its cluster is a thing of its own when that is recognised, too;
/// - a cluster that no model explains as a whole is cut where it may be (CutsByColor(),
///   CutsByShape()), and stays cut when every part is recognised beyond doubt and together they
///   explain as much of the cluster as one thing would have to (VerifyConfig::min_explained);
/// - neighbours of which none is recognised are one thing when they are recognised together;
/// - an open cluster nearly all of which a chosen thing beside it explains is a part of that.
/// So a cluster that one model explains is never cut, whatever is printed on it. Deterministic.
/// @param view labelled by `clusters` (MakeView()).
Regrouped RecogniseRegrouping(const View& view, const std::vector<world::Cluster>& clusters,
                              const std::vector<RecognitionModel>& models,
                              const RecogniseConfig& config);

}  // namespace secondlook::perception

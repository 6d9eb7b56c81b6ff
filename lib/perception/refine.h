#pragma once

#include <vector>

#include "lib/geometry/depth_rasteriser.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/view.h"

namespace secondlook::perception {

/// Refines X_CM against the measurements of cluster `label`: `rounds` times the model is rendered,
/// and one Gauss-Newton step brings
/// - rendered points onto the measured points of their pixels, along the rendered normal;
/// - the silhouette over the pixels of the cluster that it misses, and off those beside it where
///   the camera sees farther, in the image: that holds what slides on its own surface;
/// - the lowest points onto the support plane when it nearly stands there.
/// Residuals weigh less the larger they are (Cauchy); directions that nothing holds are left alone
/// (SolvePointToPlane).
Pose RefinePose(const RecognitionModel& model, Pose X_CM, const View& view, int label, int rounds,
                geometry::DepthRasteriser* rasteriser);

/// A model in one view.
struct PlacedModel {
  const View* view{};
  int label{};  ///< Of its cluster.
  Pose X_CM;
};

/// Refines one model in several views at once: `rounds` Gauss-Newton steps of a motion of M that is
/// common to all views, so that each keeps its own error of registration. What RefinePose() brings
/// to where it was measured counts, and colour: the tones of what is rendered are brought onto
/// those of the picture along their gradient, as in direct image alignment (Lucas and Kanade 1981).
/// That turns a model whose shape does not tell. Returns X_MS: the model is at X_CM * X_MS.
Pose RefineTogether(const RecognitionModel& model, std::vector<PlacedModel> placed, int rounds,
                    geometry::DepthRasteriser* rasteriser);

}  // namespace secondlook::perception

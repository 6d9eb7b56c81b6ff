#pragma once

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

}  // namespace secondlook::perception

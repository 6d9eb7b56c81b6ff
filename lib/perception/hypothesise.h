#pragma once

#include <vector>

#include "lib/geometry/sampling.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/view.h"
#include "lib/world/observation.h"

namespace secondlook::perception {

/// A pose worth refining, with what the model's points say about it.
struct PoseGuess {
  Pose X_CM{Pose::Identity()};
  double quality{};  ///< Of its PointMatch, less where the colours disagree.
};

/// A cluster's surface as oriented points in C, one for each third pixel or so.
std::vector<geometry::OrientedPoint> OrientCluster(const View& view, int label,
                                                   const world::Cluster& cluster);

/// The mean of the model's points that face the camera at X_CM, by the pixels they cover [m, C].
Eigen::Vector3d VisibleMean(const RecognitionModel& model, const Pose& X_CM);

/// The poses at which `model` may have made the cluster: from the votes of point pairs (any pose),
/// and from the ways it rests on the support plane, turned about the plane's normal and put where
/// the cluster is. Each is aligned with the measurements by the model's points; the best `count`
/// distinct ones (up to the symmetry of shape) are returned, best first. Empty when the model is
/// too small to be the cluster, or fits nowhere.
std::vector<PoseGuess> HypothesisePoses(const RecognitionModel& model, const View& view, int label,
                                        const world::Cluster& cluster,
                                        const std::vector<geometry::OrientedPoint>& surface_C,
                                        int count);

}  // namespace secondlook::perception

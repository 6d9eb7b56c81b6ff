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
  Pose X_CM;    ///< By a pose common to all views and the registration of this one.
};

/// How well views are registered to each other, where they see the model: standard deviations.
struct RegistrationSigma {
  double rotation{};     ///< [rad]
  double translation{};  ///< [m]
};

/// A pose that several views agree on.
struct JointPose {
  Pose X_MS{Pose::Identity()};  ///< In common: the model is at X_CM * X_MS.
  /// Where each view itself has it, by what its registration may err: about X_CM * X_MS.
  std::vector<Pose> X_CM;
  /// Of (rotation vector [rad], translation [m]) of the model's origin, in M.
  Eigen::Matrix<double, 6, 6> covariance;
};

/// Refines one model in several views at once: `rounds` Gauss-Newton steps of a motion of M that is
/// common to all views. What RefinePose() brings to where it was measured counts, but that contact
/// holds the height alone; and colour: the tones of what is rendered are brought onto those of the
/// picture along their gradient, as in direct image alignment (Lucas and Kanade 1981). That turns a
/// model whose shape does not tell. A view counts in each direction by how well it holds it, and by
/// no more than `registration` allows: so the mean of the views decides what all of them hold, and
/// the one that shows the print what the others don't. @pre `placed` is not empty, `registration`
/// and `rounds` are positive.
JointPose RefineTogether(const RecognitionModel& model, const std::vector<PlacedModel>& placed,
                         const RegistrationSigma& registration, int rounds,
                         geometry::DepthRasteriser* rasteriser);

}  // namespace secondlook::perception

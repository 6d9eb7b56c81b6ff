#pragma once

#include <memory>
#include <vector>

#include "lib/common/pose.h"
#include "lib/geometry/sampling.h"
#include "lib/perception/recognition_model.h"

namespace cv::ppf_match_3d {
class PPF3DDetector;
}

namespace secondlook::apps {

/// A pose that the peer proposes.
struct PeerPose {
  Pose X_CM{Pose::Identity()};
  int votes{};
  double vote_share{};  ///< Of the pairs that could have voted for it.
  double
      residual{};  ///< Of its ICP; infinite where that has failed, and the pose is the voted one.
};

/// Recognition of one model by another library: OpenCV's PPF3DDetector (Drost et al. 2010), then
/// its ICP on the best poses. It is called as served it best in trials: poses are not gathered, ICP
/// aligns the side that faces the camera, on four levels. The detector thins a cloud in cells that
/// are as long and as narrow as the box around it; here both clouds are thinned beforehand to the
/// spacing of `model.ppf`, the model to the very same points, so that its cells find nothing left
/// to thin. Threading: Match() from any number of threads.
class PpfPeer {
 public:
  /// Trains on the points of `model.ppf`. @pre the model outlives this.
  explicit PpfPeer(const perception::RecognitionModel& model);
  ~PpfPeer();
  PpfPeer(PpfPeer&&) noexcept;
  PpfPeer& operator=(PpfPeer&&) noexcept;

  /// The `count` poses with the most votes in the cloud, refined on all of it, by falling votes.
  /// None when the cloud is smaller than a few spacings.
  std::vector<PeerPose> Match(const std::vector<geometry::OrientedPoint>& cloud_C, int count) const;

 private:
  const perception::RecognitionModel* model_;
  std::unique_ptr<cv::ppf_match_3d::PPF3DDetector> detector_;
};

}  // namespace secondlook::apps

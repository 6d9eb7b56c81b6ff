#include "lib/perception/recognise_frame.h"

#include <utility>

#include "lib/perception/regroup.h"

namespace secondlook::perception {

FrameRecognition RecogniseFrame(const cv::Mat& color, const cv::Mat& depth,
                                const geometry::CameraModel& camera, const Eigen::Vector3d& up_C,
                                const std::vector<RecognitionModel>& models,
                                const SegmentConfig& segment, const RecogniseConfig& config) {
  const Segmentation segmentation = Segment(geometry::Deproject(depth, camera), up_C, segment);
  FrameRecognition found;
  found.plane_C = segmentation.plane_C;
  found.reason = segmentation.reason;
  if (!found.plane_C) return found;
  found.further_C = segmentation.FurtherPlanes();
  const View view =
      MakeView(color, depth, camera, *found.plane_C, segmentation.clusters, found.further_C);
  Regrouped things = RecogniseRegrouping(view, segmentation.clusters, models, config);
  found.detections = std::move(things.detections);
  found.choices = std::move(things.choices);
  return found;
}

}  // namespace secondlook::perception

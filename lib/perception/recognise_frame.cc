#include "lib/perception/recognise_frame.h"

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
  const View view = MakeView(color, depth, camera, *found.plane_C, segmentation.clusters);
  found.detections = Recognise(view, segmentation.clusters, models, config);
  found.choices = ChooseHypotheses(found.detections, config);
  return found;
}

}  // namespace secondlook::perception

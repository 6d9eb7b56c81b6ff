#include "sim/ground_truth.h"

#include <algorithm>

#include <opencv2/core.hpp>

#include "lib/common/error.h"

namespace secondlook::sim {

const TrueView& GroundTruth::ViewOf(std::uint64_t sequence) const {
  const auto view = std::find_if(views().begin(), views().end(),
                                 [&](const TrueView& v) { return v.sequence == sequence; });
  if (view == views().end()) {
    Throw<InvalidArgument>("frame {} was never grabbed; {} frames were", sequence, views().size());
  }
  return *view;
}

SceneRenderer& GroundTruth::RendererFor(const geometry::CameraModel& model) {
  if (!renderer_ || !(model == model_)) {
    model_ = model;
    renderer_ = std::make_unique<SceneRenderer>(world_, model);
  }
  return *renderer_;
}

Render GroundTruth::CleanFrame(std::uint64_t sequence, const geometry::CameraModel& model) {
  const TrueView& view = ViewOf(sequence);
  return RendererFor(model).Draw(view.X_WC, view.state);
}

std::vector<Visibility> GroundTruth::VisibilityIn(std::uint64_t sequence,
                                                  const geometry::CameraModel& model) {
  const TrueView& view = ViewOf(sequence);
  const cv::Mat ids = CleanFrame(sequence, model).id;
  std::vector<Visibility> visibilities;
  for (std::size_t i = 0; i < objects().size(); ++i) {
    const int index = static_cast<int>(i);
    const cv::Mat alone = RendererFor(model).DrawAlone(view.X_WC, index).id;
    visibilities.push_back(
        {cv::countNonZero(ids == kFirstObjectId + index), cv::countNonZero(alone)});
  }
  return visibilities;
}

}  // namespace secondlook::sim

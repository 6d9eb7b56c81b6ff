#pragma once

#include <optional>

#include <opencv2/core/types.hpp>

#include "lib/geometry/depth_rasteriser.h"
#include "lib/perception/color_match.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/rendered_colors.h"
#include "lib/perception/view.h"

namespace secondlook::perception {

/// The colours that a model shows in a view at one pose, to compare other poses with.
class PosedColors {
 public:
  /// @param model and view are referred to.
  PosedColors(const RecognitionModel& model, const Pose& X_CM, const View& view);

  /// How much more likely the colours of the view are with the model at this pose than at `other`:
  /// the logarithm of the ratio of the likelihoods; empty where fewer than 20 pixels can be
  /// compared.
  ///
  /// Compared are the tones (ToneDifferences()) of the pixels at which both poses agree with the
  /// depth, or nothing is measured. Their differences from either pose are taken as normal, with a
  /// covariance that is found from them: so the ratio is that of the determinants of the two
  /// covariances, to the power of half the number of independent patches. What is alike over a
  /// block of pixels is taken apart from what differs within: errors of the light are smooth, and
  /// count once a block, while a print that is weak but everywhere where it should be (the grain of
  /// wood) speaks as clearly as a strong one. Each pose sees the picture moved by up to two pixels,
  /// to where its colours fit best: half a degree off, a fine grain lies a pixel aside, and agrees
  /// no better than at a pose turned by half. At most 8 either way: gloss and wear follow no law.
  std::optional<double> LogRatio(const PosedColors& other) const;

 private:
  /// The rendered colour at a pixel where the depth there is what was measured, or nothing is
  /// measured; else empty.
  std::optional<ColorPair> PairAt(int u, int v) const;

  /// Of the picture, at which what it shows fits this pose best [px].
  cv::Point BestShift() const;

  const RecognitionModel& model_;
  const View& view_;
  geometry::DepthRasteriser rendered_;
  RenderedColors colors_;
  cv::Point shift_;  ///< BestShift().
};

}  // namespace secondlook::perception

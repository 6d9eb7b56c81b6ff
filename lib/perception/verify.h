#pragma once

#include "lib/geometry/depth_rasteriser.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/view.h"
#include "lib/world/hypothesis.h"

namespace secondlook::perception {

/// What a hypothesis must show to be accepted.
struct VerifyConfig {
  double min_quality = 0.4;           ///< q_h of Kriegel 2013, Eq. 5.
  int min_visible_px = 200;           ///< Fewer say too little.
  double min_visible_fraction = 0.1;  ///< Of the silhouette.
  double min_inner = 0.55;            ///< Of the silhouette is no rim: else it is too thin.
  double max_unmeasured = 0.92;       ///< Of the silhouette: no return from there.
  double min_matching = 0.85;         ///< Of the visible pixels.
  double max_see_through = 0.08;      ///< Of the visible pixels.
  double min_explained = 0.7;         ///< Of the cluster.
  double min_color_agreement = 0.4;   ///< See CompareColors(); not asked without colour.
  double max_gap_m = 0.02;            ///< The lowest point may stand so high above the plane…
  double max_sink_m = 0.015;          ///< …or so deep in it.

  template <class A>
  void Serialize(A* a) {
    a->Visit("min_quality", &min_quality);
    a->Visit("min_visible_px", &min_visible_px);
    a->Visit("min_visible_fraction", &min_visible_fraction);
    a->Visit("min_inner", &min_inner);
    a->Visit("max_unmeasured", &max_unmeasured);
    a->Visit("min_matching", &min_matching);
    a->Visit("max_see_through", &max_see_through);
    a->Visit("min_explained", &min_explained);
    a->Visit("min_color_agreement", &min_color_agreement);
    a->Visit("max_gap_m", &max_gap_m);
    a->Visit("max_sink_m", &max_sink_m);
  }

  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// Renders `model` at X_CM and compares it with `view`, to explain the cluster `label`, which has
/// `cluster_pixels` pixels without its rim (InnerPixels()).
///
/// A pose of which half the points lie beside the picture is refused: the part within could be a
/// part of anything.
///
/// The rim of the silhouette and of depth steps (one pixel to each side) is left out, as depth
/// cameras see nothing right there. A pixel without a measurement says nothing. A pixel measured
/// nearer than the surface, and not of the same cluster, is hidden: it is not counted in N_r, where
/// the paper counts every rendered pixel, so that an object half behind another can pass. What
/// matches agrees with the measurement within DepthTolerance() and, averaged over 5 x 5 pixels,
/// within a tighter one, which tells nearly equal shapes apart where single pixels are noise; from
/// both, what bends smoothly over the object is taken out first (DepthBias). For large models both
/// tolerances grow with the width.
/// `*score` becomes ScoreOf() the result. @pre model is not empty.
world::Verification Verify(const RecognitionModel& model, const Pose& X_CM, const View& view,
                           int label, int cluster_pixels, const VerifyConfig& config,
                           geometry::DepthRasteriser* rasteriser, double* score);

/// The pixels of the cluster `label` all of whose eight neighbours belong to it too.
int InnerPixels(const View& view, int label, const world::Cluster& cluster);

/// Probability-like support, in [0, 1], that model and pose are right: the logistic function of
/// 14 (m - 0.85) + 8 (e - 0.85) - 12 t + w (c - 0.45), less 2
/// where a check failed, with the shares of the visible pixels that
/// match (m) and that are seen through (t), the explained share of the cluster (e) and the
/// agreement of the colours (c; without colour that term is left out). The weight w grows with the
/// matching pixels, from 25 to 45: a small difference in a large print decides, one in a few pixels
/// does not.
double ScoreOf(const world::Verification& verification, double explained);

/// The log-odds of a score; finite for 0 and 1, too.
double LogOdds(double score);

}  // namespace secondlook::perception

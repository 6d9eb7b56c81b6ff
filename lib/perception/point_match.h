#pragma once

#include "lib/common/pose.h"
#include "lib/perception/recognition_model.h"
#include "lib/perception/view.h"

namespace secondlook::perception {

/// What the drawn points of a model say about a pose: a thousandth of the cost of rendering it.
/// Each point that faces the camera stands for the pixels that its share of the surface covers.
/// Points that the model itself hides count as hidden behind a nearer measurement.
struct PointMatch {
  double matching{};     ///< Pixels measured at the model's surface.
  double explained{};    ///< Of these, of the cluster.
  double see_through{};  ///< Pixels measured well behind it.
  double quality{};      ///< Eq. 5 of Kriegel 2013 from these, in [0, 1].
};

/// Compares the first `count` points of `model` at X_CM with `view`, to explain the cluster `label`
/// of `cluster_pixels` pixels. @pre 0 < count <= model.points.size().
PointMatch MatchPoints(const RecognitionModel& model, const Pose& X_CM, const View& view, int label,
                       int cluster_pixels, int count);

/// Moves X_CM so that the first `count` points of `model` come to lie on the measured points of
/// cluster `label` on the same rays (projective point-to-plane, robust). The gate shrinks from
/// `gate` [m] to the depth's tolerance over the `rounds`. A model that nearly stands on the support
/// plane is drawn onto it. What the measurements do not hold stays.
Pose AlignPoints(const RecognitionModel& model, Pose X_CM, const View& view, int label, int count,
                 int rounds, double gate);

}  // namespace secondlook::perception

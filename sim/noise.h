#pragma once

#include <opencv2/core/mat.hpp>

#include "lib/common/rng.h"
#include "lib/geometry/camera_model.h"
#include "sim/render.h"

namespace secondlook::sim {

/// How bad the simulated robot is. The defaults are those of every experiment; a scene or a test
/// overrides single ones. "sigma" is the standard deviation of a normal error, of each axis where
/// there are several.
struct NoiseConfig {
  // The depth camera: C. V. Nguyen, S. Izadi and D. Lovell, "Modeling Kinect sensor noise for
  // improved 3D reconstruction and tracking", 3DIMPVT 2012, Section 3.
  double depth_axial_scale{1.0};       ///< Times AxialSigma(); 0: none.
  double depth_lateral_sigma_px{0.8};  ///< By which the outline of a surface jitters.
  double lateral_correlation_px{4.0};  ///< Over which that jitter is alike: the matching window.
  double disparity_step_px{0.125};     ///< Disparities are multiples of it; 0: not quantised.
  double disparity_baseline{0.075};    ///< Projector to camera [m].
  double edge_jump{0.02};              ///< A step beyond this share of z has no return beside it;
                                       ///< 0: edges return.
  double max_incidence_deg{80.0};      ///< Beyond it nothing returns; 90: everything does.
  double dark_shiny_loss{0.95};        ///< Lost share of a surface that is black and a mirror.
  double dark_luminance{0.15};         ///< Linear luminance below which a surface counts as dark.
  double shiny_specular{0.5};          ///< Highlight strength from which it counts as a mirror.

  // The colour camera.
  double exposure_sigma{0.06};       ///< Of the gain of a frame, 1 = right.
  double white_balance_sigma{0.02};  ///< Of the gains of red and blue in a frame, 1 = right.
  double color_sigma{4.0};           ///< Of each value of a pixel, of 255.

  // The base. Each stop has its own error of localisation.
  double localisation_sigma{0.015};    ///< x and y [m].
  double localisation_sigma_deg{0.7};  ///< Heading.
  double odometry_drift{0.01};         ///< Sigma of the scale error of distances and turns.

  // The head.
  double pan_tilt_sigma_deg{0.1};    ///< Of both angles, new with each motion.
  double extrinsics_sigma{0.003};    ///< Of the camera on the head, fixed for a mission [m].
  double extrinsics_sigma_deg{0.3};  ///< Likewise.

  // The arm, if there is one.
  double arm_sigma{0.001};         ///< Of the flange, new with each motion [m].
  double arm_sigma_deg{0.1};       ///< Likewise.
  double hand_eye_sigma{0.001};    ///< Of the camera on the flange, fixed for a mission [m].
  double hand_eye_sigma_deg{0.2};  ///< Likewise.

  // The laser striper, if there is one; it is mounted as well as the hand's camera.
  double striper_range_sigma{0.0001};      ///< Of a range [m].
  double striper_max_incidence_deg{75.0};  ///< Beyond it nothing returns; 90: everything does.

  double stamp_sigma{0.005};  ///< Of the time on a frame or a line [s].

  template <class A>
  void Serialize(A* a) {
    a->Visit("depth_axial_scale", &depth_axial_scale);
    a->Visit("depth_lateral_sigma_px", &depth_lateral_sigma_px);
    a->Visit("lateral_correlation_px", &lateral_correlation_px);
    a->Visit("disparity_step_px", &disparity_step_px);
    a->Visit("disparity_baseline", &disparity_baseline);
    a->Visit("edge_jump", &edge_jump);
    a->Visit("max_incidence_deg", &max_incidence_deg);
    a->Visit("dark_shiny_loss", &dark_shiny_loss);
    a->Visit("dark_luminance", &dark_luminance);
    a->Visit("shiny_specular", &shiny_specular);
    a->Visit("exposure_sigma", &exposure_sigma);
    a->Visit("white_balance_sigma", &white_balance_sigma);
    a->Visit("color_sigma", &color_sigma);
    a->Visit("localisation_sigma", &localisation_sigma);
    a->Visit("localisation_sigma_deg", &localisation_sigma_deg);
    a->Visit("odometry_drift", &odometry_drift);
    a->Visit("pan_tilt_sigma_deg", &pan_tilt_sigma_deg);
    a->Visit("extrinsics_sigma", &extrinsics_sigma);
    a->Visit("extrinsics_sigma_deg", &extrinsics_sigma_deg);
    a->Visit("arm_sigma", &arm_sigma);
    a->Visit("arm_sigma_deg", &arm_sigma_deg);
    a->Visit("hand_eye_sigma", &hand_eye_sigma);
    a->Visit("hand_eye_sigma_deg", &hand_eye_sigma_deg);
    a->Visit("striper_range_sigma", &striper_range_sigma);
    a->Visit("striper_max_incidence_deg", &striper_max_incidence_deg);
    a->Visit("stamp_sigma", &stamp_sigma);
  }

  /// @throws ConfigError naming the first value that is out of range.
  void Validate() const;

  /// A robot without any error.
  static NoiseConfig None();
};

/// What a depth camera measures, and how near and far it can.
struct DepthRange {
  double min{0.5};  ///< [m]
  double max{6.0};  ///< [m]
};

/// The standard deviation [m] of a depth `z` > 0 [m] on a surface hit at `incidence` [rad] from its
/// normal (Nguyen, Izadi and Lovell 2012, Eq. 3): 1.2 mm + 1.9 mm/m^2 (z - 0.4 m)^2, and beyond 60
/// degrees 0.1 mm sqrt(1 m / z) incidence^2 / (pi/2 - incidence)^2 more.
double AxialSigma(double z, double incidence);

/// The share of returns lost on a material of linear `luminance` with highlights of strength
/// `specular`, hit at the angle whose cosine is `cos_incidence`: it grows as the surface is darker
/// and shinier, and shrinks to a half where it faces the camera.
double DarkShinyLoss(double luminance, double specular, double cos_incidence,
                     const NoiseConfig& config);

/// What the depth camera makes of a clean picture: [height, width] CV_32FC1, z [m], NaN = no
/// return. An outline jitters by whole surfaces: no depth is ever a mixture of two.
cv::Mat DepthNoise(const Render& clean, const geometry::CameraModel& model, const DepthRange& range,
                   const NoiseConfig& config, Rng* rng);

/// What the colour camera makes of a clean picture: CV_8UC3, RGB.
cv::Mat ColorNoise(const Render& clean, const NoiseConfig& config, Rng* rng);

}  // namespace secondlook::sim

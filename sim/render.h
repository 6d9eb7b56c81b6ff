#pragma once

#include <opencv2/core/mat.hpp>

namespace secondlook::sim {

/// A clean picture of the scene: what an ideal camera sees, and what its errors depend on. All are
/// [height, width]; where nothing is seen, id is 0, depth NaN and the rest 0.
struct Render {
  cv::Mat color;          ///< CV_8UC3, RGB, gamma-encoded (sRGB).
  cv::Mat depth;          ///< CV_32FC1, z_C [m] at the centre of the pixel; NaN = nothing.
  cv::Mat cos_incidence;  ///< CV_32FC1, cosine between the ray and the surface's normal, [0, 1].
  cv::Mat luminance;      ///< CV_32FC1, linear, of the material without light, [0, 1].
  cv::Mat specular;       ///< CV_32FC1, Material::specular.
  cv::Mat id;             ///< CV_16UC1, the Instance::id that is seen; 0 = nothing.
};

}  // namespace secondlook::sim

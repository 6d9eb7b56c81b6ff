#pragma once

#include <vector>

#include <Eigen/Core>

namespace secondlook::perception {

/// One spot of a surface, as it was seen and as the model has it.
struct ColorPair {
  Eigen::Vector3f measured;  ///< RGB in [0, 1], of a small neighbourhood.
  Eigen::Vector3f modelled;  ///< RGB in [0, 1], of the same neighbourhood, unlit.
  Eigen::Vector3f normal_C;  ///< Unit; light falls differently on differently turned faces.
};

/// How well `pairs` agree, in [0, 1]; NaN for fewer than 20 pairs.
/// Compared are log-lightness and the shares of red and blue. Before that, what light and camera
/// may have done is fitted robustly and taken out: a lightness that depends linearly on the normal
/// (exposure, shading; bounded to a factor of about 3) and on the model's own lightness (contrast;
/// bounded to 0.7 … 1.6), and an offset of each share (white balance; bounded, so that red does not
/// become blue). The agreement of a pair is exp(-e^2 / 2) with e its remaining difference in units
/// of what noise, highlights and shadows make usual; the result is the mean.
double CompareColors(const std::vector<ColorPair>& pairs);

}  // namespace secondlook::perception

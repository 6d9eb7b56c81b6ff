#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace secondlook::perception {

/// One spot of a surface, as it was seen and as the model has it.
struct ColorPair {
  Eigen::Vector3f measured;  ///< RGB in [0, 1], of a small neighbourhood.
  Eigen::Vector3f modelled;  ///< RGB in [0, 1], of the same neighbourhood, unlit.
  Eigen::Vector3f normal_C;  ///< Unit; light falls differently on differently turned faces.
};

/// The mean colour of the 3 x 3 pixels around (x, y) of `color` (CV_8UC3, RGB), RGB in [0, 1].
Eigen::Vector3f MeanColor(const cv::Mat& color, int x, int y);

/// Log-lightness and the shares of red and blue of a colour (RGB in [0, 1]), each in units of what
/// noise, highlights and shadows make usual.
Eigen::Vector3d ToneOf(const Eigen::Vector3f& rgb);

/// The tone that was measured less the one to expect, by pair: what light and camera may have done
/// is fitted and taken out first, see CompareColors().
std::vector<Eigen::Vector3d> ToneDifferences(const std::vector<ColorPair>& pairs);

/// How well `pairs` agree, in [0, 1]; NaN for fewer than 20 pairs.
/// Compared are log-lightness and the shares of red and blue. Before that, what light and camera
/// may have done is fitted robustly and taken out: a lightness that depends linearly on the normal
/// (exposure, shading; bounded to a factor of about 3) and on the model's own lightness (contrast;
/// bounded to 0.7 … 1.6), a common factor of the shares about grey (saturation; bounded to
/// 0.8 … 1.4), and an offset of each share (white balance; bounded, so that red does not become
/// blue). Of a value clipped by the picture only the lower bound counts. The agreement of a pair is
/// exp(-e^2 / 2) with e its remaining difference in units of what noise, highlights and shadows
/// make usual; the result is the mean.
double CompareColors(const std::vector<ColorPair>& pairs);

}  // namespace secondlook::perception

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/types.hpp>

namespace secondlook::perception {

/// Answers which pixel of a set is nearest to a pixel, within a reach: exact, and for the few
/// questions asked of an image cheaper than a distance transform of it.
class NearestPixel {
 public:
  /// The set of the `width` x `height` pixels (> 0) whose `mask`, row by row, isn't 0.
  /// @pre mask.size() == width * height, 0 < reach < 128 [px].
  NearestPixel(const std::vector<char>& mask, int width, int height, int reach);

  /// The pixel of the set nearest to (x, y) inside the image; the topmost of several, of these the
  /// left one. Empty if none is nearer than the reach.
  std::optional<cv::Point> To(int x, int y) const;

 private:
  int width_;
  int height_;
  int reach_;
  std::vector<std::int8_t> along_;  ///< To the nearest in the row; `reach_` where that is far.
};

}  // namespace secondlook::perception

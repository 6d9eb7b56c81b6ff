#include "lib/perception/nearest_pixel.h"

#include <algorithm>
#include <cstdlib>

namespace secondlook::perception {

NearestPixel::NearestPixel(const std::vector<char>& mask, int width, int height, int reach)
    : width_(width), height_(height), reach_(reach), along_(mask.size()) {
  for (int y = 0; y < height; ++y) {
    const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    int left = reach;  // how far the last one lies behind
    for (int x = 0; x < width; ++x) {
      const std::size_t at = row + static_cast<std::size_t>(x);
      left = mask[at] != 0 ? 0 : std::min(left + 1, reach);
      along_[at] = static_cast<std::int8_t>(left == reach ? reach : -left);
    }
    int right = reach;
    for (int x = width - 1; x >= 0; --x) {
      const std::size_t at = row + static_cast<std::size_t>(x);
      right = mask[at] != 0 ? 0 : std::min(right + 1, reach);
      if (right < std::abs(along_[at])) along_[at] = static_cast<std::int8_t>(right);
    }
  }
}

std::optional<cv::Point> NearestPixel::To(int x, int y) const {
  std::optional<cv::Point> nearest;
  int least = reach_ * reach_;
  for (int v = std::max(y - reach_ + 1, 0); v < std::min(y + reach_, height_); ++v) {
    const int dx = along_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                          static_cast<std::size_t>(x)];
    const int squared = dx * dx + (v - y) * (v - y);
    if (squared >= least) continue;
    least = squared;
    nearest = cv::Point(x + dx, v);
  }
  return nearest;
}

}  // namespace secondlook::perception

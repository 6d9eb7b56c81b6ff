#include "lib/geometry/camera_model.h"

#include "lib/common/error.h"

namespace secondlook::geometry {

void CameraModel::Validate(const char* name) const {
  if (width < 1 || height < 1 || width > 16384 || height > 16384) {
    Throw<InvalidArgument>("camera '{}': an image of {} x {} px; both must lie in 1..16384", name,
                           width, height);
  }
  if (!(fx > 0.0) || !(fy > 0.0) || !std::isfinite(fx) || !std::isfinite(fy)) {
    Throw<InvalidArgument>("camera '{}': focal lengths fx = {}, fy = {} px must be positive", name,
                           fx, fy);
  }
  if (!std::isfinite(cx) || !std::isfinite(cy)) {
    Throw<InvalidArgument>("camera '{}': principal point ({}, {}) px must be finite", name, cx, cy);
  }
}

}  // namespace secondlook::geometry

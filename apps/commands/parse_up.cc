#include "apps/commands/parse_up.h"

#include <vector>

#include "lib/common/error.h"
#include "lib/common/numbers.h"

namespace secondlook::apps {

Eigen::Vector3d ParseUp(const std::string& text) {
  const std::vector<double> values = ParseNumbers(text).value_or(std::vector<double>{});
  const Eigen::Vector3d up = values.size() == 3 ? Eigen::Vector3d(values[0], values[1], values[2])
                                                : Eigen::Vector3d::Zero();
  if (up.norm() < 1e-9) {
    Throw<InvalidArgument>(
        "--up {}: must be the direction against gravity in the camera frame as x,y,z, e.g. 0,-1,0",
        text);
  }
  return up.normalized();
}

}  // namespace secondlook::apps

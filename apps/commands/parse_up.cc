#include "apps/commands/parse_up.h"

#include <sstream>

#include "lib/common/error.h"

namespace secondlook::apps {

Eigen::Vector3d ParseUp(const std::string& text) {
  std::istringstream in(text);
  Eigen::Vector3d up;
  char comma[2] = {};
  in >> up.x() >> comma[0] >> up.y() >> comma[1] >> up.z();
  const bool whole = in && (in >> std::ws).eof() && comma[0] == ',' && comma[1] == ',';
  if (!whole || !up.allFinite() || up.norm() < 1e-9) {
    Throw<InvalidArgument>(
        "--up {}: must be the direction against gravity in the camera frame as x,y,z, e.g. 0,-1,0",
        text);
  }
  return up.normalized();
}

}  // namespace secondlook::apps

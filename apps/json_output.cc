#include "apps/json_output.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "lib/common/error.h"
#include "lib/common/files.h"

namespace secondlook::apps {

void WriteJson(const nlohmann::ordered_json& json, const std::string& target) {
  const std::string text = json.dump(1) + "\n";
  if (target == "-") {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() ||
        std::fflush(stdout) != 0) {
      Throw<ConfigError>("standard output: cannot be written: {}", std::strerror(errno));
    }
  } else {
    WriteFile(target, text);
  }
}

nlohmann::ordered_json MatrixToJson(const Pose& X_AB) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (int i = 0; i < 4; ++i) {
    nlohmann::ordered_json row = nlohmann::ordered_json::array();
    for (int j = 0; j < 4; ++j) row.push_back(X_AB.matrix()(i, j));
    rows.push_back(row);
  }
  return rows;
}

nlohmann::ordered_json PlanesToJson(const std::vector<world::SupportPlane>& planes_A) {
  const auto vector = [](const Eigen::Vector3d& v) {
    return nlohmann::ordered_json{v.x(), v.y(), v.z()};
  };
  nlohmann::ordered_json planes = nlohmann::ordered_json::array();
  for (const world::SupportPlane& plane_A : planes_A) {
    nlohmann::ordered_json corners = nlohmann::ordered_json::array();
    for (const Eigen::Vector3d& corner : plane_A.corners_A) corners.push_back(vector(corner));
    planes.push_back(
        {{"normal", vector(plane_A.normal_A)}, {"offset", plane_A.offset}, {"corners", corners}});
  }
  return planes;
}

}  // namespace secondlook::apps

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

}  // namespace secondlook::apps

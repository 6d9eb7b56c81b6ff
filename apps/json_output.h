#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "lib/common/pose.h"
#include "lib/world/support_plane.h"

namespace secondlook::apps {

/// Writes `json`, indented, to the file `target`, or to standard output when it is "-".
/// @throws ConfigError when the file cannot be written.
void WriteJson(const nlohmann::ordered_json& json, const std::string& target);

/// A pose as four rows of four numbers.
nlohmann::ordered_json MatrixToJson(const Pose& X_AB);

/// Support planes as `{"normal": [x, y, z], "offset": number, "corners": 4 x [x, y, z]}`.
nlohmann::ordered_json PlanesToJson(const std::vector<world::SupportPlane>& planes_A);

}  // namespace secondlook::apps

#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "lib/common/pose.h"

namespace secondlook::apps {

/// Writes `json`, indented, to the file `target`, or to standard output when it is "-".
/// @throws ConfigError when the file cannot be written.
void WriteJson(const nlohmann::ordered_json& json, const std::string& target);

/// A pose as four rows of four numbers.
nlohmann::ordered_json MatrixToJson(const Pose& X_AB);

}  // namespace secondlook::apps

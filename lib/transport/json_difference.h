#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace secondlook::transport {

/// Where two messages differ first.
struct JsonDifference {
  std::string path;  ///< Of the field, e.g. "objects[2].posterior[0].probability".
  std::string a, b;  ///< What stands there in either, shortened; "nothing" where it is missing.
};

/// The first difference between `a` and `b`, field by field in their order; empty when they are the
/// same.
std::optional<JsonDifference> FirstDifference(const nlohmann::ordered_json& a,
                                              const nlohmann::ordered_json& b);

}  // namespace secondlook::transport

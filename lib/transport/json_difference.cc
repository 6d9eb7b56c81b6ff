#include "lib/transport/json_difference.h"

#include <algorithm>

#include <fmt/format.h>

namespace secondlook::transport {
namespace {

using Json = nlohmann::ordered_json;

/// Nobody reads on from here.
constexpr std::size_t kMaxText = 120;

std::string ToText(const Json* json) {
  if (json == nullptr) return "nothing";
  std::string text = json->dump();
  if (text.size() > kMaxText) text.replace(kMaxText, std::string::npos, "...");
  return text;
}

std::optional<JsonDifference> Compare(const Json* a, const Json* b, const std::string& path) {
  if (a != nullptr && b != nullptr && *a == *b) return std::nullopt;
  if (a != nullptr && b != nullptr && a->is_object() && b->is_object()) {
    for (const auto& [key, value] : a->items()) {
      const auto other = b->find(key);
      const std::string inner = path.empty() ? key : path + "." + key;
      if (auto d = Compare(&value, other == b->end() ? nullptr : &*other, inner)) return d;
    }
  } else if (a != nullptr && b != nullptr && a->is_array() && b->is_array()) {
    for (std::size_t i = 0; i < std::max(a->size(), b->size()); ++i) {
      const Json* left = i < a->size() ? &(*a)[i] : nullptr;
      const Json* right = i < b->size() ? &(*b)[i] : nullptr;
      if (auto d = Compare(left, right, fmt::format("{}[{}]", path, i))) return d;
    }
  }
  return JsonDifference{path, ToText(a), ToText(b)};
}

}  // namespace

std::optional<JsonDifference> FirstDifference(const Json& a, const Json& b) {
  return Compare(&a, &b, "");
}

}  // namespace secondlook::transport

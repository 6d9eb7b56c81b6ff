#pragma once

#include <string_view>

#include <nlohmann/json.hpp>

namespace secondlook::apps {

/// What the page needs of a message on `channel`, given as transport::ToJson() reads it: numbers
/// rounded to 1e-4, depth images, free space, covariances, paths of looks that were not taken and
/// the like left out. Null when the page needs nothing of it.
nlohmann::ordered_json ForPage(std::string_view channel, nlohmann::ordered_json message);

/// Removes what each view said about each hypothesis from an OBJECTS message: the page shows it
/// of the newest only, and it grows with the square of the number of views.
void RemoveEvidence(nlohmann::ordered_json* objects);

}  // namespace secondlook::apps

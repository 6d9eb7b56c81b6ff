#pragma once

#include <filesystem>

namespace secondlook::geometry {

/// Reads the header of a PLY file and proves that its body holds as much as the header promises.
/// The mesh library reads beyond the end of one that was cut off.
/// @throws ConfigError naming the file and what is missing from it.
void CheckPlyIsWhole(const std::filesystem::path& file);

}  // namespace secondlook::geometry

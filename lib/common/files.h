#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace secondlook {

/// The whole content of `path`.
/// @throws ConfigError naming the file when it is missing, a folder, or cannot be read.
std::string ReadFile(const std::filesystem::path& path);

/// Writes `content` to a temporary name beside `target` and renames it, so that a reader never sees
/// half a file. Makes the folder when it is missing. A link is followed; a device or a pipe is
/// written to as it is.
/// @throws ConfigError naming the file and the system's reason when that fails.
void WriteFile(const std::filesystem::path& target, std::string_view content);

/// Makes `folder` (and its parents) unless it exists, and proves that a file can be written there.
/// @throws ConfigError naming the folder and the system's reason.
void MakeWritableFolder(const std::filesystem::path& folder);

}  // namespace secondlook

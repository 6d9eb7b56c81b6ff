#include "lib/common/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

#include "lib/common/error.h"

namespace secondlook {

namespace fs = std::filesystem;

std::string ReadFile(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    Throw<ConfigError>("{}: is a folder; a file was expected", path.string());
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) Throw<ConfigError>("{}: cannot be read: {}", path.string(), std::strerror(errno));
  std::string content{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) Throw<ConfigError>("{}: reading failed: {}", path.string(), std::strerror(errno));
  return content;
}

void WriteFile(const fs::path& target, std::string_view content) {
  std::error_code none;
  // Through a link to what it points at; a device or a pipe is written to, never replaced.
  fs::path path = fs::is_symlink(target, none) ? fs::weakly_canonical(target, none) : target;
  if (path.empty()) path = target;
  if (fs::exists(path, none) && !fs::is_regular_file(path, none) && !fs::is_directory(path, none)) {
    std::ofstream out(path, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.flush();
    if (!out) Throw<ConfigError>("{}: cannot be written: {}", path.string(), std::strerror(errno));
    return;
  }
  if (path.has_parent_path()) {
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error) {
      Throw<ConfigError>("{}: cannot make its folder: {}", path.string(), error.message());
    }
  }
  const fs::path temporary = path.string() + ".tmp" + std::to_string(::gettid());
  {
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.flush();
    if (!out) {
      const int reason = errno;
      std::error_code ignored;
      fs::remove(temporary, ignored);
      Throw<ConfigError>("{}: cannot be written: {}", path.string(), std::strerror(reason));
    }
  }
  std::error_code error;
  fs::rename(temporary, path, error);
  if (error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    Throw<ConfigError>("{}: cannot be written: {}", path.string(), error.message());
  }
}

void MakeWritableFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    Throw<ConfigError>("folder {}: cannot be made: {}; choose another or fix its permissions",
                       folder.string(), error.message());
  }
  const fs::path probe = folder / (".writable" + std::to_string(::gettid()));
  const int file = ::open(probe.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) {
    Throw<ConfigError>("folder {}: cannot be written to: {}; choose another or fix its permissions",
                       folder.string(), std::strerror(errno));
  }
  ::close(file);
  fs::remove(probe, error);
}

}  // namespace secondlook

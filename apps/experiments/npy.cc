#include "apps/experiments/npy.h"

#include <cstring>
#include <regex>
#include <string>

#include "lib/common/error.h"
#include "lib/common/files.h"

namespace secondlook::apps {

cv::Mat ReadNpy(const std::filesystem::path& path) {
  const std::string bytes = ReadFile(path);
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  if (bytes.size() < 10 || !bytes.starts_with("\x93NUMPY") || byte(6) != 1) {
    Throw<ConfigError>("{}: no NumPy file of version 1", path.string());
  }
  const std::size_t begin = 10U + byte(8) + 256U * byte(9);
  const std::string header = bytes.substr(10, begin - 10);
  const std::regex pattern(
      "'descr': *'<f4'.*'fortran_order': *False.*'shape': *\\(([0-9]{1,5}), *([0-9]{1,5})\\)");
  std::smatch match;
  if (!std::regex_search(header, match, pattern)) {
    Throw<ConfigError>("{}: no matrix of 32-bit floats row by row: {}", path.string(), header);
  }
  cv::Mat matrix(std::stoi(match[1]), std::stoi(match[2]), CV_32FC1);
  const std::size_t size = matrix.total() * sizeof(float);
  if (bytes.size() != begin + size) {
    Throw<ConfigError>("{}: {} bytes of data, its shape needs {}", path.string(),
                       bytes.size() - std::min(begin, bytes.size()), size);
  }
  std::memcpy(matrix.data, bytes.data() + begin, size);
  return matrix;
}

}  // namespace secondlook::apps

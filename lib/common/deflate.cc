#include "lib/common/deflate.h"

#include <zlib.h>

#include "lib/common/error.h"

namespace secondlook {

std::vector<std::uint8_t> Deflate(std::span<const std::uint8_t> bytes) {
  uLongf size = compressBound(bytes.size());
  std::vector<std::uint8_t> stream(size);
  compress2(stream.data(), &size, bytes.data(), bytes.size(), Z_BEST_SPEED);  // cannot fail
  stream.resize(size);
  return stream;
}

std::vector<std::uint8_t> Inflate(std::span<const std::uint8_t> stream, std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  uLongf got = size;
  const int status = uncompress(bytes.data(), &got, stream.data(), stream.size());
  if (status != Z_OK || got != size) {
    Throw<ProtocolError>("a zlib stream of {} bytes does not hold the {} bytes it should",
                         stream.size(), size);
  }
  return bytes;
}

}  // namespace secondlook

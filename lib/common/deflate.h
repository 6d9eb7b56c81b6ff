#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace secondlook {

/// Compresses `bytes` into a zlib stream, fast rather than small.
std::vector<std::uint8_t> Deflate(std::span<const std::uint8_t> bytes);

/// Decompresses a zlib stream of exactly `size` bytes. @throws ProtocolError for anything else; no
/// more than `size` bytes are ever taken.
std::vector<std::uint8_t> Inflate(std::span<const std::uint8_t> stream, std::size_t size);

}  // namespace secondlook

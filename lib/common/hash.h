#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace secondlook {

/// FNV-1a, 64 bits (Fowler, Noll and Vo), of `bytes`, continued from `state`. For telling contents
/// apart, not for security.
constexpr std::uint64_t Fnv1a(std::string_view bytes, std::uint64_t state = 0xcbf29ce484222325ULL) {
  for (const char c : bytes) {
    state ^= static_cast<unsigned char>(c);
    state *= 0x100000001b3ULL;
  }
  return state;
}

/// The same over the eight bytes of `value`, least significant first.
constexpr std::uint64_t Fnv1a(std::uint64_t value, std::uint64_t state = 0xcbf29ce484222325ULL) {
  for (int i = 0; i < 8; ++i) {
    state ^= (value >> (8 * i)) & 0xffU;
    state *= 0x100000001b3ULL;
  }
  return state;
}

/// `hash` as 16 lower-case hexadecimal digits.
std::string HexDigits(std::uint64_t hash);

}  // namespace secondlook

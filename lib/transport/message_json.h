#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include <nlohmann/json.hpp>

#include "lib/transport/schema.h"

namespace secondlook::transport {

/// Reads an encoded message of `type` (with its fingerprint), field by field as the schema orders
/// them. Numbers stay numbers, except that NaN and infinities become null; a `byte` array becomes a
/// base64 string; text that is not UTF-8 is mended. Whatever the bytes are, no more memory is taken
/// than their number allows.
/// @throws ProtocolError naming the field and why: of another type, cut off, a negative or an
/// impossible count, bytes left over.
nlohmann::ordered_json ToJson(std::span<const std::uint8_t> bytes, std::string_view type,
                              const Schema& schema = Schema::Messages());

/// Throws as ToJson() does; keeps nothing. What passes can be given to lcm-gen's decoder.
void Check(std::span<const std::uint8_t> bytes, std::string_view type,
           const Schema& schema = Schema::Messages());

/// How much a message from outside may hold.
struct Limits {
  std::size_t bytes = 100'000;      ///< In all.
  std::int64_t values = 1'000;      ///< In one list.
  std::int64_t characters = 1'000;  ///< In one text.
  std::int64_t data = 1'000;        ///< Bytes in one `byte` array, e.g. of an image.
};

/// Checks what comes from outside: Throws as ToJson() does, and for a message that goes over
/// `limits`, a number that is not finite, and a text that is not UTF-8 or has control characters.
void Check(std::span<const std::uint8_t> bytes, std::string_view type, const Limits& limits,
           const Schema& schema = Schema::Messages());

}  // namespace secondlook::transport

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lib/common/error.h"

namespace secondlook::transport {

/// An encoded message and the channel it is for.
struct Message {
  std::string channel;
  std::int64_t utime{};             ///< Of what it tells, as in its body [us].
  std::vector<std::uint8_t> bytes;  ///< With the fingerprint of its type in front.
};

/// Encodes an instance of a type that lcm-gen made.
template <class T>
std::vector<std::uint8_t> Encode(const T& body) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(body.getEncodedSize()));
  body.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// The message that holds `body`, whose utime it takes.
template <class T>
Message Pack(const char* channel, const T& body) {
  return {channel, body.utime, Encode(body)};
}

/// The body of a message whose bytes were checked.
/// @throws ProtocolError when it is no T.
template <class T>
T Decode(const Message& message) {
  T body;
  if (body.decode(message.bytes.data(), 0, static_cast<int>(message.bytes.size())) < 0) {
    Throw<ProtocolError>("{}: not a {}", message.channel, T::getTypeName());
  }
  return body;
}

/// Takes what the mission tells: the LCM bus, a log, a report.
class Sink {
 public:
  Sink() = default;
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  virtual ~Sink() = default;

  /// Takes the message at once and never waits; what it has no room for is dropped and counted.
  virtual void Post(const Message& message) = 0;
};

}  // namespace secondlook::transport

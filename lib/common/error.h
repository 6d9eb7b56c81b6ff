#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace secondlook {

/// What a caller cannot go on from. There is a type for each reaction of the caller; ordinary
/// outcomes (no view reachable, no match, timeout) are values with a reason instead.
/// A message says what, with which values, where, and what to do.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The user has to change the configuration or an input file (exit status 2).
class ConfigError : public Error {
 public:
  using Error::Error;
};

/// The caller has broken a documented precondition with a value from outside (exit status 2).
class InvalidArgument : public Error {
 public:
  using Error::Error;
};

/// A device is lost and of no further use (exit status 3).
class DeviceError : public Error {
 public:
  using Error::Error;
};

/// The other side of a wire does not keep to its protocol (exit status 3).
class ProtocolError : public Error {
 public:
  using Error::Error;
};

/// Throws an E whose message is formatted like fmt::format.
template <class E, class... Args>
[[noreturn]] void Throw(fmt::format_string<Args...> format, Args&&... args) {
  throw E(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace secondlook

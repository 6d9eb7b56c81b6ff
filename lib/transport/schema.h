#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace secondlook::transport {

/// One dimension of an array: of a fixed size, or of the size that an earlier field holds.
struct Dimension {
  std::int64_t size{};  ///< When `field` is empty.
  std::string field;
};

struct Field {
  std::string name;
  std::string type;  ///< Primitive ("double"), or a struct with its package ("second_look.pose_t").
  std::vector<Dimension> dimensions;  ///< Empty: a single value.
};

struct Struct {
  std::vector<Field> fields;
};

/// What the .lcm files say: the layout of every struct, by name with package.
///
/// lcm-gen's C++ decoders size their vectors by counts that nobody has checked, and know no names.
/// With the schema a message can be checked before it is decoded, shown as JSON, and compared field
/// by field.
class Schema {
 public:
  /// The messages this program was built with.
  static const Schema& Messages();

  /// @throws InvalidArgument for text that lcm-gen would not take, naming the line.
  explicit Schema(const std::vector<std::string_view>& texts);

  /// @throws InvalidArgument when there is no such struct.
  const Struct& Of(std::string_view type) const;

  /// True for boolean, byte, int8_t … int64_t, float, double and string.
  static bool IsPrimitive(std::string_view type);

  /// The hash in front of an encoded message, by LCM's rules.
  std::uint64_t Fingerprint(std::string_view type) const;

  /// The fewest bytes that one value of `type` takes, > 0.
  std::int64_t MinBytes(std::string_view type) const;

 private:
  std::uint64_t BaseHash(const Struct& s) const;
  std::uint64_t HashWithMembers(const std::string& type, std::vector<std::string> parents) const;

  std::map<std::string, Struct, std::less<>> structs_;
};

}  // namespace secondlook::transport

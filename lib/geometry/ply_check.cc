#include "lib/geometry/ply_check.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "lib/common/error.h"
#include "lib/common/files.h"

namespace secondlook::geometry {
namespace {

struct Property {
  std::size_t count_bytes{};  ///< Of the length in front of a list; 0: not a list.
  std::size_t bytes{};        ///< Of the value or of one entry of the list.
};

struct Element {
  std::string name;
  std::uint64_t count{};
  std::vector<Property> properties;
};

struct Header {
  std::string format;
  std::vector<Element> elements;
  std::size_t body{};  ///< Where the body begins in the file.
};

/// The size of a value of a PLY type, 0 for an unknown one.
std::size_t TypeBytes(std::string_view type) {
  for (const char* name : {"char", "uchar", "int8", "uint8"}) {
    if (type == name) return 1;
  }
  for (const char* name : {"short", "ushort", "int16", "uint16"}) {
    if (type == name) return 2;
  }
  for (const char* name : {"int", "uint", "int32", "uint32", "float", "float32"}) {
    if (type == name) return 4;
  }
  return type == "double" || type == "float64" ? 8 : 0;
}

/// The property that the rest of a header line declares; empty when it makes no sense.
std::optional<Property> ParseProperty(std::istringstream* line) {
  std::string type;
  std::string entry_type;
  *line >> type;
  if (type != "list") {
    const std::size_t bytes = TypeBytes(type);
    return bytes == 0 ? std::nullopt : std::optional(Property{0, bytes});
  }
  *line >> type >> entry_type;
  const Property list{TypeBytes(type), TypeBytes(entry_type)};
  return list.count_bytes == 0 || list.bytes == 0 ? std::nullopt : std::optional(list);
}

/// Empty when `text` does not begin with a complete PLY header.
std::optional<Header> ParseHeader(const std::string& text) {
  std::istringstream stream(text);
  std::string line;
  Header header;
  if (!std::getline(stream, line) || !line.starts_with("ply")) return std::nullopt;
  while (std::getline(stream, line)) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "end_header") {
      header.body = std::min(static_cast<std::size_t>(stream.tellg()), text.size());
      return header;
    }
    if (word == "format") words >> header.format;
    if (word == "element") {
      header.elements.emplace_back();
      words >> header.elements.back().name >> header.elements.back().count;
    }
    if (word == "property") {
      const std::optional<Property> property = ParseProperty(&words);
      if (!property || header.elements.empty()) return std::nullopt;
      header.elements.back().properties.push_back(*property);
    }
    if (words.bad() || (words.fail() && !words.eof())) return std::nullopt;
  }
  return std::nullopt;
}

/// Walks through the body of a binary file.
class BinaryBody {
 public:
  BinaryBody(std::string_view bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}

  /// Steps over one element; false when the body ends before it does.
  bool Skip(const Element& element) {
    for (const Property& property : element.properties) {
      std::uint64_t entries = 1;
      if (property.count_bytes != 0 && !ReadCount(property.count_bytes, &entries)) return false;
      if (entries > (bytes_.size() - at_) / property.bytes) return false;
      at_ += entries * property.bytes;
    }
    return true;
  }

 private:
  bool ReadCount(std::size_t size, std::uint64_t* count) {
    if (bytes_.size() - at_ < size) return false;
    *count = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t place = at_ + (big_endian_ ? i : size - 1 - i);
      *count = *count << 8 | static_cast<unsigned char>(bytes_[place]);
    }
    at_ += size;
    return true;
  }

  std::string_view bytes_;
  bool big_endian_;
  std::size_t at_{};
};

/// An element stands on a line of its own in an ASCII file.
std::uint64_t CountLines(std::string_view body) {
  std::uint64_t lines = 0;
  bool blank = true;
  for (const char c : body) {
    if (c == '\n') {
      lines += blank ? 0 : 1;
      blank = true;
    } else if (c != ' ' && c != '\t' && c != '\r') {
      blank = false;
    }
  }
  return lines + (blank ? 0 : 1);
}

}  // namespace

void CheckPlyIsWhole(const std::filesystem::path& file) {
  const std::string text = ReadFile(file);
  const std::optional<Header> header = ParseHeader(text);
  if (!header) Throw<ConfigError>("{}: it has no valid PLY header", file.string());
  const std::string_view body = std::string_view(text).substr(header->body);
  std::uint64_t left = CountLines(body);
  BinaryBody binary(body, header->format == "binary_big_endian");
  for (const Element& element : header->elements) {
    for (std::uint64_t i = 0; i < element.count; ++i) {
      const bool whole = header->format == "ascii" ? left-- > 0 : binary.Skip(element);
      if (whole && !element.properties.empty()) continue;
      Throw<ConfigError>("{}: it is cut off after {} of the {} elements '{}' in its header",
                         file.string(), i, element.count, element.name);
    }
  }
}

}  // namespace secondlook::geometry

#include "lib/transport/message_json.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "lib/common/error.h"

namespace secondlook::transport {
namespace {

using Json = nlohmann::ordered_json;
using Bytes = std::span<const std::uint8_t>;

constexpr std::string_view kBase64 =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string ToBase64(Bytes bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < n ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= n ? kBase64[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

/// The text with every byte that does not belong to valid UTF-8 replaced by '?'.
std::string MendedUtf8(std::string text) {
  try {
    (void)Json(text).dump();
    return text;
  } catch (const Json::type_error&) {
    for (char& c : text) {
      if (static_cast<unsigned char>(c) >= 0x80) c = '?';
    }
    return text;
  }
}

class Reader {
 public:
  /// `limits` null: anything goes that keeps to the schema.
  Reader(Bytes bytes, std::string_view type, const Schema& schema, const Limits* limits)
      : bytes_(bytes), schema_(schema), type_(type), limits_(limits) {}

  Json Read() {
    if (limits_ != nullptr && bytes_.size() > limits_->bytes) {
      Throw<ProtocolError>("{}: {} bytes long, at most {} are taken", type_, bytes_.size(),
                           limits_->bytes);
    }
    const std::uint64_t wanted = schema_.Fingerprint(type_);
    const std::uint64_t found = Unsigned(8);
    if (found != wanted) {
      Throw<ProtocolError>("{}: fingerprint {:016x}, expected {:016x}: another type or version",
                           type_, found, wanted);
    }
    Json json = ReadStruct(schema_.Of(type_));
    if (at_ != bytes_.size()) {
      Throw<ProtocolError>("{}: {} bytes left over at the end", type_, bytes_.size() - at_);
    }
    return json;
  }

 private:
  std::int64_t Remaining() const { return static_cast<std::int64_t>(bytes_.size() - at_); }

  Bytes Take(std::int64_t n) {
    if (n > Remaining()) {
      Throw<ProtocolError>("{}: cut off in '{}' at byte {}", type_, field_, bytes_.size());
    }
    const Bytes taken = bytes_.subspan(at_, static_cast<std::size_t>(n));
    at_ += static_cast<std::size_t>(n);
    return taken;
  }

  std::uint64_t Unsigned(int n) {
    std::uint64_t value = 0;
    for (const std::uint8_t byte : Take(n)) value = value << 8 | byte;
    return value;
  }

  Json Number(double value) const {
    if (std::isfinite(value)) return value;
    if (limits_ != nullptr) Throw<ProtocolError>("{}: '{}' is not finite", type_, field_);
    return nullptr;
  }

  Json ReadPrimitive(const std::string& type) {
    if (type == "boolean") return Unsigned(1) != 0;
    if (type == "byte") return Unsigned(1);
    if (type == "int8_t") return static_cast<std::int8_t>(Unsigned(1));
    if (type == "int16_t") return static_cast<std::int16_t>(Unsigned(2));
    if (type == "int32_t") return static_cast<std::int32_t>(Unsigned(4));
    if (type == "int64_t") return static_cast<std::int64_t>(Unsigned(8));
    if (type == "float") return Number(std::bit_cast<float>(std::uint32_t(Unsigned(4))));
    if (type == "double") return Number(std::bit_cast<double>(Unsigned(8)));
    return ReadString();
  }

  Json ReadString() {
    const auto length = static_cast<std::int32_t>(Unsigned(4));  // with the final NUL
    if (length < 1) Throw<ProtocolError>("{}: '{}' has length {}", type_, field_, length);
    const Bytes text = Take(length);
    if (text.back() != 0) Throw<ProtocolError>("{}: '{}' does not end with NUL", type_, field_);
    const std::string given(text.begin(), text.end() - 1);
    std::string mended = MendedUtf8(given);
    if (limits_ != nullptr) RequirePlain(given, mended);
    return mended;
  }

  void RequirePlain(const std::string& text, const std::string& mended) const {
    if (std::ssize(text) > limits_->characters) {
      Throw<ProtocolError>("{}: '{}' has {} characters, at most {} are taken", type_, field_,
                           text.size(), limits_->characters);
    }
    const auto controls = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
    if (mended != text || std::any_of(text.begin(), text.end(), controls)) {
      Throw<ProtocolError>("{}: '{}' is not UTF-8 or has control characters", type_, field_);
    }
  }

  Json ReadStruct(const Struct& s) {
    Json json = Json::object();
    std::vector<std::pair<std::string_view, std::int64_t>> counts;
    for (const Field& field : s.fields) {
      field_ = field.name;
      std::vector<std::int64_t> sizes;
      for (const Dimension& d : field.dimensions) {
        sizes.push_back(d.field.empty() ? d.size : CountOf(counts, d.field));
      }
      json[field.name] = ReadArray(field.type, sizes);
      if (json[field.name].is_number_integer()) {
        counts.emplace_back(field.name, json[field.name].get<std::int64_t>());
      }
    }
    return json;
  }

  std::int64_t CountOf(const std::vector<std::pair<std::string_view, std::int64_t>>& counts,
                       const std::string& field) const {
    for (const auto& [name, count] : counts) {
      if (name != field) continue;
      if (count < 0) Throw<ProtocolError>("{}: '{}' is {}, a count", type_, field, count);
      return count;
    }
    Throw<ProtocolError>("{}: '{}' is no count", type_, field);
  }

  /// A value of the type, or nested arrays of it with these sizes.
  Json ReadArray(const std::string& type, std::span<const std::int64_t> sizes) {
    if (sizes.empty()) {
      return Schema::IsPrimitive(type) ? ReadPrimitive(type) : ReadStruct(schema_.Of(type));
    }
    const std::int64_t n = sizes.front();
    const std::span<const std::int64_t> inner = sizes.subspan(1);
    std::int64_t each = schema_.MinBytes(type);
    for (const std::int64_t size : inner) each *= std::max<std::int64_t>(size, 1);
    if (n > Remaining() / each) {
      Throw<ProtocolError>("{}: '{}' would have {} values, more than the {} bytes left can hold",
                           type_, field_, n, Remaining());
    }
    const bool data = type == "byte" && inner.empty();
    if (limits_ != nullptr && n > (data ? limits_->data : limits_->values)) {
      Throw<ProtocolError>("{}: '{}' has {} {}, at most {} are taken", type_, field_, n,
                           data ? "bytes" : "values", data ? limits_->data : limits_->values);
    }
    if (data) return ToBase64(Take(n));
    Json json = Json::array();
    for (std::int64_t i = 0; i < n; ++i) json.push_back(ReadArray(type, inner));
    return json;
  }

  Bytes bytes_;
  const Schema& schema_;
  std::string type_;
  const Limits* limits_;
  std::string field_{"fingerprint"};
  std::size_t at_{};
};

}  // namespace

nlohmann::ordered_json ToJson(std::span<const std::uint8_t> bytes, std::string_view type,
                              const Schema& schema) {
  return Reader(bytes, type, schema, nullptr).Read();
}

void Check(std::span<const std::uint8_t> bytes, std::string_view type, const Schema& schema) {
  (void)ToJson(bytes, type, schema);
}

void Check(std::span<const std::uint8_t> bytes, std::string_view type, const Limits& limits,
           const Schema& schema) {
  (void)Reader(bytes, type, schema, &limits).Read();
}

}  // namespace secondlook::transport

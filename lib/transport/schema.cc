#include "lib/transport/schema.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <set>

#include "lib/common/error.h"
#include "lib/transport/message_text.h"

namespace secondlook::transport {
namespace {

struct Primitive {
  std::string_view name;
  std::int64_t bytes;  // of the shortest value
};

constexpr std::array<Primitive, 9> kPrimitives{{{"boolean", 1},
                                                {"byte", 1},
                                                {"int8_t", 1},
                                                {"int16_t", 2},
                                                {"int32_t", 4},
                                                {"int64_t", 8},
                                                {"float", 4},
                                                {"double", 8},
                                                {"string", 5}}};  // length and final NUL

/// Words and punctuation, without comments.
class Tokens {
 public:
  explicit Tokens(std::string_view text) : text_(text) { Advance(); }

  bool AtEnd() const { return token_.empty(); }
  std::string_view Peek() const { return token_; }

  std::string Take() {
    if (AtEnd()) Fail("something more");
    std::string taken(token_);
    Advance();
    return taken;
  }

  bool TakeIf(std::string_view wanted) {
    if (token_ != wanted) return false;
    Advance();
    return true;
  }

  void Expect(std::string_view wanted) {
    if (!TakeIf(wanted)) Fail("'" + std::string(wanted) + "'");
  }

  [[noreturn]] void Fail(const std::string& wanted) const {
    Throw<InvalidArgument>("line {}: expected {}, found '{}'", line_, wanted, token_);
  }

 private:
  static bool IsWord(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-' ||
           c == '+';
  }

  void SkipSpaceAndComments() {
    while (at_ < text_.size()) {
      if (text_.substr(at_, 2) == "//") {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (text_.substr(at_, 2) == "/*") {
        const std::size_t end = std::min(text_.find("*/", at_ + 2), text_.size() - 2) + 2;
        line_ += std::count(text_.begin() + at_, text_.begin() + end, '\n');
        at_ = end;
      } else if (std::isspace(static_cast<unsigned char>(text_[at_])) != 0) {
        if (text_[at_] == '\n') ++line_;
        ++at_;
      } else {
        return;
      }
    }
  }

  void Advance() {
    SkipSpaceAndComments();
    std::size_t end = at_;
    while (end < text_.size() && IsWord(text_[end])) ++end;
    if (end == at_ && end < text_.size()) ++end;
    token_ = text_.substr(at_, end - at_);
    at_ = end;
  }

  std::string_view text_;
  std::string_view token_;
  std::size_t at_{};
  int line_{1};
};

Dimension ParseDimension(const std::string& token) {
  Dimension dimension;
  const auto [end, error] =
      std::from_chars(token.data(), token.data() + token.size(), dimension.size);
  if (error != std::errc{} || end != token.data() + token.size()) dimension.field = token;
  return dimension;
}

void SkipConstants(Tokens* tokens) {
  while (!tokens->TakeIf(";")) tokens->Take();
}

Struct ParseStruct(const std::string& package, Tokens* tokens) {
  Struct result;
  tokens->Expect("{");
  while (!tokens->TakeIf("}")) {
    if (tokens->TakeIf("const")) {
      SkipConstants(tokens);
      continue;
    }
    std::string type = tokens->Take();
    if (!Schema::IsPrimitive(type) && type.find('.') == std::string::npos) {
      type.insert(0, package + ".");
    }
    do {
      Field field{tokens->Take(), type, {}};
      while (tokens->TakeIf("[")) {
        field.dimensions.push_back(ParseDimension(tokens->Take()));
        tokens->Expect("]");
      }
      result.fields.push_back(std::move(field));
    } while (tokens->TakeIf(","));
    tokens->Expect(";");
  }
  return result;
}

// LCM's hash, as lcm-gen computes it: on signed numbers, so that the shift to the right keeps the
// sign.
std::uint64_t Mix(std::uint64_t hash, char c) {
  const auto high = static_cast<std::uint64_t>(static_cast<std::int64_t>(hash) >> 55);
  return ((hash << 8) ^ high) + static_cast<std::uint64_t>(static_cast<std::int64_t>(c));
}

std::uint64_t Mix(std::uint64_t hash, std::string_view text) {
  hash = Mix(hash, static_cast<char>(text.size()));
  for (const char c : text) hash = Mix(hash, c);
  return hash;
}

}  // namespace

const Schema& Schema::Messages() {
  static const Schema schema(MessageText());
  return schema;
}

Schema::Schema(const std::vector<std::string_view>& texts) {
  for (const std::string_view text : texts) {
    Tokens tokens(text);
    std::string package;
    while (!tokens.AtEnd()) {
      if (tokens.TakeIf("package")) {
        package = tokens.Take();
        tokens.Expect(";");
        continue;
      }
      tokens.Expect("struct");
      std::string name = package + "." + tokens.Take();
      structs_[name] = ParseStruct(package, &tokens);
    }
  }
}

const Struct& Schema::Of(std::string_view type) const {
  const auto found = structs_.find(type);
  if (found == structs_.end()) Throw<InvalidArgument>("there is no message type '{}'", type);
  return found->second;
}

bool Schema::IsPrimitive(std::string_view type) {
  return std::any_of(kPrimitives.begin(), kPrimitives.end(),
                     [&](const Primitive& p) { return p.name == type; });
}

std::uint64_t Schema::BaseHash(const Struct& s) const {
  std::uint64_t hash = 0x12345678;
  for (const Field& field : s.fields) {
    hash = Mix(hash, field.name);
    if (IsPrimitive(field.type)) hash = Mix(hash, field.type);
    hash = Mix(hash, static_cast<char>(field.dimensions.size()));
    for (const Dimension& d : field.dimensions) {
      hash = Mix(hash, static_cast<char>(d.field.empty() ? 0 : 1));
      hash = Mix(hash, d.field.empty() ? std::to_string(d.size) : d.field);
    }
  }
  return hash;
}

/// A struct's own hash plus those of its members, turned left by one bit at each level.
std::uint64_t Schema::HashWithMembers(const std::string& type,
                                      std::vector<std::string> parents) const {
  if (std::find(parents.begin(), parents.end(), type) != parents.end()) return 0;
  parents.push_back(type);
  const Struct& s = Of(type);
  std::uint64_t hash = BaseHash(s);
  for (const Field& field : s.fields) {
    if (!IsPrimitive(field.type)) hash += HashWithMembers(field.type, parents);
  }
  return (hash << 1) + (hash >> 63);
}

std::uint64_t Schema::Fingerprint(std::string_view type) const {
  return HashWithMembers(std::string(type), {});
}

std::int64_t Schema::MinBytes(std::string_view type) const {
  for (const Primitive& p : kPrimitives) {
    if (p.name == type) return p.bytes;
  }
  std::int64_t bytes = 0;
  for (const Field& field : Of(type).fields) {
    std::int64_t values = 1;
    for (const Dimension& d : field.dimensions) values *= d.field.empty() ? d.size : 0;
    if (values > 0) bytes += values * MinBytes(field.type);
  }
  return std::max<std::int64_t>(bytes, 1);
}

}  // namespace secondlook::transport

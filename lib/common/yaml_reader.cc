#include "lib/common/yaml_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "lib/common/files.h"

namespace secondlook {
namespace {

std::string Place(const std::string& source, const YAML::Mark& mark) {
  if (mark.is_null()) return source + ": ";
  return fmt::format("{}:{}:{}: ", source, mark.line + 1, mark.column + 1);
}

template <class T>
bool ParseWhole(const std::string& text, T* value) {
  const char* first = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* last = text.data() + text.size();
  const auto result = std::from_chars(first, last, *value);
  return result.ec == std::errc() && result.ptr == last;
}

}  // namespace

YamlReader::YamlReader(YAML::Node node, std::string source, std::string path)
    : node_(std::move(node)), source_(std::move(source)), path_(std::move(path)) {}

void YamlReader::Finish() const {
  for (const auto& entry : node_) {
    const std::string key = entry.first.Scalar();
    if (std::find(visited_.begin(), visited_.end(), key) != visited_.end()) continue;
    std::string known;
    for (const std::string& name : visited_) known += (known.empty() ? "" : ", ") + name;
    Throw<ConfigError>("{}unknown key '{}'; known here: {}", Place(source_, entry.first.Mark()),
                       path_.empty() ? key : path_ + "." + key, known);
  }
}

void YamlReader::Fail(const std::string& message) const {
  throw ConfigError(Place(source_, node_.Mark()) + message);
}

void YamlReader::Read(bool* value) const {
  const std::string text = node_.IsScalar() ? node_.Scalar() : "";
  if (text != "true" && text != "false") {
    Fail(fmt::format("'{}' must be true or false", path_));
  }
  *value = text == "true";
}

void YamlReader::Read(int* value) const {
  if (!node_.IsScalar() || !ParseWhole(node_.Scalar(), value)) {
    Fail(fmt::format("'{}' must be a whole number", path_));
  }
}

void YamlReader::Read(std::uint64_t* value) const {
  if (!node_.IsScalar() || !ParseWhole(node_.Scalar(), value)) {
    Fail(fmt::format("'{}' must be a whole number that is not negative", path_));
  }
}

void YamlReader::Read(double* value) const {
  if (!node_.IsScalar() || !ParseWhole(node_.Scalar(), value) || !std::isfinite(*value)) {
    Fail(fmt::format("'{}' must be a finite number", path_));
  }
}

void YamlReader::Read(std::string* value) const {
  if (!node_.IsScalar()) Fail(fmt::format("'{}' must be text", path_));
  *value = node_.Scalar();
}

std::vector<YamlReader> YamlReader::Elements(std::size_t size) const {
  if (!node_.IsSequence() || (size != 0 && node_.size() != size)) {
    Fail(size == 0 ? fmt::format("'{}' must be a list", path_)
                   : fmt::format("'{}' must be a list of {} values", path_, size));
  }
  std::vector<YamlReader> elements;
  for (std::size_t i = 0; i < node_.size(); ++i) {
    elements.emplace_back(node_[i], source_, fmt::format("{}[{}]", path_, i));
  }
  return elements;
}

std::vector<std::pair<std::string, YamlReader>> YamlReader::Entries() const {
  if (!node_.IsMap()) {
    Fail(fmt::format("'{}' must be a map of keys to values", path_.empty() ? "the file" : path_));
  }
  std::vector<std::pair<std::string, YamlReader>> entries;
  for (const auto& entry : node_) {
    const std::string key = entry.first.Scalar();
    if (std::any_of(entries.begin(), entries.end(),
                    [&](const auto& other) { return other.first == key; })) {
      Throw<ConfigError>("{}key '{}' stands here twice", Place(source_, entry.first.Mark()), key);
    }
    entries.emplace_back(
        key, YamlReader(entry.second, source_, path_.empty() ? key : path_ + "." + key));
  }
  return entries;
}

std::string YamlReader::TagName() const {
  const std::string& tag = node_.Tag();
  if (tag == "?" || tag == "!" || tag.starts_with("tag:yaml.org")) return "";
  return tag.starts_with('!') ? tag.substr(1) : tag;
}

void YamlWriter::Write(double value) {
  // The shortest text that reads back as the same number.
  char text[32];
  const auto end = std::to_chars(text, text + sizeof(text), value).ptr;
  out_ << std::string(text, end);
}

std::string YamlWriter::Finish() {
  out_ << YAML::EndMap;
  return std::string(out_.c_str()) + "\n";
}

YamlLayer ReadYamlFile(const std::filesystem::path& path) {
  return ParseYaml(ReadFile(path), path.string());
}

YamlLayer ParseYaml(const std::string& text, const std::string& source) {
  try {
    YAML::Node node = YAML::Load(text);
    if (node.IsNull()) node = YAML::Node(YAML::NodeType::Map);
    return {node, source};
  } catch (const YAML::ParserException& error) {
    throw ConfigError(Place(source, error.mark) + error.msg);
  }
}

YamlLayer ParseOverride(const std::string& key_value) {
  const std::string source = "--set " + key_value;
  const std::size_t equals = key_value.find('=');
  if (equals == std::string::npos || equals == 0) {
    Throw<ConfigError>("{}: must be KEY=VALUE, e.g. --set seed=7", source);
  }
  YAML::Node node;
  try {
    node = YAML::Load(key_value.substr(equals + 1));
  } catch (const YAML::ParserException& error) {
    Throw<ConfigError>("{}: {}", source, error.msg);
  }
  std::string path = key_value.substr(0, equals);
  while (!path.empty()) {
    const std::size_t dot = path.rfind('.');
    const std::string key = dot == std::string::npos ? path : path.substr(dot + 1);
    if (key.empty()) Throw<ConfigError>("{}: the key has an empty part", source);
    YAML::Node parent(YAML::NodeType::Map);
    parent[key] = node;
    node = parent;
    path = dot == std::string::npos ? "" : path.substr(0, dot);
  }
  return {node, source};
}

}  // namespace secondlook

#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <yaml-cpp/yaml.h>
#include <Eigen/Core>

#include "lib/common/error.h"

namespace secondlook {

class YamlReader;
class YamlWriter;

/// A plain struct that lists its fields: `template <class A> void Serialize(A* a) { a->Visit("fps",
/// &fps); … }`. Its defaults stand in the struct; a key that is missing keeps them.
template <class T>
concept Serializable = requires(T t, YamlReader* reader) {
  t.Serialize(reader);
};

/// A Serializable whose values can be wrong together: Validate() throws ConfigError. It is called
/// after reading, and the message gets the place put in front.
template <class T>
concept Validated = requires(const T t) {
  t.Validate();
};

/// Reads YAML into structs, strictly: an unknown key, a wrong type and a wrong tag are ConfigErrors
/// that begin with `file:line:col:` and name the key by its path. The alternative of a std::variant
/// is chosen by a tag (`camera: !Sim {…}`), which is the alternative's `static constexpr const
/// char* kTag`.
class YamlReader {
 public:
  /// Reads `node`, which messages call `source` (a file name, or "--set …") and `path` ("" at the
  /// root).
  YamlReader(YAML::Node node, std::string source, std::string path);

  /// Reads the key `name` into `*value`, or leaves it when the key is missing.
  template <class T>
  void Visit(const char* name, T* value);

  /// @throws ConfigError when the node has a key that was not visited.
  void Finish() const;

  /// Throws a ConfigError that begins with the place of this node.
  [[noreturn]] void Fail(const std::string& message) const;

  // How each kind of value is read.
  void Read(bool* value) const;
  void Read(int* value) const;
  void Read(std::uint64_t* value) const;
  void Read(double* value) const;
  void Read(std::string* value) const;
  template <int N>
  void Read(Eigen::Matrix<double, N, 1>* value) const;
  template <class T>
  void Read(std::vector<T>* value) const;
  template <class T>
  void Read(std::map<std::string, T>* value) const;
  template <class T>
  void Read(std::optional<T>* value) const;
  template <class... Ts>
  void Read(std::variant<Ts...>* value) const;
  template <Serializable T>
  void Read(T* value) const;

 private:
  /// The readers of the elements of this node, which must be a sequence of `size` (any when 0).
  std::vector<YamlReader> Elements(std::size_t size) const;
  /// The readers of the values of this node, which must be a map, by key.
  std::vector<std::pair<std::string, YamlReader>> Entries() const;
  std::string TagName() const;
  /// True for `key:` and `key: !Tag` with nothing behind.
  bool IsEmpty() const { return node_.IsNull() || (node_.IsScalar() && node_.Scalar().empty()); }

  YAML::Node node_;
  std::string source_;
  std::string path_;
  std::vector<std::string> visited_;
};

/// Writes structs as YAML that YamlReader reads back to the same values.
class YamlWriter {
 public:
  YamlWriter() { out_ << YAML::BeginMap; }

  template <class T>
  void Visit(const char* name, const T* value) {
    out_ << YAML::Key << name << YAML::Value;
    Write(*value);
  }

  /// Ends the document and returns it.
  std::string Finish();

 private:
  void Write(bool value) { out_ << value; }
  void Write(int value) { out_ << value; }
  void Write(std::uint64_t value) { out_ << value; }
  void Write(double value);
  void Write(const std::string& value) { out_ << YAML::DoubleQuoted << value; }
  template <int N>
  void Write(const Eigen::Matrix<double, N, 1>& value);
  template <class T>
  void Write(const std::vector<T>& value);
  template <class T>
  void Write(const std::map<std::string, T>& value);
  template <class T>
  void Write(const std::optional<T>& value);
  template <class... Ts>
  void Write(const std::variant<Ts...>& value);
  template <Serializable T>
  void Write(const T& value);

  YAML::Emitter out_;
};

/// One layer of values: a file, or a `KEY=VALUE` override.
struct YamlLayer {
  YAML::Node node;
  std::string source;  ///< What messages call it.
};

/// Parses the file `path`. @throws ConfigError for a missing file or bad YAML, with its place.
YamlLayer ReadYamlFile(const std::filesystem::path& path);

/// Parses `text`, which messages call `source`. @throws ConfigError for bad YAML, with its place.
YamlLayer ParseYaml(const std::string& text, const std::string& source);

/// Parses `KEY=VALUE`, KEY a dotted path ("robot.camera.fps") and VALUE YAML, into the layer
/// {robot: {camera: {fps: VALUE}}}. @throws ConfigError when it is not of that form.
YamlLayer ParseOverride(const std::string& key_value);

/// Reads the layer over `*value`. @throws ConfigError as YamlReader does.
template <Serializable T>
void ApplyLayer(const YamlLayer& layer, T* value) {
  YamlReader(layer.node, layer.source, "").Read(value);
}

/// The struct with all its values, as YAML.
template <Serializable T>
std::string ToYaml(const T& value) {
  YamlWriter writer;
  const_cast<T&>(value).Serialize(&writer);  // Serialize() is shared with reading; it only reads
  return writer.Finish();
}

// ---------------------------------------------------------------------------------------------

template <class T>
void YamlReader::Visit(const char* name, T* value) {
  visited_.emplace_back(name);
  const YAML::Node child = node_[name];
  if (!child) return;
  YamlReader(child, source_, path_.empty() ? name : path_ + "." + name).Read(value);
}

template <int N>
void YamlReader::Read(Eigen::Matrix<double, N, 1>* value) const {
  const std::vector<YamlReader> elements = Elements(N);
  for (int i = 0; i < N; ++i) elements[i].Read(&(*value)[i]);
}

template <class T>
void YamlReader::Read(std::vector<T>* value) const {
  value->clear();
  for (const YamlReader& element : Elements(0)) {
    T item{};
    element.Read(&item);
    value->push_back(std::move(item));
  }
}

template <class T>
void YamlReader::Read(std::map<std::string, T>* value) const {
  for (const auto& [key, entry] : Entries()) entry.Read(&(*value)[key]);
}

template <class T>
void YamlReader::Read(std::optional<T>* value) const {
  if (node_.IsNull()) {
    value->reset();
    return;
  }
  if (!*value) value->emplace();
  Read(&**value);
}

template <class... Ts>
void YamlReader::Read(std::variant<Ts...>* value) const {
  const std::string tag = TagName();
  if (!tag.empty()) {
    const bool known = ((tag == Ts::kTag ? (value->template emplace<Ts>(), true) : false) || ...);
    if (!known) {
      std::string expected;
      ((expected += std::string(" !") + Ts::kTag), ...);
      Fail(fmt::format("'{}' has tag '!{}'; expected one of{}", path_, tag, expected));
    }
  }
  std::visit([this](auto& alternative) { Read(&alternative); }, *value);
}

template <Serializable T>
void YamlReader::Read(T* value) const {
  if (IsEmpty()) return;  // `camera: !Sim` with nothing behind it: all defaults
  YamlReader fields = *this;
  fields.Entries();  // throws unless it is a map
  value->Serialize(&fields);
  fields.Finish();
  if constexpr (Validated<T>) {
    try {
      value->Validate();
    } catch (const ConfigError& error) {
      Fail(error.what());
    }
  }
}

template <int N>
void YamlWriter::Write(const Eigen::Matrix<double, N, 1>& value) {
  out_ << YAML::Flow << YAML::BeginSeq;
  for (int i = 0; i < N; ++i) Write(value[i]);
  out_ << YAML::EndSeq;
}

template <class T>
void YamlWriter::Write(const std::vector<T>& value) {
  if (value.empty() || !Serializable<T>) out_ << YAML::Flow;
  out_ << YAML::BeginSeq;
  for (const T& item : value) Write(item);
  out_ << YAML::EndSeq;
}

template <class T>
void YamlWriter::Write(const std::map<std::string, T>& value) {
  if (value.empty()) out_ << YAML::Flow;
  out_ << YAML::BeginMap;
  for (const auto& [key, item] : value) Visit(key.c_str(), &item);
  out_ << YAML::EndMap;
}

template <class T>
void YamlWriter::Write(const std::optional<T>& value) {
  if (value) {
    Write(*value);
  } else {
    out_ << YAML::Null;
  }
}

template <class... Ts>
void YamlWriter::Write(const std::variant<Ts...>& value) {
  std::visit(
      [this]<class T>(const T& alternative) {
        out_ << YAML::LocalTag(T::kTag);
        Write(alternative);
      },
      value);
}

template <Serializable T>
void YamlWriter::Write(const T& value) {
  out_ << YAML::BeginMap;
  const_cast<T&>(value).Serialize(this);  // shared with reading; it only reads here
  out_ << YAML::EndMap;
}

}  // namespace secondlook

#include "lib/geometry/pcd.h"

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>

#include "lib/common/error.h"
#include "lib/common/files.h"

namespace secondlook::geometry {
namespace {

constexpr std::size_t kMaxPoints = 16'000'000;

/// One column of the file.
struct Field {
  std::string name;
  std::size_t size{4};   ///< Bytes of one value.
  std::size_t count{1};  ///< Values per point.
  char type{'F'};
};

struct Header {
  std::vector<Field> fields;
  std::size_t width{};
  std::size_t height{};
  std::string data;          ///< ascii, binary or binary_compressed.
  std::size_t data_begin{};  ///< Offset of the first byte after the header.

  std::size_t points() const { return width * height; }
  std::size_t point_size() const {
    std::size_t size = 0;
    for (const Field& field : fields) size += field.size * field.count;
    return size;
  }
};

class PcdFile {
 public:
  explicit PcdFile(const std::filesystem::path& path)
      : name_(path.string()), content_(ReadFile(path)) {}

  LabelledCloud Read(bool with_labels) {
    ReadHeader();
    LabelledCloud result{{static_cast<int>(header_.width), static_cast<int>(header_.height), {}},
                         {}};
    const auto read_binary = [&](std::string_view bytes, bool by_column) {
      result.cloud.points_C = ReadBinary(bytes, by_column);
      if (with_labels) result.labels = ReadBinaryLabels(bytes, by_column);
    };
    if (header_.data == "ascii") {
      result.cloud.points_C = ReadAscii();
      if (with_labels) Fail("labels are read from DATA binary and binary_compressed only");
    } else if (header_.data == "binary") {
      read_binary(Rest(), false);
    } else if (header_.data == "binary_compressed") {
      read_binary(Decompress(), true);
    } else {
      Fail("its DATA is '" + header_.data + "'; ascii, binary and binary_compressed are known");
    }
    return result;
  }

 private:
  [[noreturn]] void Fail(const std::string& why) const {
    Throw<ConfigError>("{}: no usable point cloud: {}", name_, why);
  }

  std::string_view Rest() const { return std::string_view(content_).substr(header_.data_begin); }

  void ReadHeader() {
    std::size_t begin = 0;
    while (header_.data.empty()) {
      const std::size_t end = content_.find('\n', begin);
      if (end == std::string::npos || end > 65536) Fail("it has no PCD header");
      std::istringstream line(content_.substr(begin, end - begin));
      begin = end + 1;
      std::string key;
      line >> key;
      if (key == "FIELDS") {
        for (std::string name; line >> name;) header_.fields.push_back({name});
      } else if (key == "SIZE") {
        for (Field& field : header_.fields) line >> field.size;
      } else if (key == "TYPE") {
        for (Field& field : header_.fields) line >> field.type;
      } else if (key == "COUNT") {
        for (Field& field : header_.fields) line >> field.count;
      } else if (key == "WIDTH") {
        line >> header_.width;
      } else if (key == "HEIGHT") {
        line >> header_.height;
      } else if (key == "DATA") {
        line >> header_.data;
      }
      if (line.fail() && !line.eof()) Fail("the values of '" + key + "' cannot be read");
    }
    header_.data_begin = begin;
    if (header_.width > kMaxPoints || header_.height > kMaxPoints || header_.points() == 0 ||
        header_.points() > kMaxPoints) {
      Fail(fmt::format("it has {} x {} points; 1 to {} are accepted", header_.width, header_.height,
                       kMaxPoints));
    }
    for (const Field& field : header_.fields) {
      if (field.size > 8 || field.count > 4096) Fail("its field '" + field.name + "' is too large");
    }
  }

  std::size_t FindField(const std::string& name) const {
    for (std::size_t i = 0; i < header_.fields.size(); ++i) {
      if (header_.fields[i].name == name) return i;
    }
    Fail("it has no field '" + name + "'");
  }

  /// Index of the field of that name, a float of 4 or 8 bytes.
  std::size_t FindFloat(const std::string& name) const {
    const std::size_t i = FindField(name);
    const Field& field = header_.fields[i];
    if (field.type != 'F' || (field.size != 4 && field.size != 8) || field.count != 1) {
      Fail("its field '" + name + "' is not one float");
    }
    return i;
  }

  /// Where the values of one field stand in the data.
  struct Column {
    std::size_t offset{};
    std::size_t stride{};
    std::size_t size{};
  };

  Column ColumnOf(std::size_t index, bool by_column) const {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < index; ++i) {
      offset += header_.fields[i].size * header_.fields[i].count;
    }
    const std::size_t size = header_.fields[index].size;
    return by_column ? Column{offset * header_.points(), size, size}
                     : Column{offset, header_.point_size(), size};
  }

  static Eigen::Vector3f OrNone(const Eigen::Vector3f& p) {
    const bool is_measured = p.allFinite() && !p.isZero();
    return is_measured ? p : Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  }

  std::vector<Eigen::Vector3f> ReadAscii() const {
    std::array<std::size_t, 3> columns{};
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t index = FindFloat(std::string(1, static_cast<char>('x' + axis)));
      for (std::size_t i = 0; i < index; ++i) columns[axis] += header_.fields[i].count;
    }
    std::size_t values_per_point = 0;
    for (const Field& field : header_.fields) values_per_point += field.count;
    std::istringstream in(content_.substr(header_.data_begin));
    std::vector<Eigen::Vector3f> points;
    std::vector<float> values(values_per_point);
    for (std::size_t n = 0; n < header_.points(); ++n) {
      for (float& value : values) {
        std::string text;  // not read as a float: the stream does not know "nan"
        if (!(in >> text)) Fail(fmt::format("it ends after {} points", n));
        value = std::strtof(text.c_str(), nullptr);
      }
      points.push_back(OrNone({values[columns[0]], values[columns[1]], values[columns[2]]}));
    }
    return points;
  }

  /// `by_column`: all values of the first field, then all of the second, and so on.
  std::vector<Eigen::Vector3f> ReadBinary(std::string_view bytes, bool by_column) const {
    const std::size_t n = header_.points();
    if (bytes.size() < n * header_.point_size()) {
      Fail(fmt::format("it holds {} bytes of data, {} points need {}", bytes.size(), n,
                       n * header_.point_size()));
    }
    std::array<Column, 3> columns;
    for (int axis = 0; axis < 3; ++axis) {
      columns[axis] = ColumnOf(FindFloat(std::string(1, static_cast<char>('x' + axis))), by_column);
    }
    std::vector<Eigen::Vector3f> points;
    points.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      Eigen::Vector3f p;
      for (int axis = 0; axis < 3; ++axis) {
        const char* at = bytes.data() + columns[axis].offset + i * columns[axis].stride;
        double wide = 0.0;
        float narrow = 0.0F;
        if (columns[axis].size == 8) {
          std::memcpy(&wide, at, 8);
          narrow = static_cast<float>(wide);
        } else {
          std::memcpy(&narrow, at, 4);
        }
        p[axis] = narrow;
      }
      points.push_back(OrNone(p));
    }
    return points;
  }

  /// @pre ReadBinary() has found the bytes complete.
  std::vector<std::uint32_t> ReadBinaryLabels(std::string_view bytes, bool by_column) const {
    const std::size_t index = FindField("label");
    const Field& field = header_.fields[index];
    if (field.type != 'U' || field.size != 4 || field.count != 1) {
      Fail("its field 'label' is not one unsigned integer of 4 bytes");
    }
    const Column column = ColumnOf(index, by_column);
    std::vector<std::uint32_t> labels(header_.points());
    for (std::size_t i = 0; i < labels.size(); ++i) {
      std::memcpy(&labels[i], bytes.data() + column.offset + i * column.stride, 4);
    }
    return labels;
  }

  /// The LZF block (M. Lehmann's LibLZF format) behind the two sizes, unpacked.
  std::string Decompress() const {
    const std::string_view rest = Rest();
    std::uint32_t packed_size = 0;
    std::uint32_t size = 0;
    if (rest.size() < 8) Fail("its compressed data is missing");
    std::memcpy(&packed_size, rest.data(), 4);
    std::memcpy(&size, rest.data() + 4, 4);
    if (rest.size() - 8 < packed_size) {
      Fail(fmt::format("it is truncated: {} of {} compressed bytes are there", rest.size() - 8,
                       packed_size));
    }
    if (size != header_.points() * header_.point_size()) {
      Fail(fmt::format("its compressed data unpacks to {} bytes, {} points need {}", size,
                       header_.points(), header_.points() * header_.point_size()));
    }
    const std::string_view in = rest.substr(8, packed_size);
    std::string out;
    out.reserve(size);
    std::size_t i = 0;
    const auto next = [&]() -> std::size_t {
      if (i >= in.size()) Fail("its compressed data ends too early");
      return static_cast<unsigned char>(in[i++]);
    };
    while (i < in.size()) {
      const std::size_t control = next();
      if (control < 32) {  // so many bytes, plus one, as they are
        if (in.size() - i < control + 1) Fail("its compressed data ends too early");
        out.append(in.substr(i, control + 1));
        i += control + 1;
      } else {  // a copy of what came before
        std::size_t length = control >> 5;
        if (length == 7) length += next();
        const std::size_t distance = ((control & 31) << 8) + next() + 1;
        if (distance > out.size()) Fail("its compressed data refers to before its beginning");
        for (std::size_t k = 0; k < length + 2; ++k) out.push_back(out[out.size() - distance]);
      }
      if (out.size() > size) Fail("its compressed data unpacks to more than it says");
    }
    return out;
  }

  std::string name_;
  std::string content_;
  Header header_;
};

}  // namespace

PointImage ReadPcd(const std::filesystem::path& file) { return PcdFile(file).Read(false).cloud; }

LabelledCloud ReadLabelledPcd(const std::filesystem::path& file) {
  return PcdFile(file).Read(true);
}

}  // namespace secondlook::geometry

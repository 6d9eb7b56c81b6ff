#include "lib/geometry/pcd.h"

#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/files.h"
#include "tests/support/expect_throws.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::geometry {
namespace {

std::string Header(const std::string& fields, const std::string& sizes, const std::string& types,
                   int width, int height, const std::string& data) {
  return fmt::format(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nWIDTH {}\nHEIGHT {}\nDATA {}\n",
      fields, sizes, types, width, height, data);
}

std::string Bytes(const std::vector<float>& values) {
  std::string bytes(values.size() * 4, '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

class ReadPcdTest : public testing::Test {
 protected:
  PointImage Read(const std::string& content) {
    WriteFile(folder_ / "cloud.pcd", content);
    return ReadPcd(folder_ / "cloud.pcd");
  }
  TemporaryFolder folder_;
};

TEST_F(ReadPcdTest, ReadsAsciiWithNanAsNone) {
  const PointImage image =
      Read(Header("label x y z", "4 4 4 4", "U F F F", 2, 1, "ascii") + "7 1 2 3\n8 nan nan nan\n");
  ASSERT_EQ(image.points_C.size(), 2U);
  EXPECT_EQ(image.points_C[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_FALSE(IsMeasured(image.points_C[1]));
}

TEST_F(ReadPcdTest, ReadsBinaryAndKeepsTheOrderOfTheImage) {
  const PointImage image =
      Read(Header("x y z", "4 4 4", "F F F", 1, 2, "binary") + Bytes({1, 2, 3, 4, 5, 6}));
  EXPECT_TRUE(image.organised());
  EXPECT_EQ(image.points_C[1], Eigen::Vector3f(4, 5, 6));
}

TEST_F(ReadPcdTest, UnpacksCompressedColumns) {
  // Two points by column: x x y y z z, as literals, then a copy: the two z are the two y.
  const std::string columns = Bytes({1, 4, 2, 5});
  std::string packed(1, static_cast<char>(columns.size() - 1));
  packed += columns;
  packed += static_cast<char>(6 << 5);  // 8 bytes from …
  packed += static_cast<char>(7);       // … 8 bytes back
  std::string sizes(8, '\0');
  const std::uint32_t packed_size = static_cast<std::uint32_t>(packed.size());
  const std::uint32_t size = 24;
  std::memcpy(sizes.data(), &packed_size, 4);
  std::memcpy(sizes.data() + 4, &size, 4);
  const std::string header = Header("x y z", "4 4 4", "F F F", 2, 1, "binary_compressed");
  const PointImage image = Read(header + sizes + packed);
  EXPECT_EQ(image.points_C[0], Eigen::Vector3f(1, 2, 2));
  EXPECT_EQ(image.points_C[1], Eigen::Vector3f(4, 5, 5));
  for (std::size_t cut = 0; cut < sizes.size() + packed.size(); ++cut) {
    EXPECT_THROW(Read(header + (sizes + packed).substr(0, cut)), ConfigError) << "cut at " << cut;
  }
}

TEST_F(ReadPcdTest, TakesTheOriginForNone) {
  const PointImage image =
      Read(Header("x y z", "4 4 4", "F F F", 2, 1, "binary") + Bytes({0, 0, 0, 0, 0, 1}));
  EXPECT_FALSE(IsMeasured(image.points_C[0]));
  EXPECT_TRUE(IsMeasured(image.points_C[1]));
}

TEST_F(ReadPcdTest, ReadsLabelsAndSaysWhyItCannot) {
  const auto read = [&](const std::string& content) {
    WriteFile(folder_ / "cloud.pcd", content);
    return ReadLabelledPcd(folder_ / "cloud.pcd");
  };
  const std::string points = Bytes({1, 2, 3}) + std::string("\x15\0\0\0", 4) + Bytes({4, 5, 6}) +
                             std::string("\0\1\0\0", 4);
  const LabelledCloud result =
      read(Header("x y z label", "4 4 4 4", "F F F U", 2, 1, "binary") + points);
  EXPECT_EQ(result.cloud.points_C[1], Eigen::Vector3f(4, 5, 6));
  EXPECT_EQ(result.labels, (std::vector<std::uint32_t>{21, 256}));
  EXPECT_THROWS(read(Header("x y z i", "4 4 4 4", "F F F U", 2, 1, "binary") + points), ConfigError,
                "it has no field 'label'");
  EXPECT_THROWS(read(Header("x y z label", "4 4 4 4", "F F F F", 2, 1, "binary") + points),
                ConfigError, "not one unsigned integer of 4 bytes");
  EXPECT_THROWS(read(Header("label x y z", "4 4 4 4", "U F F F", 1, 1, "ascii") + "7 1 2 3\n"),
                ConfigError, "labels are read from DATA binary");
}

TEST_F(ReadPcdTest, SaysWhatIsWrongWithTheFile) {
  EXPECT_THROWS(ReadPcd(folder_ / "none.pcd"), ConfigError, "none.pcd: cannot be read");
  EXPECT_THROWS(Read("ply\n"), ConfigError, "it has no PCD header");
  EXPECT_THROWS(Read(Header("x y", "4 4", "F F", 1, 1, "ascii") + "1 2\n"), ConfigError,
                "it has no field 'z'");
  EXPECT_THROWS(Read(Header("x y z", "4 4 4", "F F F", 3, 1, "ascii") + "1 2 3\n"), ConfigError,
                "it ends after 1 points");
  EXPECT_THROWS(Read(Header("x y z", "4 4 4", "F F F", 3, 1, "binary") + "abc"), ConfigError,
                "holds 3 bytes of data, 3 points need 36");
  EXPECT_THROWS(Read(Header("x y z", "4 4 4", "F F F", 0, 1, "binary")), ConfigError,
                "it has 0 x 1 points");
}

}  // namespace
}  // namespace secondlook::geometry

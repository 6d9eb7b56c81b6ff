#include "lib/common/deflate.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "lib/common/rng.h"
#include "tests/support/expect_throws.h"

namespace secondlook {
namespace {

TEST(Deflate, BringsAnyBytesBack) {
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(rng.Index(5000)));
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(rng.Index(i % 7 + 1));
    EXPECT_EQ(Inflate(Deflate(bytes), bytes.size()), bytes);
  }
}

TEST(Deflate, RefusesAStreamOfAnotherLengthOrNone) {
  const std::vector<std::uint8_t> bytes(100, 5);
  const std::vector<std::uint8_t> stream = Deflate(bytes);
  EXPECT_THROWS(Inflate(stream, 99), ProtocolError, "does not hold the 99 bytes");
  EXPECT_THROWS(Inflate(stream, 101), ProtocolError, "does not hold the 101 bytes");
  EXPECT_THROWS(Inflate(bytes, 100), ProtocolError, "a zlib stream of 100 bytes");
  EXPECT_THROWS(Inflate({}, 1), ProtocolError, "a zlib stream of 0 bytes");
}

}  // namespace
}  // namespace secondlook

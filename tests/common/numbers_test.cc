#include "lib/common/numbers.h"

#include <gtest/gtest.h>

namespace secondlook {
namespace {

using Numbers = std::vector<double>;

TEST(ParseNumbers, ReadsAListOfAnyLength) {
  EXPECT_EQ(ParseNumbers("0,-1,0.5"), (Numbers{0.0, -1.0, 0.5}));
  EXPECT_EQ(ParseNumbers("1e-4"), (Numbers{0.0001}));
}

TEST(ParseNumbers, RefusesWhatIsNoNumberAsAWhole) {
  for (const char* text : {"", ",", "1,", ",1", "1 2", "1,x", "1.5m", "nan", "inf", "+1", " 1"}) {
    EXPECT_FALSE(ParseNumbers(text).has_value()) << text;
  }
}

}  // namespace
}  // namespace secondlook

#include "lib/world/range_scan.h"

#include <gtest/gtest.h>

#include "lib/common/error.h"
#include "tests/support/expect_throws.h"

namespace secondlook::world {
namespace {

/// Two lines of two points and one.
RangeScan Scan() {
  RangeScan scan;
  scan.points_W = {{0.0, 0.0, 0.1}, {0.1, 0.0, 0.1}, {0.2, 0.0, 0.1}};
  scan.sigmas = {1e-4F, 1e-4F, 1e-4F};
  scan.lines = {{{0.0, 0.0, 0.5}, 2}, {{0.1, 0.0, 0.5}, 3}};
  return scan;
}

TEST(RangeScan, IsAcceptedWhenItsListsBelongTogether) {
  EXPECT_NO_THROW(Check(Scan()));
  EXPECT_NO_THROW(Check(RangeScan{}));
}

TEST(RangeScan, NamesWhatDoesNotBelongTogether) {
  RangeScan scan = Scan();
  scan.sigmas.pop_back();
  EXPECT_THROWS(Check(scan), InvalidArgument, "2 sigmas for 3 points");

  scan = Scan();
  scan.colors.resize(1);
  EXPECT_THROWS(Check(scan), InvalidArgument, "1 colours for 3 points");

  scan = Scan();
  scan.sigmas[1] = 0.0F;
  EXPECT_THROWS(Check(scan), InvalidArgument, "point 1 at (0.1, 0, 0.1) m");

  scan = Scan();
  scan.lines[1].end = 1;
  EXPECT_THROWS(Check(scan), InvalidArgument, "ends at point 1, the one before at 2");

  scan = Scan();
  scan.lines.pop_back();
  EXPECT_THROWS(Check(scan), InvalidArgument, "end at point 2, but it has 3");

  scan = Scan();
  scan.rotation_sigma = -1.0;
  EXPECT_THROWS(Check(scan), InvalidArgument, "sigmas of 0 m and -1 rad");
}

}  // namespace
}  // namespace secondlook::world

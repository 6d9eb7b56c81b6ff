#include "lib/transport/json_difference.h"

#include <gtest/gtest.h>

namespace secondlook::transport {
namespace {

using Json = nlohmann::ordered_json;

const Json kObjects = Json::parse(R"({"step": 3, "objects": [{"id": 0}, {"id": 2, "x": [1, 2]}]})");

TEST(FirstDifference, BetweenTheSameIsNone) { EXPECT_FALSE(FirstDifference(kObjects, kObjects)); }

TEST(FirstDifference, NamesTheFieldByItsPathAndWhatStandsThere) {
  Json other = kObjects;
  other["objects"][1]["x"][0] = 1.5;
  other["objects"][1]["x"][1] = 7;
  const auto difference = FirstDifference(kObjects, other);
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->path, "objects[1].x[0]");
  EXPECT_EQ(difference->a, "1");
  EXPECT_EQ(difference->b, "1.5");
}

TEST(FirstDifference, ShowsWhatIsMissingOnEitherSide) {
  Json shorter = kObjects;
  shorter["objects"].erase(1);
  EXPECT_EQ(FirstDifference(kObjects, shorter)->path, "objects[1]");
  EXPECT_EQ(FirstDifference(kObjects, shorter)->b, "nothing");
  EXPECT_EQ(FirstDifference(shorter, kObjects)->a, "nothing");
}

TEST(FirstDifference, ShortensLongValues) {
  const auto difference = FirstDifference({{"data", std::string(5000, 'a')}}, {{"data", "b"}});
  EXPECT_LE(difference->a.size(), 130U);
  EXPECT_TRUE(difference->a.ends_with("..."));
}

TEST(FirstDifference, BetweenOtherTypesIsTheValueItself) {
  EXPECT_EQ(FirstDifference({{"a", 1}}, {{"a", {{"b", 1}}}})->path, "a");
}

}  // namespace
}  // namespace secondlook::transport

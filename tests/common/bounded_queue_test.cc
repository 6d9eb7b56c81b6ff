#include "lib/common/bounded_queue.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/expect_throws.h"

namespace secondlook {
namespace {

TEST(BoundedQueue, HandsOnAllInOrderOnce) {
  BoundedQueue<int> queue(3);
  for (const int value : {7, 5, 9}) queue.Push(value);
  EXPECT_EQ(queue.TakeAll(), (std::vector<int>{7, 5, 9}));
  EXPECT_TRUE(queue.TakeAll().empty());
  EXPECT_EQ(queue.dropped(), 0U);
}

TEST(BoundedQueue, DropsTheOldestWhenItIsFullAndCountsIt) {
  BoundedQueue<int> queue(2);
  for (int value = 1; value <= 5; ++value) queue.Push(value);
  EXPECT_EQ(queue.TakeAll(), (std::vector<int>{4, 5}));
  EXPECT_EQ(queue.dropped(), 3U);
}

TEST(BoundedQueue, HoldsSomething) {
  EXPECT_THROWS(BoundedQueue<int>(0), InvalidArgument, "a queue for 0 values; it must hold one");
}

}  // namespace
}  // namespace secondlook

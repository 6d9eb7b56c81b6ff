#pragma once

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

/// Expects that `expression` throws an `exception` whose message contains `text`.
#define EXPECT_THROWS(expression, exception, text)    \
  EXPECT_THAT([&] { static_cast<void>(expression); }, \
              ::testing::Throws<exception>(           \
                  ::testing::Property(&exception::what, ::testing::HasSubstr(std::string(text)))))

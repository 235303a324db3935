// SPDX-License-Identifier: Apache-2.0
#include "io/text_cursor.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace tetune {
namespace {

TEST(TextCursor, ReadsIntegersOfAnyLength) {
  std::vector<std::int64_t> numbers{0, -1, -98765432};
  for (std::int64_t n = 1; n < 100'000'000'000'000'000; n = 10 * n + n % 10 + 1) {
    numbers.insert(numbers.end(), {n, 10 * n, -n});
  }
  // Before the end of the text eight bytes cannot be read at once.
  for (const char* between : {" ", "\n", "\t", "  \r\n", "# 77\n"}) {
    std::string text;
    for (const std::int64_t n : numbers) text += std::to_string(n) + between;
    TextCursor cursor("numbers", text);
    for (const std::int64_t n : numbers) ASSERT_EQ(cursor.integer("number"), n) << '"' << between << '"';
    EXPECT_TRUE(cursor.at_end());
  }
}

TEST(TextCursor, RefusesWhatOnlyBeginsAsAnInteger) {
  for (const char* word : {"12x", "1.5", "1234567.", "12345678e", "7-", "--3", "+", "x1", "1234567890123456789"}) {
    for (const char* rest : {"", " 1 2 3 4 5 6 7 8"}) {
      const std::string text = word + std::string(rest);
      TextCursor cursor("numbers", text);
      EXPECT_THROW(cursor.integer("number"), FileError) << word << rest;
    }
  }
}

TEST(TextCursor, MessagesHaveNoControlCharacters) {
  TextCursor cursor("numbers", "1\n\x1b[2J");
  cursor.integer("number");
  try {
    cursor.integer("number");
    ADD_FAILURE() << "accepted";
  } catch (const FileError& e) {
    EXPECT_STREQ(e.what(), "numbers:2: expected an integer (number), found \"?[2J\"");
  }
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "backend/span.hpp"
#include "io/registry.hpp"
#include "io/text_cursor.hpp"

namespace tetune {

/// Reads a count of entries. Refuses one that the rest of the text cannot hold, with at least `numbers` numbers per
/// entry, or that a mesh cannot, before memory is allocated. `max`: as for excess_of().
inline std::size_t checked_count(TextCursor& cursor, const char* name, int numbers, Index max) {
  const std::int64_t n = cursor.integer(name);
  if (n < 0 || n > cursor.remaining() / (2 * numbers) + 1) {
    cursor.fail(std::string(name) + " is " + std::to_string(n) + ", more than the rest of the file can hold");
  }
  if (const std::string excess = excess_of(n, max); !excess.empty()) cursor.fail("this file has " + excess);
  return to_size_t(n);
}

}  // namespace tetune

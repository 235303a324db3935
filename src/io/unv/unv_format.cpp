// SPDX-License-Identifier: Apache-2.0
#include "io/unv/unv_format.hpp"

#include <array>
#include <charconv>
#include <system_error>

#include "backend/span.hpp"
#include "io/plain_text.hpp"

namespace tetune {

int leading_unv_integer(std::string_view text) {
  text = trimmed(text);
  int value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() ? value : 0;
}

std::string unv_length_unit(const TetMesh& mesh) {
  // By the code that starts the data set of units; empty for the meter.
  constexpr std::array<const char*, 10> kUnits{"",           "",           "foot", "",           "foot",
                                               "millimeter", "centimeter", "inch", "millimeter", "unit of its user"};
  const int code = leading_unv_integer(unv_units(mesh).substr(0, kUnvIntegerWidth));
  return code < 0 || code >= std::ssize(kUnits) ? "" : kUnits[to_size_t(code)];
}

}  // namespace tetune

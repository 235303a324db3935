// SPDX-License-Identifier: Apache-2.0
#include "io/unv/unv_format.hpp"

#include <array>
#include <cstdlib>

#include "backend/span.hpp"

namespace tetune {

std::string unv_length_unit(const TetMesh& mesh) {
  // By the code that starts the data set of units; empty for the meter.
  constexpr std::array<const char*, 10> kUnits{"",           "",           "foot", "",           "foot",
                                               "millimeter", "centimeter", "inch", "millimeter", "unit of its user"};
  const int code = std::atoi(std::string(unv_units(mesh).substr(0, kUnvIntegerWidth)).c_str());
  return code < 0 || code >= std::ssize(kUnits) ? "" : kUnits[to_size_t(code)];
}

}  // namespace tetune

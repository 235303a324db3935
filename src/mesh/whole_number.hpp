// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <optional>

namespace tetune {

/// The value as a tag if it is a 32-bit integer, otherwise nothing.
inline std::optional<int> whole_number(double value) {
  using Limits = std::numeric_limits<int>;
  if (!(value >= Limits::min() && value <= Limits::max()) || value != std::floor(value)) return {};
  return static_cast<int>(value);
}

}  // namespace tetune

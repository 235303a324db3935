// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace tetune {

/// Zero-based index of a vertex or an element.
using Index = std::int32_t;

/// Maximum number of tetrahedra of a mesh, flips included: they may add some, so the input should stay 10 % below.
inline constexpr Index kMaxTets = 400'000'000;

using Point3 = std::array<double, 3>;

}  // namespace tetune

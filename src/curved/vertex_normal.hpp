// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "math/vec3.hpp"

namespace tetune {

/// The unit normal at a vertex of a smooth surface that passes through it and through other points around it, given
/// relative to the vertex: that of the quadratic height function over the plane of `rough` that fits them best, with
/// the weights 1 / distance^2. Its error is O(h^2). `rough` itself where the points do not determine the function.
Vec3 fit_normal(const std::vector<Vec3>& around, const Vec3& rough);

}  // namespace tetune

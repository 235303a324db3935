// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "math/vec3.hpp"

namespace tetune {

/// The unit normal at a vertex of a smooth surface that passes through it and through other points around it, given
/// relative to the vertex: that of the quadratic height function over the plane normal to the unit vector `rough` that
/// fits them best by least squares with the weights 1 / distance^2. Its error is O(h^2). Returns `rough` where the
/// points do not determine the function.
Vec3 fit_normal(const std::vector<Vec3>& around, const Vec3& rough);

}  // namespace tetune

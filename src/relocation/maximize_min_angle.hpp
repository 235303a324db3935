// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/vertex_dofs.hpp"
#include "energy/criterion.hpp"
#include "mesh/work_mesh.hpp"
#include "relocation/coloring.hpp"

namespace tetune {

/// Moves the flagged vertices, color by color, each within its degrees of freedom, to decrease the largest
/// cost of the dihedral angles of its ring until it is at most `target_cost`. Returns the number of vertices that
/// moved.
template <class Backend>
Size maximize_min_angle(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                        const RingsView& rings, const Coloring<Backend>& coloring, VertexDofs<Backend>& dofs,
                        Span<const std::uint8_t> flags, double target_cost);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "boundary/vertex_dof.hpp"
#include "mesh/host_mesh.hpp"

/// Exact checks of an untangled mesh, on the host.
namespace tetune {

/// Returns those of the `slots` whose volume is not positive in exact arithmetic.
std::vector<Index> exactly_tangled(const HostMesh& mesh, std::vector<Index> slots);

/// Flags each vertex that moves within a plane or along a line and whose boundary faces in one plane do not all have
/// the same orientation: the surface is folded there. Vertices that slide on a curved surface are not tested.
std::vector<std::uint8_t> folded_vertices(const HostMesh& mesh, const std::vector<VertexDof>& dofs);

/// Returns the slots with a boundary face at a vertex that is folded now and was not folded `before`: all volumes may
/// be positive, but the surface has changed.
std::vector<Index> newly_folded(const HostMesh& mesh, const std::vector<VertexDof>& dofs,
                                const std::vector<std::uint8_t>& before);

/// Returns the slots with a boundary face that crosses another one or is folded onto a neighbor, among the faces near
/// `slots`: there no mesh with this surface has positive volumes and covers its inside once. A crossing is exact, a
/// fold to 1e-6 of a radian.
std::vector<Index> surface_faults(const HostMesh& mesh, const std::vector<Index>& slots);

}  // namespace tetune

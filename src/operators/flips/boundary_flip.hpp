// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/boundary_triangles.hpp"
#include "boundary/sliding/reference_surface.hpp"
#include "operators/engine/flip_state.hpp"

/// Flips of boundary edges between two triangles of one patch, which are coplanar unless flips may bend the
/// surface (BoundaryTriangles::flips_bend): the tetrahedra (a, r_m, r_m+1, b) around such an edge (a, b) are a fan from
/// one triangle (a, b, r_0) to the other (a, b, r_n), and its removal triangulates the polygon r_0, ..., r_n, whose
/// last side lies in the boundary. With two tetrahedra it is the 2-2 flip. Where the triangles have tetrahedra on both
/// sides, as those of interfaces do, there is a fan on each side, and both are retriangulated together. "Boundary" here
/// is all that flip_pass() must keep: the outer boundary, interfaces, constrained triangles.
namespace tetune {

/// One pass over all edges of the boundary with an end flagged in `changed`: like flip_pass(), with one candidate per
/// edge that may be flipped (FindEdge). It needs no active set; new tetrahedra are active for flip_pass() afterwards.
/// `checked`: see BendLimit; empty without a bound on the deviation.
template <class Backend>
PassResult boundary_flip_pass(const Backend& backend, WorkMesh<Backend>& mesh, const Criterion& criterion,
                              FlipState<Backend>& state, BoundaryTriangles<Backend>& boundary,
                              const CheckedSurfaceView& checked, Span<std::uint8_t> changed);

}  // namespace tetune

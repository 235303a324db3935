// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// Carries sets of nodes and tags of vertices to the result of a run. An inserted vertex is in the sets of nodes that
/// all vertices of the edge, triangle or tetrahedron of the input on which it lies are in, and has the tag that all of
/// them have. If it is inside the mesh while these are all on the surface, as between two sides of a thin part, inner
/// vertices that share a tetrahedron with them count too, so that no set of surface nodes gets an inner vertex.
///
/// Sets the sets of nodes in `point_data`, the data of the result, in the order of those of the input `mesh`. Returns
/// the tags of the inserted vertices, in increasing order of their ids. `new2original` and `places` are those of the
/// report. `result` makes the result's points, tetrahedra and regions, where vertices were inserted; null, if these
/// have no place in the input: their tags are 0 then, and their data stay.
std::vector<int> carry_vertex_sets(const TetMesh& mesh, const std::vector<Index>& new2original,
                                   const std::vector<MeshPlace>& places, const std::function<TetMesh()>& result,
                                   std::vector<DataArray>& point_data);

}  // namespace tetune

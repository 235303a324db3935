// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "boundary/boundary_triangles.hpp"
#include "boundary/vertex_dofs.hpp"
#include "operators/engine/flip_state.hpp"

namespace tetune {

/// Numbers of vertices that retriangulate_worst() inserted and removed, and of the other cavities it retriangulated.
struct RetriangulationReport {
  Size inserted = 0, removed = 0;
  Size others = 0;
};

/// A mesh with the data that follow it when vertices are inserted and removed.
template <class Backend>
struct EditableMesh {
  WorkMesh<Backend>& mesh;
  FlipState<Backend>& flips;
  VertexDofs<Backend>& dofs;
  BoundaryTriangles<Backend>* boundary = nullptr;  ///< null: no vertex of the surface is inserted or removed
};

struct RetriangulationLimits {
  /// Where the mesh would get more tetrahedra, the pass is repeated without insertion; where it would even then,
  /// nothing is changed.
  Size max_tets;
  double vertex_cost;  ///< vertices are inserted and removed where an angle has a larger cost; kInfeasible: nowhere
  double min_gain;     ///< what must fall in a cavity falls by at least this part
  /// Above 0: the mean energy of the mesh. Vertices are inserted and removed so that it falls, at all tetrahedra given.
  double mean_energy = 0;
  /// Proposals are left out that hardly ever lower it.
  bool is_selective = false;
  /// Where more vertices than this would be removed beyond those inserted, the pass is repeated without removal.
  Size max_removed = std::numeric_limits<Size>::max();
};

/// Improves the `worst` tetrahedra, listed in ascending order, by operators that retriangulate a cavity from one point.
/// Each tetrahedron proposes the removal of one of its edges, with a vertex around that edge moved to where this is
/// possible (CompositeRemoval). With a finite `vertex_cost` it also proposes the retriangulation of a cavity around it
/// from one of its vertices (CavityRetriangulation), and where it has an angle with a larger cost, the insertion of a
/// vertex on each of its edges and inside it (VertexInsertion) and the contraction of each of its free vertices to each
/// other (VertexContraction). With a `mean_energy` it proposes insertions and contractions alone. With a `boundary`,
/// vertices are inserted and removed there too (SurfaceInsertion, SurfaceContraction); the surface keeps its shape, or
/// bends within kMaxBend where it may. Constrained edges stay as they are.
///
/// Inserted vertices take the ids from mesh.vertices() on; removed ones are in no tetrahedron afterwards. The
/// vertex2original of both is kInserted or kRemoved. `dofs.active` is set for the vertices whose ring changed; the
/// energies in `flips` stay up to date; the active set, rings and colors have to be built again.
template <class Backend>
RetriangulationReport retriangulate_worst(const Backend& backend, const EditableMesh<Backend>& editable,
                                          const Criterion& criterion, Span<const Index> worst,
                                          const RetriangulationLimits& limits);

}  // namespace tetune

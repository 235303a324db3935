// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "energy/ring.hpp"
#include "mesh/work_mesh.hpp"

namespace tetune {

/// The rings of all vertices in a backend's memory.
template <class Backend>
struct Rings {
  BufferOf<Backend, std::uint32_t> offsets;
  BufferOf<Backend, LinkFace> faces;
  RingsView view() const { return {offsets.span(), faces.span()}; }
};

template <class Backend>
void build_rings(const Backend& backend, WorkMesh<Backend>& mesh, Rings<Backend>& rings);

/// Builds the rings of the flagged vertices alone; the others have empty ones. Requires that `tets` lists all
/// tetrahedra of the flagged vertices.
template <class Backend>
void build_rings_of(const Backend& backend, WorkMesh<Backend>& mesh, Span<const Index> tets,
                    Span<const std::uint8_t> flags, Rings<Backend>& rings);

}  // namespace tetune

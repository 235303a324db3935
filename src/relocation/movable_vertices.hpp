// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "boundary/vertex_dofs.hpp"
#include "energy/ring.hpp"
#include "relocation/coloring.hpp"

namespace tetune {

/// The vertices of a mesh as relocation needs them: their rings, a coloring for these, and where each may go.
template <class Backend>
struct MovableVertices {
  RingsView rings;
  const Coloring<Backend>& coloring;
  VertexDofs<Backend>& dofs;
};

}  // namespace tetune

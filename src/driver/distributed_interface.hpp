// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "boundary/sliding/slide_surface.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/unit_scale.hpp"
#include "mesh/vertex_layers.hpp"
#include "tetune/export.hpp"
#include "tetune/optimize.hpp"

/// The internal interface of the library for optimizing a mesh in parts, which tetune::mpi is built on. Besides the
/// public headers it is all that mpi/ uses, together with the layout of MEDIT files (io/medit/medit_codec.hpp) and
/// temporary files (system/file.hpp). It is not installed, and may change in any version. It includes maps between
/// numberings (mesh/id_maps.hpp), layers of tetrahedra (mesh/vertex_layers.hpp) and the unit of coordinates
/// (mesh/unit_scale.hpp).
///
/// A part is a TetMesh with frozen vertices where it meets others. With Boundary::slide all rounds of all parts slide
/// on the surface of the input: find_slide_surface() takes it from the mesh before any vertex moves, the caller cuts
/// out of it what lies under a part, and optimize() below takes that instead of the surface of the part. The surface
/// may have vertices that the part lacks: they are appended to the part as vertices of no tetrahedron, and removed
/// again by erase_vertices().
namespace tetune {

/// The surface that optimize() lets the vertices of a mesh slide on, and where they may go on it. Throws as optimize()
/// does.
TETUNE_API SlideSurface find_slide_surface(const TetMesh& mesh, const Options& options);

/// optimize() with Boundary::slide on a surface that need not be the mesh's own. Vertices whose surface point is not on
/// it do not move. Updates the places of the vertices in `surface`, whose entries are those of the vertices before the
/// call.
TETUNE_API Report optimize(TetMesh& mesh, const Options& options, const Context& context, SlideSurface& surface);

/// The tag of the triangles between a part and the rest: it continues no patch of the mesh.
inline constexpr int kCutTag = std::numeric_limits<int>::min();

/// Lists the faces of one tetrahedron of a part alone whose vertices are all on the cut as required triangles, behind
/// the listed ones, so that no vertex slides onto the cut; returns their number.
TETUNE_API std::size_t list_cut(TetMesh& part, const std::vector<std::uint8_t>& on_cut);

/// Erases the vertices v with keep[v] 0, which no element may have, and renumbers the others; corners among them are
/// erased from their list.
TETUNE_API void erase_vertices(TetMesh& mesh, const std::vector<std::uint8_t>& keep);

}  // namespace tetune

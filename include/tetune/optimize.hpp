// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "tetune/context.hpp"
#include "tetune/export.hpp"
#include "tetune/mesh.hpp"
#include "tetune/options.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// Improves a mesh in place: harmonic flips alternate with vertex relocation (Stroeter et al. 2022, Sect. 4.5).
///
/// The result is a valid mesh (see validate()) without a smaller dihedral angle than the input's smallest, one that is
/// larger than both the input's largest and 165 degrees, or a smaller mean ratio (with Effort::best, than a quarter
/// of the input's smallest); of curved elements the smallest angle alone.
/// - Vertices keep their tags, number and order. Where Effort::best or SurfaceVertices::edit inserts or removes some
///   (Report::vertex2original), those of the input come first, in their order, then the inserted ones, with the tag
///   that all vertices have between which they are, or 0.
/// - Boundary::preserve and fixed keep the shape of the boundary; where it is flat, boundary_flips may replace its
///   triangles by others.
/// - Flips and sweeps lower the energy; the work on the worst elements that follows may raise its sum, in most cases
///   slightly, unless Options::effort is fast. Retriangulations that add tetrahedra need fewer than Options::max_growth
///   times those of the input; flips are not limited.
///
/// Tetrahedra come out in another order and number. Listed triangles without a tag inside one region are no constraint
/// and are dropped, as are untagged listed edges that no longer exist. The result is bit for bit the same for any
/// number of threads.
///
/// Of a curved second-order mesh (TetMesh::curved_edges) curved triangles of the surface, of interfaces and of patches
/// stay bit for bit, every element is proved valid, and the smallest scaled Jacobian falls by at most 0.002;
/// Options::untangle may then insert vertices with any effort, unless keep_vertices is set.
///
/// Throws MeshError if `validate(mesh)` finds a defect, CurvedError, UntangleError, OverlapError, OptionError,
/// DeviceError or std::bad_alloc, and whatever the hooks of `context` throw; the mesh is then unchanged. Calls on
/// different meshes may be concurrent.
TETUNE_API Report optimize(TetMesh& mesh, const Options& options = {}, const Context& context = {});

/// An estimate of the peak of main memory of optimize(), in bytes, including the mesh: to refuse a mesh before the
/// work. Fitted to meshes of 80 thousand to 1.5 million tetrahedra: docs/command-line.md, "Memory".
TETUNE_API std::size_t memory_needed(const TetMesh& mesh, const Options& options = {});

/// The GPU memory that optimize() reserves on a CUDA device, in bytes, whatever Options::device is. If less is free,
/// optimize() throws DeviceError before the work.
TETUNE_API std::size_t memory_needed_on_device(const TetMesh& mesh, const Options& options = {});

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "tetune/targets.hpp"

namespace tetune {

/// Where optimize() computes.
enum class Device {
  automatic,  ///< "auto": as cuda for 500000 tetrahedra or more if there is a GPU with enough memory, else as cpu
  cpu,        ///< on CPU threads
  cuda,       ///< on the calling thread's current NVIDIA GPU, compute capability 7.5 or newer
};

/// How vertices of the boundary and of interfaces between regions may move.
enum class Boundary {
  fixed,     ///< not at all
  preserve,  ///< in the plane or along the straight line that they lie on: the shape does not change (Sect. 4.2)
  slide,     ///< on the input surface, and along its feature lines (Sect. 4.3)
};

/// The energy per tetrahedron. optimize() minimizes its sum.
enum class Energy {
  shape,     ///< (eta / eta_r)^(3/2), where eta_r is the eta of the regular tetrahedron of the same volume: at least 1
             ///< and dimensionless. It depends on the shape only: small elements count as much as large ones
  harmonic,  ///< eta, the energy of the paper (Eq. 5), a length: large elements count for more, and sliding vertices
             ///< drift to where elements become unequal
};

enum class Relocation {
  newton,    ///< over-relaxed Newton step on the convex energy of the one-ring
  gradient,  ///< steepest descent with Brent's line search, as in the paper (Alg. 1)
};

enum class Termination {
  relative,  ///< when the relative decrease of the energy is small; independent of scale
  paper,     ///< by the conditions C1 to C3 of Sect. 4.5
};

/// How much is done. Percentages are of the energy, per sweep and the flips that follow it.
enum class Effort {
  fast,      ///< flips are searched for once, and sweeps end when one lowers the energy by less than 2 %
  standard,  ///< sweeps end at 0.2 %, then the worst elements and the smallest dihedral angles are improved
  best,      ///< sweeps end at 0.01 %, then there is more of that work, and vertices are inserted and removed
};

/// Whether vertices of the surface and of interfaces are inserted and removed: with Boundary::preserve inside flat
/// parts of a patch and along straight feature lines, so that the surface keeps its shape; with Boundary::slide on the
/// input surface and its feature lines, where edges of the surface are flipped too. The latter moves the surface by at
/// most 0.15 of the local edge length, in addition to what sliding does; with Options::max_deviation both together
/// stay within that bound.
enum class SurfaceVertices {
  automatic,  ///< "auto": as edit with Effort::best, else as keep
  keep,       ///< they are kept
  edit,       ///< they are inserted and removed, inside the mesh too, with any effort that works on the worst elements
};

/// How the data of vertices and tetrahedra of the result are obtained.
enum class DataTransfer {
  carry,        ///< those of the vertex of the input, wherever it has moved, and of the tetrahedron's original
  interpolate,  ///< of vertices: those of the input at the place of the vertex, by interpolate_point_data()
  conserve,     ///< floating-point data keep their integrals: conserve_data()
};

/// The options of optimize(). Section, equation and algorithm numbers are those of Stroeter et al. 2022.
///
/// A value out of its range, and options that leave nothing to do, are refused with OptionError. An option that has no
/// effect beside the others is not refused: Report::warnings names it. option_table.hpp has all options as data.
struct Options {
  Device device = Device::cpu;
  Boundary boundary = Boundary::preserve;
  Energy energy = Energy::shape;
  /// Without effect with Termination::paper. With Energy::harmonic there is no work on the worst elements.
  Effort effort = Effort::standard;
  /// If true, no vertex is inserted or removed; otherwise Effort::best, SurfaceVertices::edit, and `untangle` in curved
  /// meshes do so.
  bool keep_vertices = false;
  /// Vertices are inserted while the ratio of the numbers of tetrahedra of result and input is below this, 1 to 100. A
  /// larger value allows insertion around more of the worst tetrahedra, at proportional cost. Flips are not limited.
  double max_growth = 1.1;
  SurfaceVertices surface_vertices = SurfaceVertices::automatic;
  /// With Effort::best: maximum number of rounds of restarts, -1 to 10,000. A round optimizes the neighborhoods of at
  /// most four of the worst elements again, without regard to the angles reached, and keeps a result that improves the
  /// worst element in it. At most as many rounds follow that lower the largest dihedral angle and leave the smallest.
  /// 0: none; -1: 10 of each, of the first kind one per 400 tetrahedra in smaller meshes.
  int restarts = -1;
  Relocation relocation = Relocation::newton;
  Termination termination = Termination::relative;
  /// If true, inverted and flat tetrahedra are made positive first, instead of refused with MeshError: vertices move as
  /// `boundary` allows, under an energy that is finite for negative volumes. Curved second-order elements that the
  /// surface alone makes invalid, or nearly so, are split.
  bool untangle = false;
  /// With `untangle`, in meshes of curved second-order tetrahedra: where the mid-side nodes of the surface make
  /// elements invalid wherever inner nodes are, they move toward the middle of their chord, as little as makes the
  /// elements valid: Report::straightened. Otherwise such a mesh is refused. Refused with periodic vertices.
  bool straighten = false;
  /// With Boundary::slide: an edge where the surface turns by more than this many degrees, in (0, 180], is a feature
  /// edge. A vertex at which a feature line turns by more than it is a corner. Lines with a free end inside the surface
  /// that nowhere turn by more than 4/3 of the angle are ignored. With 180, feature edges are only those between tags,
  /// those that are not on exactly two triangles, and listed edges.
  double feature_angle = 45;
  /// With Boundary::slide: maximum distance of any point of the new surface from the old one and of the old one from
  /// the new one; a length in the mesh's unit, 0 for no bound.
  double max_deviation = 0;
  /// If true, tagged triangles with the same region on both sides stay faces of the mesh, as interfaces do; otherwise
  /// they are dropped, unless they are required or frozen.
  bool open_boundaries = true;
  /// Tags of tetrahedra, and of listed triangles, that stay bit for bit as they are. OptionError if none has the tag.
  std::vector<int> frozen_regions, frozen_patches;
  /// Empty, or one flag per vertex: a vertex whose flag is not 0 does not move. (TetMesh::required_vertices, a list of
  /// ids, does the same as a part of the mesh, and is kept in files.)
  std::vector<std::uint8_t> frozen_vertices;
  /// If not empty, only tetrahedra that miss one of these limits may change, and those within `rings` around them: a
  /// ring is the tetrahedra that share a vertex with those before. All others keep their vertices, the order in which
  /// they are listed, and the coordinates of these, bit for bit; their faces are not checked. If more tetrahedra would
  /// miss a limit afterwards, and none had to be untangled, the mesh stays as it is, and Report::warnings says so. The
  /// time of the work is in proportion to Report::tets_active. Refused by move().
  std::vector<Target> only_below;
  /// With `only_below`: 0 to 100.
  int rings = 2;
  /// Maximum number of relocation sweeps, 0 or more; 0 means only flips.
  int max_iterations = 100;
  /// Number of CPU threads, 0 to 4096; 0 means all. The result does not depend on it.
  int threads = 0;
  /// If false, no edge and no face is flipped: vertices are only moved, inserted and removed.
  bool flips = true;
  /// Maximum number of tetrahedra around an edge that a flip removes or creates, 3 to 7. With 3 there are only the
  /// paper's 3-2 and 2-3 flips; below 5 no faces are removed together.
  int max_ring = 7;
  /// Whether edges between coplanar triangles of one patch of the boundary, or of one interface, may be flipped; with
  /// max_deviation > 0, unless vertices of the surface are inserted and removed, in patches that lie in a plane. If
  /// not, no vertex of the surface is inserted or removed either. Without effect with Boundary::fixed, max_ring 3,
  /// max_iterations 0 or without flips.
  bool boundary_flips = true;
  /// The quality that every element should have. It does not change the result: Report::targets says which elements
  /// miss it and what constrains them.
  std::vector<Target> targets;
  /// How the data of vertices and tetrahedra of the result are obtained.
  DataTransfer data = DataTransfer::carry;
  /// If true, the smallest dihedral angle is measured after each sweep and round, for SweepReport::dihedral_min and
  /// WorstReport::dihedral_min. It takes a twelfth of the time.
  bool trace_angles = false;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tetune/curved.hpp"
#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// Quality measures of a tetrahedron. Definitions, ranges and names in other programs: docs/quality.md.
enum class Measure : std::uint8_t {
  min_dihedral,     ///< smallest dihedral angle, degrees; 70.53 for a regular tetrahedron
  max_dihedral,     ///< largest dihedral angle, degrees
  mean_ratio,       ///< 12 (3 V)^(2/3) / sum of squared edge lengths (Gmsh eta, Verdict shape)
  sicn,             ///< signed inverse condition number (Gmsh minSICN, 1 / Verdict condition)
  gamma,            ///< 3 r / R, inscribed over circumscribed radius (Gmsh gamma)
  scaled_jacobian,  ///< Verdict scaled_jacobian
  radius_ratio,     ///< R / (3 r) (Verdict radius_ratio); larger is worse
  aspect_ratio,     ///< longest edge / (2 sqrt(6) r) (Verdict aspect_ratio); larger is worse
  harmonic,         ///< q_h: eta of the regular tetrahedron of the same volume / eta
};
inline constexpr std::size_t kMeasures = 9;

/// Name of a measure, as in reports: "min_dihedral_deg", "mean_ratio", ... "q_h".
TETUNE_API const char* to_string(Measure measure);

/// False for the largest dihedral angle, the radius ratio and the aspect ratio.
TETUNE_API bool larger_is_better(Measure measure);

/// Radius and aspect ratio of a flat or inverted tetrahedron, and the upper bound of both.
inline constexpr double kFlatRatio = 1e30;

/// All measures of one tetrahedron, indexed by Measure.
using Measures = std::array<double, kMeasures>;

/// One measure over a mesh.
struct MeasureSummary {
  double min = 0;
  /// Percentiles counted from the worse end: 1 % and 5 % of the tetrahedra are as bad as this or worse. Exact, of
  /// values rounded to single precision.
  double p1 = 0, p5 = 0;
  double mean = 0, max = 0;
};

/// One of the worst tetrahedra.
struct WorstTet {
  Index tet = -1;
  double dihedral = 0;  ///< its smallest dihedral angle, degrees
  double harmonic = 0;  ///< its q_h
  Point3 centroid{};
};

/// Element quality of a whole mesh. Angles in degrees.
struct Quality {
  std::int64_t tets = 0;
  /// Over all six dihedral angles of all tetrahedra, in degrees; p1 and p5 are the 1 % and 5 % percentiles, to 0.005
  /// degrees, the extremes are exact.
  double dihedral_min = 0;
  union {
    double dihedral_p1 = 0;
    double dihedral_1;  ///< former name, until version 0.3
  };
  union {
    double dihedral_p5 = 0;
    double dihedral_5;  ///< former name, until version 0.3
  };
  double dihedral_mean = 0, dihedral_max = 0;
  /// Tetrahedron with the smallest dihedral angle, the first of several.
  Index worst_tet = -1;
  /// Harmonic index eta = (sum of squared face areas) / volume; Stroeter et al. 2022, Eq. 5. Unit: length.
  double eta_max = 0, eta_95 = 0, eta_sum = 0;
  /// Sum of the shape energy (eta / eta_r)^(3/2), where eta_r is the eta of the regular tetrahedron of the same volume.
  /// It equals the number of tetrahedra if all are regular.
  double shape_sum = 0;
  /// Mean ratio 12 (3 V)^(2/3) / (sum of squared edge lengths): 1 for a regular tetrahedron, 0 for a flat one.
  double mean_ratio = 0, mean_ratio_min = 0;
  double volume = 0;
  /// Share of dihedral angles in each of 18 bins of 10 degrees.
  std::array<double, 18> histogram{};

  /// Filled by measure_all() only: each measure, indexed by Measure, and the tetrahedra of smallest dihedral angle, by
  /// angle, then by id.
  std::array<MeasureSummary, kMeasures> measures{};
  std::vector<WorstTet> worst;
  /// Second-order tetrahedra with curved edges. All other entries are those of the straight ones with the same
  /// vertices.
  CurvedQuality curved;
  const MeasureSummary& of(Measure measure) const { return measures[static_cast<std::size_t>(measure)]; }
};

/// Measures a mesh of positive volumes. The result is bit for bit the same for any number of threads; `threads` 0 means
/// all. Returns zeros for a mesh without tetrahedra. Throws MeshError if an index is out of range, an array has the
/// wrong length or a coordinate is not finite.
TETUNE_API Quality quality(const TetMesh& mesh, int threads = 0);

/// As quality(), with all measures and the `worst` worst tetrahedra. Takes longer, and 36 bytes per tetrahedron.
TETUNE_API Quality measure_all(const TetMesh& mesh, int threads = 0, int worst = 10);

/// All measures of each tetrahedron, in the mesh's order. Throws as quality() does.
TETUNE_API std::vector<Measures> measure_each(const TetMesh& mesh, int threads = 0);

/// Writes measure_each(). As .sol (MEDIT solution file, text), which viewers load beside the mesh: one line per
/// tetrahedron in the mesh's order, one number per measure in the order of Measure. As .vtu, .vtk, .e or .msh: the mesh
/// with the measures as data of its tetrahedra, under the names of to_string(); `warnings` is as in write_mesh(). The
/// file is written under a temporary name and renamed. Throws as quality() does, and FileError.
TETUNE_API void write_measures(const std::string& path, const TetMesh& mesh, int threads = 0,
                               std::vector<std::string>* warnings = nullptr);

/// Change of the area of the listed triangles of one tag, curved ones where edges are curved.
struct PatchChange {
  int tag = 0;
  double area_before = 0;
  double area_change = 0;  ///< relative
};

/// Differences between two meshes of the same shape, `before` (old) and `after` (new). Volumes and areas are those of
/// the curved elements where edges are curved.
struct Comparison {
  /// Relative changes, new relative to old.
  double volume_change = 0, area_change = 0;
  /// Largest distances between the old and the new surface (boundary and interfaces between regions), divided by the
  /// mean edge length of the old boundary: from vertices of the new surface to the old one, and from vertices, edge
  /// midpoints and triangle centroids of either surface to the other.
  double vertices_to_old = 0, new_to_old = 0, old_to_new = 0;
  /// One in this many of those vertices, midpoints and centroids was measured.
  std::int64_t sample_stride = 1;
  /// Mean edge length of the old boundary.
  double mean_edge = 0;
  std::int64_t old_vertices = 0, new_vertices = 0, old_tets = 0, new_tets = 0;
  /// Whether the set of tags is the same; of vertices, whether each has the same tag, unless their number has changed.
  bool vertex_tags_kept = false, tet_tags_kept = false, triangle_tags_kept = false, edge_tags_kept = false;
  /// Largest relative change of a region's volume, and of a tagged patch's area.
  double region_volume_change = 0, patch_area_change = 0;
  /// One entry per tag of listed triangles except 0, in increasing order.
  std::vector<PatchChange> patches;
  /// Numbers of required vertices, and of corners, at whose exact position the new mesh has neither the vertex of the
  /// same id nor one that is listed as such.
  std::int64_t required_moved = 0, corners_moved = 0;
};

/// Compares two meshes. `threads` 0 means all. The distances between the surfaces are measured at about `max_samples`
/// points of each at most, spread evenly over the mesh's order, or with 0 at all. Throws MeshError as quality() does.
TETUNE_API Comparison compare(const TetMesh& before, const TetMesh& after, int threads = 0,
                              std::int64_t max_samples = 0);

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"

/// Acceptance of a mesh: limits of quality measures, as solvers and preprocessors check them.
namespace tetune {

/// A quantity that a criterion bounds. The first ones are those of Measure, in the same order. Definitions and sources:
/// docs/quality.md, "Acceptance".
enum class CheckMeasure : std::uint8_t {
  min_dihedral,
  max_dihedral,
  mean_ratio,
  sicn,
  gamma,
  scaled_jacobian,
  radius_ratio,
  aspect_ratio,
  harmonic,
  volume,               ///< signed, in the mesh's unit to the power of 3
  jacobian_ratio,       ///< of the determinant at the integration points: 1 for every tetrahedron of four nodes
  min_face_angle,       ///< smallest angle of a face at a corner, degrees
  max_face_angle,       ///< largest angle of a face at a corner, degrees
  equiangle_skew,       ///< deviation of the angles of the faces, and between them, from the regular ones, 0 to 1
  volume_skew,          ///< 1 - volume / volume of the regular tetrahedron of the same circumscribed sphere
  collapse,             ///< smallest of altitude / root of its face's area; 1 for the regular tetrahedron
  edge_ratio,           ///< longest over shortest edge
  edge_altitude_ratio,  ///< longest edge over smallest altitude
  triangle_aspect,     ///< largest of the faces, and of the sections through an edge and the middle of the opposite one
  shortest_edge,       ///< in the mesh's unit
  min_altitude,        ///< in the mesh's unit
  orthogonal_quality,  ///< smallest cosine between normals of faces and vectors between centroids
  non_orthogonality,   ///< per face inside: angle between its normal and the line between the centroids, degrees
  face_skewness,       ///< per face: distance of that line from the centroid of the face, relative to its size
};
inline constexpr std::size_t kCheckMeasures = 24;

struct CheckMeasureInfo {
  CheckMeasure measure;
  const char* name;  ///< in criteria files and reports: "volume_skew"
  bool larger_is_better;
  bool of_faces;     ///< per face; else per tetrahedron
  const char* unit;  ///< "", "degrees", "length", "length^3"
  /// No tetrahedron is better: the value of the regular one, or a bound. Infinite for lengths and volumes.
  double best;
};

/// All of them, in the order of the enumeration.
TETUNE_API std::span<const CheckMeasureInfo> check_measures();
TETUNE_API const CheckMeasureInfo& info_of(CheckMeasure measure);
/// The measure of this name; null if there is none.
TETUNE_API const CheckMeasureInfo* find_check_measure(std::string_view name);

/// Limits of one measure. A value that is worse than a limit misses it; one that is not a number misses both.
struct AcceptanceCriterion {
  CheckMeasure measure = CheckMeasure::mean_ratio;
  std::optional<double> warn, fail;
  /// Part of the tetrahedra, or faces, that may miss a limit, in percent.
  double allowed_percent = 0;
  std::string source = {};  ///< of the limits
};

struct AcceptanceCriteria {
  std::string name;
  std::vector<AcceptanceCriterion> criteria;
};

/// The criteria of programs for tetrahedra of four nodes: "abaqus", "ansys", "calculix", "fluent", "nastran",
/// "openfoam". Sources: docs/quality.md.
TETUNE_API std::span<const AcceptanceCriteria> preset_criteria();
/// The preset of this name; null if there is none.
TETUNE_API const AcceptanceCriteria* find_preset(std::string_view name);

/// Throws OptionError for a criterion without a limit, a limit that is not finite or that no element can meet, a `warn`
/// that is worse than `fail`, or a percentage that is not in 0 to 100.
TETUNE_API void check_criterion(const AcceptanceCriterion& criterion);

enum class Verdict : std::uint8_t { pass, warn, fail };
/// "pass", "warn" or "fail".
TETUNE_API const char* to_string(Verdict verdict);

struct CriterionResult {
  AcceptanceCriterion criterion;
  Verdict verdict = Verdict::pass;
  std::int64_t count = 0;   ///< number of tetrahedra, or faces, that were measured
  std::int64_t warned = 0;  ///< number of those that miss `warn`, but not `fail`
  std::int64_t failed = 0;  ///< number of those that miss `fail`
  double worst = 0;
  Index worst_tet = -1;  ///< the first of several; of a face, the tetrahedron of smaller id
  Point3 centroid{};     ///< of that tetrahedron
};

struct AcceptanceReport {
  std::string name;
  Verdict verdict = Verdict::pass;  ///< the worst of all criteria
  std::vector<CriterionResult> results;
};

/// Judges a mesh. A criterion fails if more than the allowed part misses `fail`, and warns if any does, or more than
/// the allowed part misses `warn`. A mesh without tetrahedra fails. The result does not depend on `threads`; 0 means
/// all. Throws OptionError as check_criterion() does, and MeshError as quality() does.
TETUNE_API AcceptanceReport check(const TetMesh& mesh, const AcceptanceCriteria& criteria, int threads = 0);

}  // namespace tetune

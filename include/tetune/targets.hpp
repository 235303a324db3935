// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"
#include "tetune/quality.hpp"

namespace tetune {

/// The quality that every element should have: `value` or more where larger is better, else `value` or less.
struct Target {
  Measure measure = Measure::min_dihedral;
  /// In the unit of the measure; from the regular tetrahedron's value to the worst of a valid one, which is excluded.
  double value = 0;
};

/// The strongest constraint of an element that misses a target: the first of these that applies.
enum class LimitingConstraint : std::uint8_t {
  locked_element,    ///< the tetrahedron is required, in a frozen region, or not among those of Options::only_below
  surface_angle,     ///< the angle of the surface at an edge of the element is so small that no element there can reach
                     ///< the target
  fixed_vertices,    ///< none of its vertices may move
  surface_element,   ///< all four vertices are on the surface
  frozen_vertex,     ///< a vertex must not move: it is required, frozen, or one of an element of another kind
  feature_corner,    ///< a vertex is a corner of the shape
  feature_line,      ///< a vertex may only move along a line
  region_interface,  ///< a vertex is on a face between two regions
  boundary,          ///< a vertex is on the boundary
  none,              ///< all its vertices may move anywhere
};
inline constexpr std::size_t kLimitingConstraints = 10;

/// In words: "locked element", "angle of the surface", ...
TETUNE_API const char* to_string(LimitingConstraint constraint);

using Pin = LimitingConstraint;                             ///< former name, until version 0.3
inline constexpr std::size_t kPins = kLimitingConstraints;  ///< former name, until version 0.3

/// An element that misses a target.
struct MissedTet {
  Index tet = -1;    ///< in the mesh that optimize() returned
  double value = 0;  ///< of the target's measure
  Point3 centroid{};
  union {
    LimitingConstraint held_by = LimitingConstraint::none;
    LimitingConstraint pin;  ///< former name, until version 0.3
  };
  /// With LimitingConstraint::surface_angle: the ends of that edge, and the angle between the two faces of the surface
  /// there, in degrees.
  std::array<Index, 2> edge{-1, -1};
  double surface_angle = 0;
};

/// How many elements miss a target, and why.
struct TargetReport {
  Target target;
  std::int64_t tets = 0;    ///< number of elements of the mesh
  std::int64_t missed = 0;  ///< number of those that miss the target
  union {
    /// How many of them each LimitingConstraint holds.
    std::array<std::int64_t, kLimitingConstraints> held_by{};
    std::array<std::int64_t, kLimitingConstraints> pinned;  ///< former name, until version 0.3
  };
  /// The worst of them, at most kMaxMissed: by value, then by id.
  std::vector<MissedTet> worst;
  bool met() const { return missed == 0; }
};
inline constexpr std::size_t kMaxMissed = 1000;

}  // namespace tetune

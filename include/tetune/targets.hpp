// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tetune/mesh.hpp"
#include "tetune/quality.hpp"

namespace tetune {

/// What every element is to reach: `value` or more where larger is better, else `value` or less.
struct Target {
  Measure measure = Measure::min_dihedral;
  /// In the unit of the measure; between the worst a valid tetrahedron can have, excluded, and the regular one's.
  double value = 0;
};

/// What holds an element that misses a target: the strongest of its constraints, the first that applies.
enum class Pin : std::uint8_t {
  locked_element,  ///< a required tetrahedron, or one of a frozen region
  surface_angle,   ///< at one of its edges the surface itself has so small an angle that no element there can do better
  fixed_vertices,  ///< no vertex of it may move
  surface_element,  ///< all four vertices are on the surface
  frozen_vertex,    ///< a vertex must not move: required, frozen, of an element of another kind
  feature_corner,   ///< a vertex is a corner of the shape
  feature_line,     ///< a vertex may only move along a line
  interface,        ///< a vertex is on a face between two regions
  boundary,         ///< a vertex is on the boundary
  none,             ///< all its vertices are free
};
inline constexpr std::size_t kPins = 10;

/// In words: "locked element", "angle of the surface", ...
const char* to_string(Pin pin);

/// An element that misses a target.
struct MissedTet {
  Index tet = -1;  ///< of the mesh that optimize() left
  double value = 0;
  Point3 centroid{};
  Pin pin = Pin::none;
  /// With Pin::surface_angle: the ends of that edge, and the angle between the surface's two faces there, in degrees.
  std::array<Index, 2> edge{-1, -1};
  double surface_angle = 0;
};

/// How a target was met.
struct TargetReport {
  Target target;
  std::int64_t tets = 0;                     ///< elements in all
  std::int64_t missed = 0;                   ///< elements that miss it
  std::array<std::int64_t, kPins> pinned{};  ///< how many of them each Pin holds
  /// The worst of them, at most kMostMissed: by value, then by id.
  std::vector<MissedTet> worst;
  bool met() const { return missed == 0; }
};
inline constexpr std::size_t kMostMissed = 1000;

}  // namespace tetune

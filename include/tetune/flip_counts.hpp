// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tetune {

/// One counter of a report: every report, table and binding lists its counters through an array of these.
template <class Counts>
struct CountInfo {
  using Member = std::int64_t Counts::*;
  const char* name;   ///< of the member, also in Python
  const char* key;    ///< in JSON and CSV
  const char* title;  ///< in words, plural
  const char* text;
  Member count;
};

/// Numbers of flips by kind. Boundary flips and face removals are made by passes of their own.
struct FlipCounts {
  std::int64_t flips23 = 0, flips32 = 0;
  std::int64_t edge_removals = 0;
  std::int64_t face_removals = 0;
  std::int64_t boundary_flips = 0;

  /// Their sum.
  std::int64_t flips() const;
  FlipCounts& operator+=(const FlipCounts& other);
};

inline constexpr std::array kFlipCounts{
    CountInfo<FlipCounts>{"flips23", "flips_2_3", "2-3 flips", "A face gives way to an edge", &FlipCounts::flips23},
    CountInfo<FlipCounts>{"flips32", "flips_3_2", "3-2 flips", "An edge of three tetrahedra gives way to a face",
                          &FlipCounts::flips32},
    CountInfo<FlipCounts>{"edge_removals", "edge_removals", "larger edge removals",
                          "An edge of four or more tetrahedra is removed", &FlipCounts::edge_removals},
    CountInfo<FlipCounts>{"face_removals", "face_removals", "face removals",
                          "Two or more faces between two vertices give way to the edge between them",
                          &FlipCounts::face_removals},
    CountInfo<FlipCounts>{
        "boundary_flips", "boundary_flips", "boundary flips",
        "An edge of the boundary or of an interface is flipped, between triangles that are coplanar or, "
        "with Boundary::slide, nearly so",
        &FlipCounts::boundary_flips}};

inline std::int64_t FlipCounts::flips() const {
  std::int64_t sum = 0;
  for (const auto& kind : kFlipCounts) sum += this->*kind.count;
  return sum;
}

inline FlipCounts& FlipCounts::operator+=(const FlipCounts& other) {
  for (const auto& kind : kFlipCounts) this->*kind.count += other.*kind.count;
  return *this;
}

/// Numbers of all changes of the connectivity, except for flips that `untangle` makes around inverted tetrahedra.
struct OperationCounts : FlipCounts {
  std::int64_t compound_flips = 0;
  std::int64_t vertices_inserted = 0, vertices_removed = 0;

  using FlipCounts::operator+=;
  OperationCounts& operator+=(const OperationCounts& other);
};

/// Those of kFlipCounts, then the others.
inline constexpr auto kOperationCounts = [] {
  using Info = CountInfo<OperationCounts>;
  constexpr std::array kOthers{Info{"compound_flips", "compound_flips", "compound flips",
                                    "A cavity is filled from one of its vertices, or an edge is removed together with "
                                    "a move of a vertex around it",
                                    &OperationCounts::compound_flips},
                               Info{"vertices_inserted", "vertices_inserted", "vertices inserted",
                                    "With Effort::best or SurfaceVertices::edit, and where curved elements are split",
                                    &OperationCounts::vertices_inserted},
                               Info{"vertices_removed", "vertices_removed", "vertices removed",
                                    "With Effort::best or SurfaceVertices::edit", &OperationCounts::vertices_removed}};
  std::array<Info, kFlipCounts.size() + kOthers.size()> all{};
  std::size_t n = 0;
  for (const auto& c : kFlipCounts) all[n++] = {c.name, c.key, c.title, c.text, c.count};
  for (const auto& c : kOthers) all[n++] = c;
  return all;
}();

inline OperationCounts& OperationCounts::operator+=(const OperationCounts& other) {
  for (const auto& kind : kOperationCounts) this->*kind.count += other.*kind.count;
  return *this;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/energy_law.hpp"
#include "core/links.hpp"
#include "core/quality_floor.hpp"
#include "core/types.hpp"
#include "par/buffer.hpp"

namespace tetune {

using par::Size;
using par::Span;

/// First vertex of a slot that holds no tetrahedron.
inline constexpr Index kFreeSlot = -1;

/// In vertex2original: of a vertex that is not the caller's, and of one that is in no tetrahedron any more.
inline constexpr Index kInserted = -1;
inline constexpr Index kRemoved = -2;

/// What kernels see of the mesh.
struct MeshView {
  Span<Point> points;
  Span<Tet> tet2vertex;
  Span<Links> tet2tet;
  Span<Index> tet2original;
  EnergyLaw law;
  QualityFloor floor;

  TETUNE_HD bool alive(Size slot) const { return tet2vertex[slot].v[0] != kFreeSlot; }
};

/// The mesh while it is optimised, in a backend's memory: vertices along a space-filling curve, tetrahedra by vertex.
/// Tetrahedra live in slots; flips free some and take new ones.
template <class Backend>
struct WorkMesh {
  template <class T>
  using Buffer = typename Backend::template Buffer<T>;

  Buffer<Point> points;
  Buffer<Tet> tet2vertex;
  Buffer<Links> tet2tet;
  /// Slot -> the caller's tetrahedron that was there, or that the one there descends from: of the same region always,
  /// as nothing crosses the faces between two.
  Buffer<Index> tet2original;
  /// Work vertex -> caller's vertex, kInserted or kRemoved.
  Buffer<Index> vertex2original;
  /// Slots without a tetrahedron: the first `free_count` entries.
  Buffer<Index> free_slots;
  Size free_count = 0;
  /// What the optimisation makes small.
  EnergyLaw law = kHarmonicLaw;
  /// What it must not go below.
  QualityFloor floor = QualityFloor::none();

  Size vertices() const { return points.size(); }
  Size slots() const { return tet2vertex.size(); }
  Size tets() const { return slots() - free_count; }
  /// Room for slots: that which flips take beyond those that there are is seldom more.
  Size room() const { return slots() + slots() / 16; }
  MeshView view() { return {points.span(), tet2vertex.span(), tet2tet.span(), tet2original.span(), law, floor}; }
};

}  // namespace tetune

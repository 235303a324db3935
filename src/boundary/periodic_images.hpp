// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/buffer.hpp"
#include "backend/span.hpp"
#include "math/vec3.hpp"
#include "mesh/periodic.hpp"

/// Images of periodic vertices, in work vertices (docs/method.md, "Periodic faces").
namespace tetune {

/// A vertex of a class, and its translation from the root.
struct PeriodicMember {
  Index vertex;
  Vec3 shift;
  TETUNE_HD Vec3 from_root(const Vec3& root) const { return root + shift; }
};

/// The classes as kernels access them, also those that do not move.
struct PeriodicImagesView {
  Span<const PeriodicMember> members;
  Span<const std::uint32_t> first;  ///< the members of class c are first[c] .. first[c + 1] - 1
  Span<const Index> vertex2class;   ///< -1: none; shorter than the number of vertices if some were inserted

  TETUNE_HD Index class_of(Index v) const { return v < vertex2class.size() ? vertex2class[v] : -1; }
  /// The translation of a vertex of a class from the root.
  TETUNE_HD Vec3 shift_of(Index v) const {
    std::uint32_t m = first[vertex2class[v]];
    while (members[m].vertex != v) ++m;
    return members[m].shift;
  }
  /// The image of a vertex by a translation, but for rounding; -1 if there is none.
  TETUNE_HD Index image_of(Index v, const Vec3& translation) const {
    const Vec3 shift = shift_of(v) + translation;
    const double tolerance = kMatchTolerance * norm(translation);
    const Index c = vertex2class[v];
    for (std::uint32_t m = first[c]; m < first[c + 1]; ++m) {
      if (members[m].vertex != v && norm(members[m].shift - shift) <= tolerance) return members[m].vertex;
    }
    return -1;
  }
};

template <class Backend>
struct PeriodicImages {
  BufferOf<Backend, PeriodicMember> members;
  BufferOf<Backend, std::uint32_t> first;
  BufferOf<Backend, Index> vertex2class;

  PeriodicImagesView view() const { return {members.span(), first.span(), vertex2class.span()}; }
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numeric>
#include <utility>
#include <vector>

#include "boundary/periodic_images.hpp"
#include "boundary/vertex_dofs.hpp"
#include "mesh/work_mesh.hpp"
#include "relocation/coloring.hpp"
#include "relocation/rings.hpp"

/// Classes of periodic vertices, whose members move together (docs/method.md, "Periodic faces"). For sweeps over
/// single vertices they are fixed.
namespace tetune {

/// The classes that move, as kernels access them.
struct PeriodicSetView : PeriodicImagesView {
  Span<const MotionSpace> space;  ///< per class, around its root
  /// The joint ring of a class: those of its members, moved to the root. Face i has the copies 3 i .. 3 i + 2.
  Span<const std::uint32_t> offsets;
  Span<const LinkFace> faces;
  Span<Point> copies;
};

template <class Backend>
struct PeriodicSet {
  template <class T>
  using Buffer = BufferOf<Backend, T>;
  PeriodicImages<Backend> images;
  Buffer<MotionSpace> space;
  Buffer<std::uint32_t> offsets;
  Buffer<LinkFace> faces;
  Buffer<Point> copies;
  /// The coloring of the classes: no two of one color share a tetrahedron.
  Coloring<Backend> coloring;

  Size classes() const { return space.size(); }
  PeriodicSetView view() {
    return {images.view(), std::as_const(space).span(), std::as_const(offsets).span(), std::as_const(faces).span(),
            copies.span()};
  }
};

/// The classes as relocation needs them. Their coloring is that of the set; `dofs` has the active vertices.
template <class Backend>
struct MovableClasses {
  RingsView rings;  ///< of single vertices
  PeriodicSet<Backend>& set;
  VertexDofs<Backend>& dofs;
};

namespace periodic_set_detail {

/// The number of faces of each joint ring. 0 for a class that cannot move at present: one of its members has no ring,
/// or a tetrahedron has two of its members.
struct CountFaces {
  PeriodicImagesView classes;
  RingsView rings;
  Span<std::uint32_t> counts;
  TETUNE_HD void operator()(Size c) const {
    std::uint32_t count = 0;
    bool can_move = true;
    for (std::uint32_t m = classes.first[c]; m < classes.first[c + 1]; ++m) {
      const Index v = classes.members[m].vertex;
      const std::uint32_t begin = rings.offsets[v];
      const std::uint32_t end = rings.offsets[v + 1];
      can_move = can_move && begin != end;
      count += end - begin;
      for (std::uint32_t i = begin; i < end && can_move; ++i) {
        for (int k = 0; k < 3; ++k) can_move = can_move && classes.class_of(rings.faces[i].v[k]) != c;
      }
    }
    counts[c] = can_move ? count : 0;
  }
};

/// Writes the faces of the joint rings, as indices of copies, and as classes of their vertices: the class itself where
/// a vertex has none.
struct WriteFaces {
  PeriodicSetView classes;
  RingsView rings;
  Span<LinkFace> faces;
  Span<LinkFace> class_faces;
  TETUNE_HD void operator()(Size c) const {
    std::uint32_t at = classes.offsets[c];
    if (at == classes.offsets[c + 1]) return;
    for (std::uint32_t m = classes.first[c]; m < classes.first[c + 1]; ++m) {
      const Index v = classes.members[m].vertex;
      for (std::uint32_t i = rings.offsets[v]; i < rings.offsets[v + 1]; ++i, ++at) {
        for (int k = 0; k < 3; ++k) {
          const Index other = classes.class_of(rings.faces[i].v[k]);
          faces[at].v[k] = to_index(3 * Size{at} + k);
          class_faces[at].v[k] = other < 0 ? to_index(c) : other;
        }
      }
    }
  }
};

/// Flags all members of a class of which one is flagged.
struct FlagWholeClass {
  PeriodicImagesView classes;
  Span<std::uint8_t> flags;
  TETUNE_HD void operator()(Size c) const {
    bool any = false;
    for (std::uint32_t m = classes.first[c]; m < classes.first[c + 1]; ++m) {
      any = any || flags[classes.members[m].vertex] != 0;
    }
    if (!any) return;
    for (std::uint32_t m = classes.first[c]; m < classes.first[c + 1]; ++m) flags[classes.members[m].vertex] = 1;
  }
};

}  // namespace periodic_set_detail

/// Extends a set of vertices by the images of its members.
template <class Backend>
void flag_images(const Backend& backend, PeriodicSet<Backend>& set, Span<std::uint8_t> flags) {
  if (set.classes() > 0) backend.for_each(set.classes(), periodic_set_detail::FlagWholeClass{set.images.view(), flags});
}

/// Builds the joint rings from the rings of the vertices, and colors the classes.
template <class Backend>
void refresh_periodic(const Backend& backend, const RingsView& rings, PeriodicSet<Backend>& set) {
  using namespace periodic_set_detail;
  const Size classes = set.classes();
  if (classes == 0) return;
  BufferOf<Backend, std::uint32_t> counts(backend, classes);
  backend.for_each(classes, CountFaces{set.images.view(), rings, counts});
  std::vector<std::uint32_t> offsets = counts.download();
  offsets.insert(offsets.begin(), 0);
  std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
  const Size faces = offsets.back();
  set.offsets.upload(backend, offsets);
  set.faces.resize(backend, faces);
  set.copies.resize(backend, 3 * faces);
  BufferOf<Backend, LinkFace> class_faces(backend, faces);
  backend.for_each(classes, WriteFaces{set.view(), rings, set.faces, class_faces});
  BufferOf<Backend, VertexDof> dof(backend, classes);
  backend.fill(dof.span(), VertexDof::plane);
  color_vertices(backend, RingsView{std::as_const(set.offsets).span(), std::as_const(class_faces).span()},
                 std::as_const(dof).span(), set.coloring);
}

}  // namespace tetune

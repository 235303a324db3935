// SPDX-License-Identifier: Apache-2.0
// Elements of a deck with the shape of a triangle: those that are faces of tetrahedra, and change with them.
#include <algorithm>
#include <map>

#include "io/inp/inp_scan.hpp"
#include "mesh/listed_faces.hpp"

namespace tetune {
namespace {

class InpTriangles {
 public:
  InpTriangles(const InpScan& scan, InpModel& model, TetMesh& mesh) : scan_(scan), model_(model), mesh_(mesh) {}

  void find() {
    if (model_.triangles.empty()) return;
    find_faces();
    for (const InpOther& other : scan_.others) {
      if (!other.type.is_triangle()) continue;
      const InpTriangle& t = span_of(model_.triangles)[model_.triangle(other.element)];
      if (!t.is_face) hold(t, other);
    }
  }

 private:
  /// Marks the faces of tetrahedra, of elements with the same vertices the first one.
  void find_faces() {
    const std::vector<Index> held = scan_.find_held_elements();
    std::map<std::array<Index, 3>, Index> first;
    for (Index i = 0; i < std::ssize(model_.triangles); ++i) {
      const InpTriangle& t = span_of(model_.triangles)[i];
      if (!is_listed(held, t.element)) first.try_emplace(ascending(t.vertices), i);
    }
    const ListedFaces<3> faces({first.begin(), first.end()}, mesh_.points.size());
    for (Index k = 0; k < std::ssize(mesh_.tets); ++k) {
      faces.find_in_tet(span_of(mesh_.tets)[k], [this, k](std::size_t opposite, Index i) {
        InpTriangle& t = span_of(model_.triangles)[i];
        if (t.tet >= 0) return;
        t.tet = k;
        t.opposite = int(opposite);
        t.is_face = !t.has_middles || has_middles_of_tets(t);
      });
    }
  }

  /// Whether the mid-side nodes of a triangle on tetrahedra are those of their edges.
  bool has_middles_of_tets(const InpTriangle& t) const {
    const InpOther& other = scan_.other(t.element);
    for (std::size_t k = 0; k < 3; ++k) {
      const Index node = model_.node(scan_.other_nodes[other.first_node + 3 + k]);
      const std::pair edge{ascending(t.vertices[k], t.vertices[(k + 1) % 3]), node};
      if (!std::binary_search(model_.middles.begin(), model_.middles.end(), edge)) return false;
    }
    return true;
  }

  /// Keeps an element that is no face, or that other cards name by number.
  void hold(const InpTriangle& t, const InpOther& other) {
    if (t.has_middles) return hold_nodes_of(other, scan_, model_, mesh_);
    mesh_.required_triangles.push_back(to_index(mesh_.triangles.size()));
    mesh_.triangles.push_back(t.vertices);
    mesh_.triangle_tags.push_back(0);
  }

  const InpScan& scan_;
  InpModel& model_;
  TetMesh& mesh_;
};

}  // namespace

void find_inp_triangles(const InpScan& scan, InpModel& model, TetMesh& mesh) { InpTriangles(scan, model, mesh).find(); }

}  // namespace tetune

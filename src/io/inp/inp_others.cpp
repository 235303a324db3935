// SPDX-License-Identifier: Apache-2.0
// Second-order elements of a deck other than tetrahedra: which of them a mesh can have.
#include <algorithm>
#include <set>

#include "backend/span.hpp"
#include "io/inp/inp_scan.hpp"
#include "io/second_order.hpp"
#include "mesh/tet.hpp"

namespace tetune {
namespace {

/// The mid-side nodes of a mesh with one node per edge and one edge per node.
class InpMiddleNodes {
 public:
  explicit InpMiddleNodes(InpScan& scan)
      : scan_(scan), is_vertex_(scan.model.points.size(), 0), node2edge_(scan.model.points.size(), {-1, -1}) {
    InpModel& model = scan.model;
    sort_unique(model.middles);
    for (const auto& [ends, node] : model.middles) span_of(node2edge_)[node] = ends;
    for (const auto& tet : model.tets) add_vertices(tet);
    for (const InpOther& other : scan.others) {
      using Role = InpElementType::Role;
      const Role role = other.type.role;
      if (role == Role::unknown || role == Role::quadratic_triangle || role == Role::quadratic_edge) continue;
      const std::vector<Index> nodes = nodes_of(other);
      const int vertices = other.type.kind == nullptr ? other.type.nodes : find_element_kind(other.type.kind)->vertices;
      add_vertices(std::span(nodes).first(std::min(nodes.size(), to_size_t(vertices))));
    }
  }

  /// Adds the mid-side nodes of an element; returns false where one of them, or a vertex, has another part, or where a
  /// vertex occurs twice.
  bool add(const InpOther& other) {
    const std::vector<Index> nodes = nodes_of(other);
    if (std::count(nodes.begin(), nodes.end(), -1) > 0) return true;  // the element is refused
    const ElementKind& kind = *find_element_kind(other.type.kind);
    const auto is_middle = [this](Index v) { return span_of(node2edge_)[v][0] >= 0; };
    MiddleList list;
    add_middles(nodes, kind.edges, list);
    const std::vector<Middle>& middles = list.nodes;
    const auto fits = [&](const Middle& m) {
      const auto ends = ascending(m.ends[0], m.ends[1]);
      if (ends[0] == ends[1]) return false;
      if (is_middle(m.node)) return span_of(node2edge_)[m.node] == ends;
      return span_of(is_vertex_)[m.node] == 0 && !has_middle(ends);
    };
    if (std::any_of(nodes.begin(), nodes.begin() + kind.vertices, is_middle) ||
        !std::all_of(middles.begin(), middles.end(), fits)) {
      return false;
    }
    for (const Middle& m : middles) {
      const auto ends = ascending(m.ends[0], m.ends[1]);
      if (!is_middle(m.node)) added_.insert(ends);
      span_of(node2edge_)[m.node] = ends;
    }
    return true;
  }

 private:
  /// The nodes of an element; -1 for those that are not defined.
  std::vector<Index> nodes_of(const InpOther& other) const {
    std::vector<Index> nodes;
    for (std::size_t i = other.first_node; i < other.end_node; ++i) {
      nodes.push_back(scan_.model.node(scan_.other_nodes[i]));
    }
    return nodes;
  }
  template <class Vertices>
  void add_vertices(const Vertices& vertices) {
    for (const Index v : vertices) {
      if (v >= 0) span_of(is_vertex_)[v] = 1;
    }
  }
  bool has_middle(const std::array<Index, 2>& ends) const {
    const auto& of_tets = scan_.model.middles;
    const auto at = std::lower_bound(of_tets.begin(), of_tets.end(), std::pair{ends, Index{0}});
    return (at != of_tets.end() && at->first == ends) || added_.contains(ends);
  }

  InpScan& scan_;
  std::vector<std::uint8_t> is_vertex_;
  std::vector<std::array<Index, 2>> node2edge_;
  std::set<std::array<Index, 2>> added_;  ///< edges that no tetrahedron has
};

}  // namespace

void hold_nodes_of(const InpOther& other, const InpScan& scan, InpModel& model, TetMesh& mesh) {
  ++model.text_elements;
  for (std::size_t i = other.first_node; i < other.end_node; ++i) {
    mesh.required_vertices.push_back(model.node(scan.other_nodes[i]));
  }
}

void hold_unfit_others(InpScan& scan) {
  const auto has_middles = [](const InpOther& other) { return other.type.has_middles(); };
  if (std::none_of(scan.others.begin(), scan.others.end(), has_middles)) return;
  const bool has_linear_tets = !scan.model.tets.empty() && !scan.model.is_second_order;
  InpMiddleNodes middles(scan);
  for (InpOther& other : scan.others) {
    if (has_middles(other) && (has_linear_tets || !middles.add(other))) {
      other.type.role = InpElementType::Role::unknown;
    }
  }
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Elements of a deck with the shape of an edge: those that are edges of tetrahedra are feature lines.
#include <algorithm>

#include "io/inp/inp_scan.hpp"
#include "io/second_order.hpp"
#include "mesh/listed_faces.hpp"

namespace tetune {
namespace {

class InpLines {
 public:
  InpLines(const InpScan& scan, InpModel& model, TetMesh& mesh) : scan_(scan), model_(model), mesh_(mesh) {}

  void find() {
    std::vector<Line> lines;
    for (const InpOther& other : scan_.others) {
      if (other.type.is_edge()) lines.push_back({&other, ends_of(other)});
    }
    if (lines.empty()) return;
    mark_edges_of_tets(lines);
    for (const Line& line : lines) add(line);
  }

 private:
  struct Line {
    const InpOther* other;
    std::array<Index, 2> ends;
    bool is_edge_of_tet = false;
  };

  Index node(const InpOther& other, std::size_t k) const {
    return model_.node(scan_.other_nodes[other.first_node + k]);
  }

  /// The vertices of an element: of one with a node in the middle, the second in most decks and the third in those that
  /// Gmsh writes, the ends of the edge of tetrahedra that has this node in its middle; -1 where there is none.
  std::array<Index, 2> ends_of(const InpOther& other) const {
    if (other.type.role == InpElementType::Role::edge) return {node(other, 0), node(other, 1)};
    if (other.end_node - other.first_node != 3) return {-1, -1};
    for (const std::size_t middle : {1, 2}) {
      const std::array<Index, 2> ends{node(other, 0), node(other, 3 - middle)};
      const std::pair edge{ascending(ends), node(other, middle)};
      if (std::binary_search(model_.middles.begin(), model_.middles.end(), edge)) return ends;
    }
    return {-1, -1};
  }

  /// Marks those that other cards do not name by number.
  void mark_edges_of_tets(std::vector<Line>& lines) const {
    const std::vector<Index> held = scan_.find_held_elements();
    std::vector<std::pair<std::array<Index, 2>, Index>> by_ends;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!is_listed(held, lines[i].other->element)) by_ends.emplace_back(lines[i].ends, to_index(i));
    }
    const ListedFaces<2> listed(std::move(by_ends), mesh_.points.size());
    for (const auto& tet : mesh_.tets) {
      if (listed.count_listed(tet) < 2) continue;
      for (const auto& [a, b] : kTetEdges) {
        listed.find({tet[to_size_t(a)], tet[to_size_t(b)]},
                    [&lines](Index i) { span_of(lines)[i].is_edge_of_tet = true; });
      }
    }
  }

  void add(const Line& line) {
    if (!line.is_edge_of_tet && line.other->type.role == InpElementType::Role::quadratic_edge)
      return hold_nodes_of(*line.other, scan_, model_, mesh_);
    const Index position = to_index(mesh_.edges.size());
    mesh_.edges.push_back(line.ends);
    mesh_.edge_tags.push_back(0);
    (line.is_edge_of_tet ? mesh_.ridges : mesh_.required_edges).push_back(position);
    if (line.is_edge_of_tet) model_.lines.emplace_back(line.other->element, position);
  }

  const InpScan& scan_;
  InpModel& model_;
  TetMesh& mesh_;
};

}  // namespace

void find_inp_lines(const InpScan& scan, InpModel& model, TetMesh& mesh) { InpLines(scan, model, mesh).find(); }

}  // namespace tetune

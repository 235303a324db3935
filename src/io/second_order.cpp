// SPDX-License-Identifier: Apache-2.0
#include "io/second_order.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "backend/span.hpp"
#include "io/plain_text.hpp"
#include "mesh/node_sets.hpp"
#include "mesh/sorted.hpp"
#include "mesh/surface_edges.hpp"
#include "mesh/tet.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// The largest distance of a node from the middle of its edge, relative to the edge, that rounding explains.
constexpr double kStraightInFile = 1e-4;

/// The values of vertex v.
template <class Values>
auto entry_of(Values& values, Index v, std::size_t each) {
  return std::span(values).subspan(to_size_t(v) * each, each);
}

std::size_t components_of(const DataArray& array) { return to_size_t(array.components); }

/// The number of a node in messages: its number in the file, or else its position, counted from 1.
std::int64_t shown_number(const NodeNumber& number_of, Index node) {
  return number_of ? number_of(node) : std::int64_t{node} + 1;
}

/// The edges whose node is not the midpoint in all bits; none if rounding explains all of them. Throws FileError where
/// one edge has two nodes, or one node two edges.
std::vector<CurvedEdge> find_curved(const std::vector<Middle>& middles, const std::vector<Point3>& points,
                                    const NodeNumber& number_of) {
  const auto is_curved = [&points](const Middle& m) {
    const Point3& p = span_of(points)[m.ends[0]];
    const Point3& q = span_of(points)[m.ends[1]];
    return !(distance(midpoint(p, q), span_of(points)[m.node]) <= kStraightInFile * distance(p, q));
  };
  if (std::none_of(middles.begin(), middles.end(), is_curved)) return {};
  std::vector<std::pair<std::array<Index, 2>, Index>> nodes;
  for (const Middle& m : middles) nodes.emplace_back(ascending(m.ends[0], m.ends[1]), m.node);
  sort_unique(nodes);
  std::vector<std::uint8_t> taken(points.size(), 0);
  std::vector<CurvedEdge> curved;
  std::array<Index, 2> last{-1, -1};
  for (const auto& [edge, node] : nodes) {
    if (edge == last || std::exchange(span_of(taken)[node], std::uint8_t{1}) != 0) {
      throw FileError("node " + std::to_string(shown_number(number_of, node)) +
                      " is a mid-side node of two edges, or one of two nodes of the same edge" +
                      (number_of ? "" : " (nodes are counted from 1)") +
                      "; repair the second-order elements in the program that made them");
    }
    last = edge;
    const Point3& middle = span_of(points)[node];
    if (middle != midpoint(span_of(points)[edge[0]], span_of(points)[edge[1]])) curved.push_back({edge, middle});
  }
  return curved;
}

/// Finds the mid-side nodes that are in a set of nodes: those of edges with both ends in it, but where the edge leads
/// through the inside from one point of the surface to another, only if all vertices of the tetrahedra around it are in
/// the set too. A set of the surface does not get nodes inside of a thin part.
class SetMiddles {
 public:
  /// The edges of tetrahedra that lead through the inside are needed for sets of nodes alone.
  explicit SetMiddles(const TetMesh& mesh) {
    if (std::none_of(mesh.point_data.begin(), mesh.point_data.end(), is_node_set)) return;
    const SurfaceEdges surface(mesh);
    for (const auto& tet : mesh.tets) {
      for (const auto& [i, j] : kTetEdges) {
        const Index a = tet[to_size_t(i)];
        const Index b = tet[to_size_t(j)];
        if (!surface.is_across(a, b)) continue;
        for (const Index v : tet) {
          if (v != a && v != b) across_.push_back({ascending(a, b), v});
        }
      }
    }
    sort_unique(across_);
  }

  template <class T>
  bool has(const std::vector<T>& is_member, Index a, Index b) const {
    if (span_of(is_member)[a] == 0 || span_of(is_member)[b] == 0) return false;
    const auto ends = ascending(a, b);
    auto at = std::lower_bound(across_.begin(), across_.end(), std::pair{ends, Index{-1}});
    for (; at != across_.end() && at->first == ends; ++at) {
      if (span_of(is_member)[at->second] == 0) return false;
    }
    return true;
  }

 private:
  /// Such edges, each with the other vertices of the tetrahedra around it, in increasing order.
  std::vector<std::pair<std::array<Index, 2>, Index>> across_;
};

/// The value of component c of data at the node in the middle of an edge, from those at both ends.
template <class T>
T middle_value(const DataArray& array, const std::vector<T>& values, std::size_t c, const std::array<Index, 2>& ends,
               const SetMiddles& sets) {
  const std::size_t each = components_of(array);
  const T x = entry_of(values, ends[0], each)[c];
  if constexpr (std::is_floating_point_v<T>) return T((x + entry_of(values, ends[1], each)[c]) / 2);
  if (!is_node_set(array)) return x;
  return sets.has(values, ends[0], ends[1]) ? T{1} : T{0};
}

/// Whether the values of an array at mid-side nodes are those that Middles adds, to rounding.
bool are_restored(const DataArray& array, const std::vector<Middle>& middles, const SetMiddles& sets) {
  const std::size_t each = components_of(array);
  const auto is_restored = [&array, each, &sets](const auto& values, const Middle& m) {
    using T = typename std::remove_cvref_t<decltype(values)>::value_type;
    constexpr double kRounding = std::is_same_v<T, float> ? 1e-5 : 1e-10;
    for (std::size_t c = 0; c < each; ++c) {
      const T x = entry_of(values, m.ends[0], each)[c], y = entry_of(values, m.ends[1], each)[c];
      const T found = entry_of(values, m.node, each)[c], restored = middle_value(array, values, c, m.ends, sets);
      if constexpr (std::is_floating_point_v<T>) {
        const double scale = std::max(std::fabs(double{x}), std::fabs(double{y}));
        if (std::fabs(double{found} - double{restored}) > kRounding * scale) return false;
      } else if (found != restored) {
        return false;
      }
    }
    return true;
  };
  return std::visit(
      [&](const auto& values) {
        return std::all_of(middles.begin(), middles.end(), [&](const Middle& m) { return is_restored(values, m); });
      },
      array.values);
}

/// The warning of erase_middles().
std::string lost_values(const std::vector<Middle>& middles, const TetMesh& mesh) {
  std::vector<std::string> names;
  const SetMiddles sets(mesh);
  for (const DataArray& array : mesh.point_data) {
    if (!are_restored(array, middles, sets)) names.push_back(array.name);
  }
  const auto has_tag = [&mesh](const Middle& m) { return span_of(mesh.point_tags)[m.node] != 0; };
  if (std::any_of(middles.begin(), middles.end(), has_tag)) names.emplace_back("tags");
  if (names.empty()) return {};
  return "values at mid-side nodes are not kept: " + listed_texts(names) +
         "; writers give these nodes the means of both ends, the integers of one end, the sets of their edge, and no "
         "tag";
}

/// The warning of erase_middles() on elements that lack nodes; empty where all have them.
std::string gained_middles(const MiddleList& middles, const TetMesh& mesh) {
  std::string counts;
  const auto add = [&](std::size_t elements, std::size_t dimension, std::string_view name) {
    const std::size_t complete = middles.complete[dimension];
    if (complete >= elements) return;
    counts.append(counts.empty() ? "" : ", ").append(std::to_string(elements - complete));
    counts.append(" of the ").append(name);
  };
  add(mesh.tets.size(), 3, "tetrahedra");
  add(mesh.triangles.size(), 2, "triangles");
  add(mesh.edges.size(), 1, "edges");
  if (counts.empty()) return {};
  return "elements that lack mid-side nodes get them on writing, as other elements have them: " + counts;
}

template <class Function>
void for_each_list(TetMesh& mesh, const Function& f) {
  for (auto& tet : mesh.tets) f(tet.data(), tet.size());
  for (auto& triangle : mesh.triangles) f(triangle.data(), triangle.size());
  for (auto& edge : mesh.edges) f(edge.data(), edge.size());
  for (ElementBlock& block : mesh.others) f(block.element2vertex.data(), block.element2vertex.size());
  f(mesh.corners.data(), mesh.corners.size());
  f(mesh.required_vertices.data(), mesh.required_vertices.size());
}

/// Tetrahedra without mid-side nodes would get some on writing.
void refuse_linear_tets(const TetMesh& mesh) {
  if (mesh.second_order || mesh.tets.empty()) return;
  const auto block = std::find_if(mesh.others.begin(), mesh.others.end(),
                                  [](const ElementBlock& b) { return b.second_order && !b.tags.empty(); });
  if (block == mesh.others.end()) return;
  throw FileError("the tetrahedra are of first order, but the " + std::to_string(block->tags.size()) + " " +
                  block->kind + " have mid-side nodes; give the tetrahedra mid-side nodes, or take those of the " +
                  block->kind + " out");
}

}  // namespace

std::span<const Pair> edges_of_kind(std::string_view name, MiddleOrder order) {
  static constexpr std::array<Pair, 9> kPrism{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 4}, {2, 5}, {3, 4}, {4, 5}, {5, 3}}};
  static constexpr std::array<Pair, 12> kHex{
      {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 5}, {2, 6}, {3, 7}, {4, 5}, {5, 6}, {6, 7}, {7, 4}}};
  static constexpr std::array<Pair, 8> kGmshPyramid{{{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 4}, {2, 3}, {2, 4}, {3, 4}}};
  static constexpr std::array<Pair, 9> kGmshPrism{
      {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 4}, {2, 5}, {3, 4}, {3, 5}, {4, 5}}};
  static constexpr std::array<Pair, 12> kGmshHex{
      {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}}};
  const ElementKind* const kind = find_element_kind(name);
  if (kind == nullptr) return {};
  if (kind->name == "Pyramids" && order == MiddleOrder::gmsh) return kGmshPyramid;
  if (kind->name == "Prisms" && order != MiddleOrder::base_top_between) {
    return order == MiddleOrder::gmsh ? kGmshPrism : kPrism;
  }
  if (kind->name == "Hexahedra" && order != MiddleOrder::base_top_between) {
    return order == MiddleOrder::gmsh ? kGmshHex : kHex;
  }
  return kind->edges;
}

void add_middles(std::span<const Index> nodes, std::span<const Pair> edges, MiddleList& middles) {
  const std::size_t vertices = nodes.size() - edges.size();
  const std::size_t before = middles.nodes.size();
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Index node = nodes[vertices + e];
    if (node < 0) continue;
    middles.nodes.push_back({node, {nodes[to_size_t(edges[e][0])], nodes[to_size_t(edges[e][1])]}});
  }
  const std::size_t added = middles.nodes.size() - before;
  // A simplex has an edge for each pair of its vertices.
  if (added == 0 || 2 * edges.size() != vertices * (vertices - 1)) return;
  middles.has_simplices = true;
  if (added == edges.size()) ++middles.complete[vertices - 1];
}

std::vector<std::uint8_t> middle_flags(const MiddleList& middles, std::size_t n) {
  std::vector<std::uint8_t> flags(n, 0);
  for (const Middle& m : middles.nodes) span_of(flags)[m.node] = 1;
  return flags;
}

std::vector<std::string> erase_middles(const MiddleList& list, TetMesh& mesh, const NodeNumber& number_of) {
  const std::vector<Middle>& middles = list.nodes;
  if (middles.empty()) return {};
  mesh.second_order = mesh.second_order || list.has_simplices;
  refuse_linear_tets(mesh);
  mesh.second_order = true;
  mesh.curved_edges = find_curved(middles, mesh.points, number_of);
  std::vector<Index> old2new(mesh.points.size(), 0);
  for (const Middle& m : middles) span_of(old2new)[m.node] = -1;
  const auto check = [&](const Index* ids, std::size_t n) {
    for (const Index v : std::span(ids, n)) {
      if (v < 0 || to_size_t(v) >= old2new.size()) throw FileError("an element has a node that does not exist");
      if (span_of(old2new)[v] >= 0) continue;
      throw FileError("node " + std::to_string(shown_number(number_of, v)) + (number_of ? "" : ", counted from 1,") +
                      " is in the middle of one element's edge and a vertex of another element; give all elements the "
                      "same order");
    }
  };
  for_each_list(mesh, check);
  std::vector<std::string> warnings{lost_values(middles, mesh), gained_middles(list, mesh)};
  std::erase(warnings, std::string());
  std::vector<Index> new2old;
  for (std::size_t v = 0; v < old2new.size(); ++v) {
    if (old2new[v] < 0) continue;
    old2new[v] = to_index(new2old.size());
    new2old.push_back(Index(v));
  }
  for (PeriodicLink& link : mesh.periodic) {
    std::erase_if(link.pairs,
                  [&](const auto& pair) { return span_of(old2new)[pair[0]] < 0 || span_of(old2new)[pair[1]] < 0; });
    for (auto& pair : link.pairs) pair = {span_of(old2new)[pair[0]], span_of(old2new)[pair[1]]};
  }
  const auto take = [&new2old](auto& values, std::size_t each) {
    for (std::size_t v = 0; v < new2old.size(); ++v) {
      std::copy_n(entry_of(values, new2old[v], each).begin(), each, &values[v * each]);
    }
    values.resize(new2old.size() * each);
  };
  take(mesh.points, 1);
  take(mesh.point_tags, 1);
  for (DataArray& array : mesh.point_data) {
    std::visit([&](auto& values) { take(values, components_of(array)); }, array.values);
  }
  for_each_list(mesh, [&](Index* ids, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) ids[i] = span_of(old2new)[ids[i]];
  });
  // The numbers keep their order.
  for (CurvedEdge& edge : mesh.curved_edges) {
    for (Index& v : edge.vertices) v = span_of(old2new)[v];
  }
  return warnings;
}

std::string lost_middles(const TetMesh& mesh) {
  std::string text = "written as linear elements, without the nodes in the middles of edges";
  if (!mesh.curved_edges.empty())
    text += "; " + std::to_string(mesh.curved_edges.size()) + " curved edges are straight";
  return text;
}

Middles::Middles(TetMesh& mesh, MiddlesOf elements) : first_(to_index(mesh.points.size())) {
  const auto add = [this](const Index* v, const auto& pairs) {
    for (const Pair& p : pairs) edges_.push_back(ascending(v[p[0]], v[p[1]]));
  };
  for (const auto& tet : mesh.tets) add(tet.data(), kTetEdges);
  if (elements != MiddlesOf::tets_and_others) {
    for (const auto& triangle : mesh.triangles) add(triangle.data(), kTriangleEdges);
  }
  if (elements == MiddlesOf::all) {
    for (const auto& edge : mesh.edges) add(edge.data(), kEdgeEdges);
  }
  for_each_other_middle(mesh, [this](Index a, Index b) { edges_.push_back(ascending(a, b)); });
  sort_unique(edges_);
  for (const auto& [a, b] : edges_) {
    const Point3 middle = midpoint(span_of(mesh.points)[a], span_of(mesh.points)[b]);
    mesh.points.push_back(middle);
  }
  for (const CurvedEdge& edge : mesh.curved_edges) {
    const auto& [a, b] = edge.vertices;
    if (std::binary_search(edges_.begin(), edges_.end(), edge.vertices)) span_of(mesh.points)[of(a, b)] = edge.middle;
  }
  mesh.point_tags.resize(mesh.points.size(), 0);
  const SetMiddles sets(mesh);
  for (DataArray& array : mesh.point_data) {
    const std::size_t each = components_of(array);
    std::visit(
        [&](auto& values) {
          values.reserve(mesh.points.size() * each);
          for (const auto& ends : edges_) {
            for (std::size_t c = 0; c < each; ++c) values.push_back(middle_value(array, values, c, ends, sets));
          }
        },
        array.values);
  }
}

bool Middles::has(Index a, Index b) const { return std::binary_search(edges_.begin(), edges_.end(), ascending(a, b)); }

Index Middles::of(Index a, Index b) const {
  return first_ + to_index(std::lower_bound(edges_.begin(), edges_.end(), ascending(a, b)) - edges_.begin());
}

void Middles::extend(PeriodicLink& link) const {
  std::map<Index, Index> master_of;
  for (const auto& [vertex, master] : link.pairs) master_of[vertex] = master;
  for (const auto& [a, b] : edges_) {
    const auto p = master_of.find(a);
    const auto q = master_of.find(b);
    if (p == master_of.end() || q == master_of.end()) continue;
    const auto master = ascending(p->second, q->second);
    if (std::binary_search(edges_.begin(), edges_.end(), master))
      link.pairs.push_back({of(a, b), of(master[0], master[1])});
  }
}

std::string lost_curved_edges(const TetMesh& mesh, const Middles* middles) {
  if (middles == nullptr) return {};
  const auto has_no_node = [middles](const CurvedEdge& e) { return !middles->has(e.vertices[0], e.vertices[1]); };
  const auto straight = std::count_if(mesh.curved_edges.begin(), mesh.curved_edges.end(), has_no_node);
  if (straight == 0) return {};
  return std::to_string(straight) +
         " curved edges of no other element are straight: the format has no mid-side nodes of edges";
}

}  // namespace tetune

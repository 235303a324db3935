// SPDX-License-Identifier: Apache-2.0
#include "boundary/constraints.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "backend/span.hpp"
#include "mesh/sorted.hpp"
#include "mesh/tet.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// 1 for each listed edge that constrains.
std::vector<std::uint8_t> constraining_edges(const TetMesh& mesh) {
  std::vector<std::uint8_t> constrains(mesh.edges.size(), 0);
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) constrains[e] = mesh.edge_tags[e] != 0 ? 1 : 0;
  for (const Index e : mesh.ridges) span_of(constrains)[e] = 1;
  for (const Index e : mesh.required_edges) span_of(constrains)[e] = 1;
  return constrains;
}

/// Appends the elements with one of the tags. A tag without elements is an error: the caller meant a part of the mesh.
void add_tagged(const std::vector<int>& element_tags, const std::vector<int>& wanted, const char* option,
                const char* what, std::vector<Index>& elements) {
  std::map<int, std::vector<Index>> tag2elements;
  for (const int tag : wanted) tag2elements[tag];
  for (Size i = 0; i < std::ssize(element_tags) && !wanted.empty(); ++i) {
    const auto found = tag2elements.find(span_of(element_tags)[i]);
    if (found != tag2elements.end()) found->second.push_back(to_index(i));
  }
  for (const int tag : wanted) {
    const std::vector<Index>& tagged = tag2elements[tag];
    if (tagged.empty()) {
      throw OptionError(std::string(option) + "=" + std::to_string(tag) + ": no " + what + " has this tag");
    }
    elements.insert(elements.end(), tagged.begin(), tagged.end());
  }
}

/// The edges that remain edges: ridges and required ones first.
void find_edges(const TetMesh& mesh, Constraints& constraints) {
  std::vector<std::array<Index, 2>> ridges;
  for (const std::vector<Index>* ids : {&mesh.ridges, &mesh.required_edges}) {
    for (const Index e : *ids) ridges.push_back(ascending(span_of(mesh.edges)[e]));
  }
  sort_unique(ridges);
  std::vector<std::array<Index, 2>> tagged;
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    if (mesh.edge_tags[e] != 0) tagged.push_back(ascending(mesh.edges[e]));
  }
  sort_unique(tagged);
  constraints.edges = ridges;
  constraints.ridges = ridges.size();
  std::set_difference(tagged.begin(), tagged.end(), ridges.begin(), ridges.end(),
                      std::back_inserter(constraints.edges));
}

/// Calls mark(vertex) for the ends and junctions of a set of edges, each of which counts once.
template <class Mark>
void for_each_end(std::vector<std::array<Index, 2>> edges, const Mark& mark) {
  sort_unique(edges);
  std::vector<Index> ends;
  for (const auto& edge : edges) ends.insert(ends.end(), edge.begin(), edge.end());
  std::sort(ends.begin(), ends.end());
  for (auto first = ends.begin(); first != ends.end();) {
    const auto last = std::upper_bound(first, ends.end(), *first);
    if (last - first != 2) mark(*first);
    first = last;
  }
}

/// Marks ends and junctions of the edges of each named group and of each tag, so that each keeps its extent.
void mark_line_ends(const TetMesh& mesh, Span<VertexConstraint> constraints) {
  std::vector<std::pair<int, Index>> tag2edge;
  for (Index e = 0; e < std::ssize(mesh.edges); ++e) {
    if (span_of(mesh.edge_tags)[e] != 0) tag2edge.emplace_back(span_of(mesh.edge_tags)[e], e);
  }
  std::sort(tag2edge.begin(), tag2edge.end());
  const auto edge_of = [&mesh](const auto& entry) { return ascending(span_of(mesh.edges)[entry.second]); };
  const auto mark = [constraints](VertexConstraint constraint) {
    return [constraints, constraint](Index v) {
      if (constraints[v] == VertexConstraint::none) constraints[v] = constraint;
    };
  };
  for (const Group& group : mesh.groups) {
    if (group.dimension != 1 || group.name.empty()) continue;
    const std::set<int> tags(group.tags.begin(), group.tags.end());
    std::vector<std::array<Index, 2>> edges;
    for (const int tag : tags) {
      auto entry = std::lower_bound(tag2edge.begin(), tag2edge.end(), std::pair{tag, Index{0}});
      for (; entry != tag2edge.end() && entry->first == tag; ++entry) edges.push_back(edge_of(*entry));
    }
    for_each_end(std::move(edges), mark(VertexConstraint::corner));
  }
  for (auto first = tag2edge.begin(); first != tag2edge.end();) {
    const int tag = first->first;
    std::vector<std::array<Index, 2>> edges;
    for (; first != tag2edge.end() && first->first == tag; ++first) edges.push_back(edge_of(*first));
    for_each_end(std::move(edges), mark(VertexConstraint::line_end));
  }
}

/// Sets Constraints::required_triangles.
void find_required_triangles(const TetMesh& mesh, Constraints& constraints) {
  std::vector<std::uint8_t> required(mesh.triangles.size(), 0);
  for (const Index t : mesh.required_triangles) span_of(required)[t] = 1;
  std::vector<std::pair<Index, Index>> vertex2triangle;  // by the first vertex of each
  if (!mesh.periodic.empty()) {
    for (Index t = 0; t < std::ssize(required); ++t) vertex2triangle.emplace_back(span_of(mesh.triangles)[t][0], t);
  }
  std::sort(vertex2triangle.begin(), vertex2triangle.end());
  std::vector<std::uint8_t> is_paired(mesh.points.size(), 0);
  const Span<std::uint8_t> sides = span_of(is_paired);
  for (const PeriodicLink& link : mesh.periodic) {
    if (link.dimension != 2) continue;
    for (const auto& [vertex, master] : link.pairs) {
      sides[vertex] |= 1;
      sides[master] |= 2;
    }
    for (const auto& pair : link.pairs) {
      for (const Index v : pair) {
        auto entry = std::lower_bound(vertex2triangle.begin(), vertex2triangle.end(), std::pair{v, Index{0}});
        for (; entry != vertex2triangle.end() && entry->first == v; ++entry) {
          const auto& [a, b, c] = span_of(mesh.triangles)[entry->second];
          if ((sides[a] & sides[b] & sides[c]) != 0) span_of(required)[entry->second] = 1;
        }
      }
    }
    for (const auto& pair : link.pairs) {
      for (const Index v : pair) sides[v] = 0;
    }
  }
  const bool any = std::find(required.begin(), required.end(), 1) != required.end();
  if (any) constraints.required_triangles = std::move(required);
}

}  // namespace

void check_frozen_vertices(const TetMesh& mesh, const Options& options) {
  if (options.frozen_vertices.empty() || options.frozen_vertices.size() == mesh.points.size()) return;
  throw OptionError("frozen_vertices has " + std::to_string(options.frozen_vertices.size()) + " entries for " +
                    std::to_string(mesh.points.size()) + " vertices; it must have one per vertex, or none");
}

Constraints find_constraints(const TetMesh& mesh, const Options& options) {
  Constraints result;
  result.vertices.assign(mesh.points.size(), VertexConstraint::none);
  const Span<VertexConstraint> constraints = span_of(result.vertices);
  for (const Index v : mesh.corners) constraints[v] = VertexConstraint::corner;
  const auto freeze = [constraints](const auto& vertices) {
    for (const Index v : vertices) constraints[v] = VertexConstraint::frozen;
  };
  freeze(mesh.required_vertices);
  for (const Index e : mesh.required_edges) freeze(span_of(mesh.edges)[e]);
  for (const Index t : mesh.required_triangles) freeze(span_of(mesh.triangles)[t]);
  find_required_triangles(mesh, result);
  result.locked_tets = mesh.required_tets;
  add_tagged(mesh.tet_tags, options.frozen_regions, "frozen_regions", "tetrahedron", result.locked_tets);
  for (const Index t : result.locked_tets) freeze(span_of(mesh.tets)[t]);
  std::vector<Index> patches;
  add_tagged(mesh.triangle_tags, options.frozen_patches, "frozen_patches", "triangle", patches);
  for (const Index t : patches) freeze(span_of(mesh.triangles)[t]);
  check_frozen_vertices(mesh, options);
  for (std::size_t v = 0; v < options.frozen_vertices.size(); ++v) {
    if (options.frozen_vertices[v] != 0) result.vertices[v] = VertexConstraint::frozen;
  }
  for (const ElementBlock& block : mesh.others) freeze(block.element2vertex);
  mark_line_ends(mesh, constraints);
  if (!mesh.periodic.empty()) result.vertices_without_links = result.vertices;
  for (const PeriodicLink& link : mesh.periodic) {
    for (const auto& pair : link.pairs) freeze(pair);
  }
  find_edges(mesh, result);
  return result;
}

OtherElements::OtherElements(const TetMesh& mesh) {
  std::size_t element = 0;
  for (const ElementBlock& block : mesh.others) {
    const std::size_t vertices_per_element = to_size_t(std::max(1, block.vertices_per_element));
    for (std::size_t i = 0; i < block.element2vertex.size(); ++i) {
      vertex2element_.emplace_back(block.element2vertex[i], element + i / vertices_per_element);
    }
    element += block.element2vertex.size() / vertices_per_element;
  }
  std::sort(vertex2element_.begin(), vertex2element_.end());
}

std::span<const std::pair<Index, std::size_t>> OtherElements::of(Index vertex) const {
  const auto begin =
      std::lower_bound(vertex2element_.begin(), vertex2element_.end(), std::pair{vertex, std::size_t{0}});
  const auto end = std::find_if(begin, vertex2element_.end(), [vertex](const auto& e) { return e.first != vertex; });
  return std::span(vertex2element_).subspan(std::size_t(begin - vertex2element_.begin()), std::size_t(end - begin));
}

bool OtherElements::any_has(std::span<const Index> vertices) const {
  const auto candidates = of(vertices[0]);
  return std::any_of(candidates.begin(), candidates.end(), [&](const auto& candidate) {
    return std::all_of(vertices.begin() + 1, vertices.end(), [&](Index v) {
      return std::binary_search(vertex2element_.begin(), vertex2element_.end(), std::pair{v, candidate.second});
    });
  });
}

std::vector<std::uint8_t> lasting_edges(const TetMesh& mesh, const std::vector<std::array<Index, 4>>& tets,
                                        const OtherElements& others) {
  std::vector<std::uint8_t> keep = constraining_edges(mesh);
  std::vector<std::array<Index, 2>> sought;
  for (std::size_t e = 0; e < keep.size(); ++e) {
    if (keep[e] == 0 && others.have(mesh.edges[e])) keep[e] = 1;
    if (keep[e] == 0) sought.push_back(ascending(mesh.edges[e]));
  }
  if (sought.empty()) return keep;
  std::sort(sought.begin(), sought.end());
  std::vector<std::uint8_t> found(sought.size(), 0);
  const auto position_of = [&sought](const std::array<Index, 2>& edge) {
    return std::lower_bound(sought.begin(), sought.end(), edge) - sought.begin();
  };
  for (const auto& tet : tets) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        const auto edge = ascending(tet[i], tet[j]);
        for (Size at = position_of(edge); at < std::ssize(sought) && span_of(sought)[at] == edge; ++at) {
          span_of(found)[at] = 1;
        }
      }
    }
  }
  for (std::size_t e = 0; e < keep.size(); ++e) {
    if (keep[e] == 0) keep[e] = span_of(found)[position_of(ascending(mesh.edges[e]))];
  }
  return keep;
}

}  // namespace tetune

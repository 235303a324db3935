// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mesh/element_kinds.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The edges of a tetrahedron, triangle and edge in the order in which second-order elements of VTK and Exodus number
/// their middle nodes. Gmsh's tetrahedron has the last two exchanged.
inline constexpr std::array<Pair, 6> kTetEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
inline constexpr std::array<Pair, 6> kGmshTetEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {2, 3}, {1, 3}}};
inline constexpr std::array<Pair, 3> kTriangleEdges{{{0, 1}, {1, 2}, {2, 0}}};
inline constexpr std::array<Pair, 1> kEdgeEdges{{{0, 1}}};

/// The order in which a format numbers the nodes in the middles of the edges of other kinds.
enum class MiddleOrder : std::uint8_t {
  base_top_between,  ///< Abaqus, CalculiX, VTK: ElementKind::edges
  base_between_top,  ///< Nastran, Exodus
  gmsh,              ///< by the vertices of the edges
};
/// The edges of a kind of ElementBlock in the order of a format; none for points and other names.
std::span<const Pair> edges_of_kind(std::string_view kind, MiddleOrder order);

/// What readers say of quadrilaterals, pyramids, prisms and hexahedra with more nodes than those on edges.
inline constexpr const char* kNodesOnFaces =
    "elements with nodes in the middles of faces are not read; make them with nodes in the middles of edges alone "
    "(Gmsh: Mesh.SecondOrderIncomplete = 1)";

/// A node in the middle of an edge.
struct Middle {
  Index node;
  std::array<Index, 2> ends;
};

/// The mid-side nodes that a reader finds.
struct MiddleList {
  std::vector<Middle> nodes;  ///< one per edge of each element that has them
  /// The number of edges, triangles and tetrahedra with a node on each edge, by dimension.
  std::array<std::size_t, 4> complete{};
  bool has_simplices = false;  ///< an edge, triangle or tetrahedron has such a node
};

/// Lists the nodes in the middles of the edges of an element. `nodes`: its vertices, then a node per edge, or -1 where
/// an edge of a simplex has none.
void add_middles(std::span<const Index> nodes, std::span<const Pair> edges, MiddleList& middles);

/// Returns 1 for mid-side nodes, and 0 for the others of n nodes.
std::vector<std::uint8_t> middle_flags(const MiddleList& middles, std::size_t n);

/// Returns the number of a node in its file, for messages.
using NodeNumber = std::function<std::int64_t(Index node)>;

/// Erases the nodes in the middles of edges, their data and their periodic pairs, and lists the curved edges. Returns
/// warnings, if Middles would not restore their data or tags, and if it gives nodes to elements that lack some. A mesh
/// is straight if no node is farther than 1e-4 of the edge from the midpoint. TetMesh::second_order becomes true.
/// Throws FileError where tetrahedra have none, but other elements, unless TetMesh::second_order is true before; where
/// a node is a vertex of another element; or where a curved mesh has two nodes on an edge or two edges at a node.
/// `number_of`: empty where nodes have no numbers; messages then count them from 1.
std::vector<std::string> erase_middles(const MiddleList& middles, TetMesh& mesh, const NodeNumber& number_of = {});

/// The warning of writers of linear elements.
std::string lost_middles(const TetMesh& mesh);

/// The elements of a second-order mesh to which a format gives mid-side nodes: tetrahedra, other elements of second
/// order, listed triangles and listed edges, or the first ones of these.
enum class MiddlesOf : std::uint8_t { all, all_but_edges, tets_and_others };

/// Adds a node in the middle of each edge of these elements, after all other nodes; on a curved edge at the listed
/// position. Its data are the means of both ends, or the integers of the first end, and it has no tag. It is in the
/// sets of nodes that both ends are in; where its edge leads through the inside from one point of the surface to
/// another, only if all vertices of the tetrahedra around the edge are in the set.
class Middles {
 public:
  explicit Middles(TetMesh& mesh, MiddlesOf elements = MiddlesOf::all);
  /// The number of vertices, which precede the nodes.
  std::size_t vertices() const { return to_size_t(first_); }
  /// The node in the middle of an edge of the mesh.
  Index of(Index a, Index b) const;
  bool is_middle(Index v) const { return v >= first_; }
  /// Whether all edges of a triangle or tetrahedron have nodes.
  template <std::size_t n>
  bool has(const std::array<Index, n>& element) const {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (!has(element[i], element[j])) return false;
      }
    }
    return true;
  }
  bool has(Index a, Index b) const;
  /// Adds the pairs of the nodes in the middles of paired edges.
  void extend(PeriodicLink& link) const;

 private:
  std::vector<std::array<Index, 2>> edges_;
  Index first_ = 0;
};

/// The warning of formats without mid-side nodes of edges, on listed edges that are curved and of no other element.
/// Empty where there are none, or no `middles`.
std::string lost_curved_edges(const TetMesh& mesh, const Middles* middles);

/// Calls write(mesh, middles): of a mesh of first order with null, of one of second order with a copy that has its
/// mid-side nodes, and these.
template <class Write>
void write_with_middles(const TetMesh& mesh, MiddlesOf elements, const Write& write) {
  if (!mesh.second_order) return write(mesh, nullptr);
  TetMesh with_middles = mesh;
  const Middles middles(with_middles, elements);
  write(with_middles, &middles);
}

/// The most nodes of an element, a hexahedron of second order.
inline constexpr std::size_t kMaxNodes = 20;

/// Writes the nodes of a tetrahedron, triangle or edge as files list them: the vertices, in the order of the input, and
/// where there are `middles` those in the middles of `edges`.
template <std::size_t N, std::size_t E>
void list_simplex(const TetMesh& mesh, std::array<Index, N> vertices, const Middles* middles,
                  const std::array<Pair, E>& edges, std::array<Index, kMaxNodes>& nodes) {
  if constexpr (N == 4) {
    if (mesh.listed_inside_out) std::swap(vertices[2], vertices[3]);
  }
  std::copy(vertices.begin(), vertices.end(), nodes.begin());
  if (middles == nullptr) return;
  for (std::size_t k = 0; k < E; ++k) {
    nodes[N + k] = middles->of(vertices[std::size_t(edges[k][0])], vertices[std::size_t(edges[k][1])]);
  }
}

/// Writes the nodes of an element of another kind likewise. The block is of second order where there are `edges`.
inline void list_other(const ElementBlock& block, std::size_t element, const Middles* middles,
                       std::span<const Pair> edges, std::array<Index, kMaxNodes>& nodes) {
  const std::size_t vertices = to_size_t(block.vertices_per_element);
  const auto of_element = std::span(block.element2vertex).subspan(element * vertices, vertices);
  std::copy(of_element.begin(), of_element.end(), nodes.begin());
  for (std::size_t k = 0; k < edges.size(); ++k) {
    nodes[vertices + k] = middles->of(of_element[std::size_t(edges[k][0])], of_element[std::size_t(edges[k][1])]);
  }
}

/// The edges of the elements of a block whose middles are nodes, in the order of a format.
inline std::span<const Pair> middle_edges(const TetMesh& mesh, const ElementBlock& block, MiddleOrder order) {
  return has_middles(mesh, block) ? edges_of_kind(block.kind, order) : std::span<const Pair>();
}

}  // namespace tetune

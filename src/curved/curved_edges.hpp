// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "curved/jacobian.hpp"
#include "mesh/tet.hpp"
#include "tetune/mesh.hpp"

namespace tetune {

/// The order of lists of curved edges: by their vertices.
inline bool is_before(const CurvedEdge& e, const CurvedEdge& f) { return e.vertices < f.vertices; }

/// An edge, with vertices in ascending order, in a sorted list; null where the list lacks it.
const CurvedEdge* find_edge(const std::vector<CurvedEdge>& sorted, const std::array<Index, 2>& edge);

/// Replaces edges of a sorted list by the changed ones with the same vertices, and adds those that it lacks.
void merge_edges(std::vector<CurvedEdge>& sorted, std::vector<CurvedEdge> changed);

/// An edge whose mid-side node was computed is straight if the node is at most this far from the midpoint, relative to
/// the length of the edge.
inline constexpr double kStraight = 1e-12;

/// Whether the mid-side node is at most `tolerance` times the length of the edge from the midpoint, with an allowance
/// for the rounding of coordinates to 15 digits, as in text.
bool is_straight(const TetMesh& mesh, const CurvedEdge& edge, double tolerance);

/// The curved edges of a mesh by their vertices. Refers to the mesh.
class CurvedEdges {
 public:
  explicit CurvedEdges(const TetMesh& mesh);
  /// The mid-side node of an edge: that of a curved edge, or the midpoint.
  Vec3 middle(Index a, Index b) const;
  /// Null for a straight edge.
  const CurvedEdge* find(Index a, Index b) const;
  bool has_curved(const std::array<Index, 4>& tet) const;
  TenNodes nodes(const std::array<Index, 4>& tet) const;

 private:
  const TetMesh& mesh_;
  std::vector<Index> first_;  ///< per vertex, its first edge in the list; one entry more
};

/// The tetrahedra with a curved edge, in ascending order.
std::vector<Index> curved_tets(const TetMesh& mesh, const CurvedEdges& edges);

/// measure_curved_each() of listed tetrahedra, for a mesh that has been checked.
std::vector<CurvedTet> measure_tets(const TetMesh& mesh, const CurvedEdges& edges, const std::vector<Index>& tets,
                                    int threads);

/// measure_curved_each(), for a mesh that has been checked.
std::vector<CurvedTet> measure_curved_tets(const TetMesh& mesh, int threads);

/// The ids of tetrahedra that are not proved valid.
std::vector<Index> not_valid(const std::vector<CurvedTet>& tets);
/// The tetrahedra that are not proved valid, of a mesh that has been checked.
std::vector<Index> find_invalid(const TetMesh& mesh, int threads);
/// The ids of tetrahedra that are not proved valid, or whose scaled Jacobian is below a limit.
std::vector<Index> not_valid_or_below(const std::vector<CurvedTet>& tets, double limit);

/// Summary of all curved tetrahedra of a mesh that has been checked.
CurvedQuality summarize_curved(const TetMesh& mesh, int threads, int worst);

}  // namespace tetune

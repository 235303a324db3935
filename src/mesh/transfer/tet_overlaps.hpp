// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "backend/cpu.hpp"
#include "mesh/transfer/tet_overlap.hpp"
#include "tetune/mesh.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// An input mesh and a result of it in one configuration: the vertices of the result are at their places in the input.
struct TransferMeshes {
  std::vector<Vec3> old_points, new_points;
  Span<const std::array<Index, 4>> old_tets, new_tets;
  std::vector<Index> vertex2old;  ///< of the result to the input, of vertices at the place of one; else -1
  /// Per tetrahedron of the result, the one of the input with the same vertices at the same places; -1: none.
  std::vector<Index> tet2same;
  Span<const int> regions;         ///< per tetrahedron of the input
  Span<const Index> tet2original;  ///< as of Report

  TransferMeshes(const TetMesh& input, const std::vector<std::array<Index, 4>>& tets, const std::vector<Index>& origins,
                 const std::vector<MeshPlace>& places);
  TetPoints old_tet(Index t) const { return corners(old_points, old_tets[t]); }
  TetPoints new_tet(Index t) const { return corners(new_points, new_tets[t]); }

 private:
  static TetPoints corners(const std::vector<Vec3>& points, const std::array<Index, 4>& tet) {
    return {span_of(points)[tet[0]], span_of(points)[tet[1]], span_of(points)[tet[2]], span_of(points)[tet[3]]};
  }
};

/// The overlaps of the changed tetrahedra of a result with those of the input in the same region. Entry i of `tets` has
/// the pairs offsets[i] .. offsets[i + 1] - 1.
struct TetOverlaps {
  std::vector<Index> tets;  ///< of the result
  std::vector<Size> offsets;
  std::vector<Index> old;       ///< per pair: the tetrahedron of the input
  std::vector<double> volumes;  ///< per pair
  /// Per tetrahedron of the input: its volume, and the part that the result covers, which is 1 up to rounding where
  /// both meshes fill the same space.
  std::vector<double> old_volumes, covered;
  /// Tetrahedra of the input that the result does not cover at all, each with the entry of `tets` nearest to it.
  std::vector<std::pair<Index, Size>> uncovered_tets;
  double uncovered = 0;  ///< part of the input's volume that the result does not cover
};

/// Receives each pair: the entry of `tets`, the tetrahedron of the input, and their overlap. Calls for one entry come
/// in order, and those for different entries concurrently.
using OverlapVisitor = std::function<void(Size, Index, const TetOverlap&)>;

/// The result does not depend on the number of threads. `begin(tets)` is called once before the first visit. Nothing is
/// returned once cpu.stop_requested(), which all threads call.
std::optional<TetOverlaps> find_overlaps(const backend::Cpu& cpu, const TransferMeshes& meshes, Moments moments,
                                         const std::function<void(const std::vector<Index>&)>& begin,
                                         const OverlapVisitor& visit);

}  // namespace tetune

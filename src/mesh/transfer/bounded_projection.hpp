// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "backend/cpu.hpp"
#include "mesh/transfer/projection_sums.hpp"
#include "mesh/transfer/tet_overlaps.hpp"

namespace tetune {

/// The L2 projection of linear fields on a result. It keeps integrals, and each value is within the range of those of
/// the input around it: where the projection exceeds this range, its difference from that with a lumped mass matrix
/// is limited as in flux-corrected transport (docs/method.md, "Conservative transfer"). Vertices of unchanged
/// tetrahedra alone keep their values.
class BoundedProjection {
 public:
  BoundedProjection(const backend::Cpu& cpu, const TransferMeshes& meshes, const TetOverlaps& overlaps,
                    const ProjectionSums& sums);

  /// Sets a field at the vertices of changed tetrahedra. `old`: at the vertices of the input. `result` has values at
  /// all vertices of the result before; they stay where no tetrahedron of the input overlaps.
  void project(Size field, const std::vector<double>& old, std::vector<double>& result);

 private:
  void find_vertices();
  void set_couplings();
  /// Assembles the entries of the mass matrix off its diagonal; `entries`: that of each changed tetrahedron.
  void set_rows(const std::vector<double>& entries);
  void gather(Size field, const std::vector<double>& old, const std::vector<double>& result);
  void solve();
  void limit();

  /// Calls visit(j, c) for the vertices j that share a changed tetrahedron with vertex i, with the entry of the mass
  /// matrix that it adds.
  template <class Visit>
  void for_neighbors(Size i, const Visit& visit) const {
    for (Size k = span_of(rows_)[i]; k < span_of(rows_)[i + 1]; ++k) {
      visit(span_of(columns_)[k], span_of(couplings_)[k]);
    }
  }
  /// Row i of the product of the mass matrix with x.
  double product(Size i, Span<const double> x) const {
    double sum = span_of(mass_)[i] * x[i];
    for_neighbors(i, [&](Index j, double c) { sum += c * (x[j] - x[i]); });
    return sum;
  }

  const backend::Cpu& cpu_;
  const TransferMeshes& meshes_;
  const TetOverlaps& overlaps_;
  const ProjectionSums& sums_;
  std::vector<Index> vertices_;                ///< of changed tetrahedra; "vertex i" is the entry i
  std::vector<std::array<Index, 4>> corners_;  ///< of each changed tetrahedron
  std::vector<Size> offsets_, stars_;          ///< per vertex: its places in corners_, 4 per tetrahedron
  /// The entries of the mass matrix off its diagonal: those of vertex i are rows_[i] .. rows_[i + 1] - 1.
  std::vector<Size> rows_;
  std::vector<Index> columns_;
  std::vector<double> couplings_;
  std::vector<double> mass_;       ///< per vertex, lumped
  std::vector<double> kept_mass_;  ///< per vertex: of the unchanged tetrahedra alone
  std::vector<double> diagonal_;   ///< of the mass matrix
  std::vector<double> integrals_, low_, high_, lumped_, projected_, limited_;
};

}  // namespace tetune

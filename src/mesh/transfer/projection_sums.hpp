// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "mesh/transfer/tet_overlaps.hpp"

namespace tetune {

/// The right-hand side of an L2 projection of linear fields: for each corner of the changed tetrahedra of a result the
/// integrals of its basis function, and of its product with each field on the input.
class ProjectionSums {
 public:
  /// `values`: `fields` in succession for each vertex of the input, all finite.
  ProjectionSums(const TransferMeshes& meshes, Span<const double> values, Size fields)
      : meshes_(meshes), values_(values), fields_(fields) {}

  /// As `begin` and `visit` of find_overlaps().
  void begin(const std::vector<Index>& tets);
  void add(Size entry, Index old, const TetOverlap& common);

  /// Accounts for the parts of the input that the result does not cover, or covers twice: scales the contributions so
  /// that each basis function of the input contributes its integral over each tetrahedron in full.
  void complete(const TetOverlaps& overlaps);

  double mass(Size entry, Size corner) const { return span_of(mass_)[4 * entry + corner]; }
  double integral(Size entry, Size corner, Size field) const {
    return span_of(integrals_)[(4 * entry + corner) * fields_ + field];
  }
  /// The range of the field in the tetrahedra of the input that overlap; empty (low > high) if there is none.
  double low(Size entry, Size field) const { return span_of(low_)[entry * fields_ + field]; }
  double high(Size entry, Size field) const { return span_of(high_)[entry * fields_ + field]; }

 private:
  double value(Index vertex, Size field) const { return values_[vertex * fields_ + field]; }
  /// Adds the integrals of the products of the four basis functions with that of a vertex of the input.
  void add_vertex(Size entry, Index vertex, const std::array<double, 4>& products);
  void extend_range(Size entry, Index old);

  const TransferMeshes& meshes_;
  const Span<const double> values_;
  const Size fields_;
  std::vector<double> volumes_;
  std::vector<double> mass_, integrals_, low_, high_;
};

}  // namespace tetune

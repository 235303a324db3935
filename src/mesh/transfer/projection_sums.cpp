// SPDX-License-Identifier: Apache-2.0
#include "mesh/transfer/projection_sums.hpp"

#include <algorithm>
#include <cmath>

#include "math/constants.hpp"

namespace tetune {
namespace {

/// The products of the four basis functions of a tetrahedron of the result with the function of corner j.
std::array<double, 4> column(const TetOverlap& common, std::size_t j, double factor) {
  std::array<double, 4> products{};
  for (std::size_t i = 0; i < 4; ++i) products[i] = factor * common.moments[i][j];
  return products;
}

}  // namespace

void ProjectionSums::begin(const std::vector<Index>& tets) {
  for (const Index t : tets) volumes_.push_back(std::fabs(six_volume(meshes_.new_tet(t))) / 6);
  const std::size_t n = tets.size();
  mass_.assign(4 * n, 0);
  integrals_.assign(4 * n * to_size_t(fields_), 0);
  low_.assign(n * to_size_t(fields_), kInfinity);
  high_.assign(n * to_size_t(fields_), -kInfinity);
}

void ProjectionSums::add(Size entry, Index old, const TetOverlap& common) {
  for (std::size_t j = 0; j < 4; ++j) {
    add_vertex(entry, meshes_.old_tets[old][j], column(common, j, span_of(volumes_)[entry]));
  }
  extend_range(entry, old);
}

void ProjectionSums::add_vertex(Size entry, Index vertex, const std::array<double, 4>& products) {
  for (Size i = 0; i < 4; ++i) {
    const double product = products[to_size_t(i)];
    span_of(mass_)[4 * entry + i] += product;
    double* integral = &span_of(integrals_)[(4 * entry + i) * fields_];
    for (Size f = 0; f < fields_; ++f) integral[f] += product * value(vertex, f);
  }
}

void ProjectionSums::extend_range(Size entry, Index old) {
  for (Size f = 0; f < fields_; ++f) {
    double& low = span_of(low_)[entry * fields_ + f];
    double& high = span_of(high_)[entry * fields_ + f];
    for (const Index v : meshes_.old_tets[old]) {
      low = std::min(low, value(v, f));
      high = std::max(high, value(v, f));
    }
  }
}

void ProjectionSums::complete(const TetOverlaps& overlaps) {
  constexpr double kRounding = 1e-12;
  struct Pair {
    Size entry;
    Index old;
    TetOverlap common;
  };
  std::vector<Pair> partial;
  std::vector<std::array<double, 4>> sums(to_size_t(meshes_.old_tets.size()));
  for (Size entry = 0; entry < std::ssize(overlaps.tets); ++entry) {
    for (Size p = span_of(overlaps.offsets)[entry]; p < span_of(overlaps.offsets)[entry + 1]; ++p) {
      const Index old = span_of(overlaps.old)[p];
      if (std::fabs(span_of(overlaps.covered)[old] - 1) < kRounding) continue;
      const TetPoints x = meshes_.new_tet(span_of(overlaps.tets)[entry]);
      partial.push_back({entry, old, overlap(TetFrame(x), TetFrame(meshes_.old_tet(old)), Moments::computed)});
      for (std::size_t j = 0; j < 4; ++j) {
        for (const double product : column(partial.back().common, j, span_of(volumes_)[entry])) {
          span_of(sums)[old][j] += product;
        }
      }
    }
  }
  for (const Pair& pair : partial) {
    for (std::size_t j = 0; j < 4; ++j) {
      const double full = span_of(overlaps.old_volumes)[pair.old] / 4;
      const double factor = full / span_of(sums)[pair.old][j] - 1;
      add_vertex(pair.entry, meshes_.old_tets[pair.old][j],
                 column(pair.common, j, factor * span_of(volumes_)[pair.entry]));
    }
  }
  for (const auto& [old, entry] : overlaps.uncovered_tets) {
    const double share = span_of(overlaps.old_volumes)[old] / 16;
    for (const Index v : meshes_.old_tets[old]) add_vertex(entry, v, {share, share, share, share});
    extend_range(entry, old);
  }
}

}  // namespace tetune

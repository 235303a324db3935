// SPDX-License-Identifier: Apache-2.0
#include "mesh/transfer/bounded_projection.hpp"

#include <algorithm>
#include <cmath>

#include "math/constants.hpp"

namespace tetune {
namespace {

/// The sum of f(i) for i in [0, n), which does not depend on the number of threads.
template <class F>
double sum_over(const backend::Cpu& cpu, Size n, const F& f) {
  return cpu.reduce<Sum<double>>(n, [&](Size i) { return Sum<double>{f(i)}; }).value;
}

}  // namespace

BoundedProjection::BoundedProjection(const backend::Cpu& cpu, const TransferMeshes& meshes, const TetOverlaps& overlaps,
                                     const ProjectionSums& sums)
    : cpu_(cpu), meshes_(meshes), overlaps_(overlaps), sums_(sums) {
  find_vertices();
  set_couplings();
}

void BoundedProjection::find_vertices() {
  std::vector<Index> vertex2entry(meshes_.new_points.size(), -1);
  for (const Index t : overlaps_.tets) {
    for (const Index v : meshes_.new_tets[t]) span_of(vertex2entry)[v] = 0;
  }
  for (Index v = 0; v < std::ssize(vertex2entry); ++v) {
    if (span_of(vertex2entry)[v] < 0) continue;
    span_of(vertex2entry)[v] = to_index(vertices_.size());
    vertices_.push_back(v);
  }
  offsets_.assign(vertices_.size() + 1, 0);
  for (const Index t : overlaps_.tets) {
    corners_.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) {
      corners_.back()[k] = span_of(vertex2entry)[meshes_.new_tets[t][k]];
      ++span_of(offsets_)[corners_.back()[k] + 1];
    }
  }
  for (std::size_t i = 0; i < vertices_.size(); ++i) offsets_[i + 1] += offsets_[i];
  stars_.resize(4 * corners_.size());
  std::vector<Size> next = offsets_;
  for (Size place = 0; place < std::ssize(stars_); ++place) {
    span_of(stars_)[span_of(next)[span_of(corners_)[place / 4][to_size_t(place % 4)]]++] = place;
  }
  kept_mass_.assign(vertices_.size(), 0);
  for (Index t = 0; t < meshes_.new_tets.size(); ++t) {
    if (span_of(meshes_.tet2same)[t] < 0) continue;
    for (const Index v : meshes_.new_tets[t]) {
      const Index i = span_of(vertex2entry)[v];
      if (i >= 0) span_of(kept_mass_)[i] += volume(meshes_.new_tet(t)) / 4;
    }
  }
}

/// The mass matrix of a changed tetrahedron is scaled down where its vertices have less mass than its volume says, so
/// that the matrix stays positive definite.
void BoundedProjection::set_couplings() {
  const Size n = std::ssize(vertices_);
  mass_.assign(to_size_t(n), 0);
  diagonal_.assign(to_size_t(n), 0);
  std::vector<double> volumes;
  for (const Index t : overlaps_.tets) volumes.push_back(volume(meshes_.new_tet(t)));
  std::vector<double> ratio(to_size_t(n), 0);
  for (Size i = 0; i < n; ++i) {
    double full = 0;
    for (Size s = span_of(offsets_)[i]; s < span_of(offsets_)[i + 1]; ++s) {
      const Size place = span_of(stars_)[s];
      span_of(mass_)[i] += sums_.mass(place / 4, place % 4);
      full += span_of(volumes)[place / 4] / 4;
    }
    span_of(ratio)[i] = full > 0 ? std::min(1.0, span_of(mass_)[i] / full) : 0;
    span_of(mass_)[i] += span_of(kept_mass_)[i];
  }
  std::vector<double> entries;
  for (Size entry = 0; entry < std::ssize(corners_); ++entry) {
    double factor = 1;
    for (const Index i : span_of(corners_)[entry]) factor = std::min(factor, span_of(ratio)[i]);
    entries.push_back(factor * span_of(volumes)[entry] / 20);
  }
  set_rows(entries);
  for (Size i = 0; i < n; ++i) {
    span_of(diagonal_)[i] = span_of(mass_)[i];
    for_neighbors(i, [&](Index, double c) { span_of(diagonal_)[i] -= c; });
  }
}

void BoundedProjection::set_rows(const std::vector<double>& entries) {
  rows_.assign(1, 0);
  for (Size i = 0; i < std::ssize(vertices_); ++i) {
    const auto begin = std::ssize(columns_);
    for (Size s = span_of(offsets_)[i]; s < span_of(offsets_)[i + 1]; ++s) {
      const Size entry = span_of(stars_)[s] / 4;
      for (const Index j : span_of(corners_)[entry]) {
        if (j == i) continue;
        const Size k = std::find(columns_.begin() + begin, columns_.end(), j) - columns_.begin();
        if (k == std::ssize(columns_)) {
          columns_.push_back(j);
          couplings_.push_back(0);
        }
        span_of(couplings_)[k] += span_of(entries)[entry];
      }
    }
    rows_.push_back(std::ssize(columns_));
  }
}

void BoundedProjection::gather(Size field, const std::vector<double>& old, const std::vector<double>& result) {
  const std::size_t n = vertices_.size();
  integrals_.assign(n, 0);
  lumped_.assign(n, 0);
  low_.assign(n, kInfinity);
  high_.assign(n, -kInfinity);
  cpu_.for_each(std::ssize(vertices_), [&](Size i) {
    double sum = 0;
    double low = kInfinity;
    double high = -low;
    for (Size s = span_of(offsets_)[i]; s < span_of(offsets_)[i + 1]; ++s) {
      const Size place = span_of(stars_)[s];
      sum += sums_.integral(place / 4, place % 4, field);
      low = std::min(low, sums_.low(place / 4, field));
      high = std::max(high, sums_.high(place / 4, field));
    }
    const Index v = span_of(vertices_)[i];
    if (span_of(kept_mass_)[i] > 0) {
      const double kept = span_of(old)[span_of(meshes_.vertex2old)[v]];
      sum += span_of(kept_mass_)[i] * kept;
      low = std::min(low, kept);
      high = std::max(high, kept);
    }
    const bool overlaps = low <= high && span_of(mass_)[i] > 0;
    span_of(low_)[i] = overlaps ? low : span_of(result)[v];
    span_of(high_)[i] = overlaps ? high : span_of(result)[v];
    span_of(integrals_)[i] = overlaps ? sum : 0;
    span_of(lumped_)[i] = overlaps ? sum / span_of(mass_)[i] : span_of(result)[v];
  });
}

/// Conjugate gradients with Jacobi's preconditioner, which bounds the condition number of the mass matrix by 5 (Wathen
/// 1987), from the values of the lumped mass matrix.
void BoundedProjection::solve() {
  constexpr int kMaxIterations = 200;
  constexpr double kTolerance = 1e-15;
  const Size n = std::ssize(vertices_);
  projected_ = lumped_;
  std::vector<double> residual(to_size_t(n)), direction(to_size_t(n), 0), image(to_size_t(n));
  const auto preconditioned = [&](Size i) {
    const double d = span_of(diagonal_)[i];
    return d > 0 ? span_of(residual)[i] / d : 0;
  };
  cpu_.for_each(n, [&](Size i) {
    const bool has_mass = span_of(mass_)[i] > 0;
    span_of(residual)[i] = has_mass ? span_of(integrals_)[i] - product(i, span_of(projected_)) : 0;
  });
  const double scale = sum_over(cpu_, n, [&](Size i) {
    const double x = span_of(lumped_)[i];
    return span_of(mass_)[i] * x * x;
  });
  double rho = sum_over(cpu_, n, [&](Size i) { return span_of(residual)[i] * preconditioned(i); });
  double beta = 0;
  for (int iteration = 0; iteration < kMaxIterations && rho > kTolerance * kTolerance * scale; ++iteration) {
    cpu_.for_each(n, [&](Size i) { span_of(direction)[i] = preconditioned(i) + beta * span_of(direction)[i]; });
    cpu_.for_each(n, [&](Size i) { span_of(image)[i] = product(i, span_of(direction)); });
    const double curvature = sum_over(cpu_, n, [&](Size i) { return span_of(direction)[i] * span_of(image)[i]; });
    if (!(curvature > 0)) break;
    const double step = rho / curvature;
    cpu_.for_each(n, [&](Size i) {
      span_of(projected_)[i] += step * span_of(direction)[i];
      span_of(residual)[i] -= step * span_of(image)[i];
    });
    const double last = rho;
    rho = sum_over(cpu_, n, [&](Size i) { return span_of(residual)[i] * preconditioned(i); });
    beta = rho / last;
  }
}

/// The projection is the lumped one and, from each neighbor j to i, a flux c (p_i - p_j). Fluxes of vertices at which
/// the sum exceeds the bounds are limited (Zalesak 1979), which can make others exceed theirs, until there are none.
void BoundedProjection::limit() {
  constexpr double kRounding = 1e-13;
  const Size n = std::ssize(vertices_);
  double largest = 0;
  for (Size i = 0; i < n; ++i) {
    largest = std::max({largest, std::fabs(span_of(low_)[i]), std::fabs(span_of(high_)[i])});
  }
  // Factors of the fluxes that raise and that lower the value of a vertex.
  std::vector<double> raise(to_size_t(n), 1), lower(to_size_t(n), 1);
  const auto flux = [&](Size i, Index j, double c) { return c * (span_of(projected_)[i] - span_of(projected_)[j]); };
  const auto set_factors = [&](Size i) {
    double up = 0;
    double down = 0;
    for_neighbors(i, [&](Index j, double c) { (flux(i, j, c) > 0 ? up : down) += flux(i, j, c); });
    const double room_up = span_of(mass_)[i] * (span_of(high_)[i] - span_of(lumped_)[i]);
    const double room_down = span_of(mass_)[i] * (span_of(low_)[i] - span_of(lumped_)[i]);
    span_of(raise)[i] = up > 0 ? std::clamp(room_up / up, 0.0, 1.0) : 1;
    span_of(lower)[i] = down < 0 ? std::clamp(room_down / down, 0.0, 1.0) : 1;
  };
  std::vector<std::uint8_t> is_limited(to_size_t(n), 0);
  limited_.assign(to_size_t(n), 0);
  for (bool changed = true; changed;) {
    cpu_.for_each(n, [&](Size i) {
      double sum = 0;
      for_neighbors(i, [&](Index j, double c) {
        const double f = flux(i, j, c);
        sum += f * (f > 0 ? std::min(span_of(raise)[i], span_of(lower)[j])
                          : std::min(span_of(lower)[i], span_of(raise)[j]));
      });
      const double mass = span_of(mass_)[i];
      span_of(limited_)[i] = span_of(lumped_)[i] + (mass > 0 ? sum / mass : 0);
    });
    changed = false;
    for (Size i = 0; i < n; ++i) {
      const double x = span_of(limited_)[i];
      const double slack = kRounding * largest;
      if (span_of(is_limited)[i] != 0 || (x >= span_of(low_)[i] - slack && x <= span_of(high_)[i] + slack)) continue;
      span_of(is_limited)[i] = 1;
      set_factors(i);
      changed = true;
    }
  }
  for (Size i = 0; i < n; ++i) {
    span_of(limited_)[i] = std::clamp(span_of(limited_)[i], span_of(low_)[i], span_of(high_)[i]);
  }
}

void BoundedProjection::project(Size field, const std::vector<double>& old, std::vector<double>& result) {
  gather(field, old, result);
  solve();
  limit();
  for (Size i = 0; i < std::ssize(vertices_); ++i) span_of(result)[span_of(vertices_)[i]] = span_of(limited_)[i];
}

}  // namespace tetune

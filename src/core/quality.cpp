// SPDX-License-Identifier: Apache-2.0
#include "tetune/quality.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/types.hpp"
#include "core/unit_scale.hpp"
#include "core/validate_arrays.hpp"
#include "par/cpu.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

constexpr double kDegrees = 57.29577951308232;
constexpr int kBinsPerDegree = 100;
constexpr std::size_t kBins = 180 * kBinsPerDegree + 1;
/// Tetrahedra are measured in parts of this many, each with its own counts; sums then run over the parts in order.
constexpr par::Size kParts = 64;

struct Part {
  std::vector<std::int64_t> bins = std::vector<std::int64_t>(kBins, 0);
  double min = 180, max = 0, sum = 0;
  par::Size worst = -1;
  double eta_sum = 0, shape_sum = 0, ratio_sum = 0, ratio_min = 1, volume = 0;
};

/// `scale` is a power of two that keeps products of coordinates in range.
void measure(const TetMesh& mesh, double scale, par::Size t, Part& part, double& eta) {
  const auto& tet = mesh.tets[static_cast<std::size_t>(t)];
  Vec3 p[4];
  for (int k = 0; k < 4; ++k) {
    p[k] = scale * vec(mesh.points[static_cast<std::size_t>(tet[static_cast<std::size_t>(k)])]);
  }
  Vec3 n[4];
  double area2 = 0;
  for (int f = 0; f < 4; ++f) {
    const Vec3& a = p[face_vertex(f, 0)];
    n[f] = 0.5 * cross(p[face_vertex(f, 1)] - a, p[face_vertex(f, 2)] - a);
    area2 += dot(n[f], n[f]);
  }
  const double volume = dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) / 6;
  double length2 = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const double angle = kDegrees * std::atan2(norm(cross(n[i], n[j])), -dot(n[i], n[j]));
      ++part.bins[static_cast<std::size_t>(angle * kBinsPerDegree)];
      part.sum += angle;
      if (angle < part.min) {
        part.min = angle;
        part.worst = t;
      }
      part.max = std::max(part.max, angle);
      const Vec3 e = p[j] - p[i];
      length2 += dot(e, e);
    }
  }
  eta = area2 / std::fabs(volume);
  part.eta_sum += eta;
  // eta of the regular tetrahedron of this volume: its edge is (6 sqrt(2) V)^(1/3), its eta 9 edge / sqrt(2).
  const double shape = eta / (4.5 * std::numbers::sqrt2 * std::cbrt(6 * std::numbers::sqrt2 * std::fabs(volume)));
  part.shape_sum += shape * std::sqrt(shape);
  const double ratio = volume > 0 ? 12 * std::cbrt(9 * volume * volume) / length2 : 0;
  part.ratio_sum += ratio;
  part.ratio_min = std::min(part.ratio_min, ratio);
  part.volume += volume;
}

double percentile(const std::vector<std::int64_t>& bins, std::int64_t count, double share) {
  const auto wanted = static_cast<std::int64_t>(share * static_cast<double>(count));
  std::int64_t below = 0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    below += bins[b];
    if (below > wanted) return (static_cast<double>(b) + 0.5) / kBinsPerDegree;
  }
  return 180;
}

}  // namespace

Quality quality(const TetMesh& mesh, int threads) {
  if (const ValidationReport arrays = validate_arrays(mesh); !arrays.ok()) throw MeshError(arrays.message(false));
  Quality q;
  const auto tets = static_cast<par::Size>(mesh.tets.size());
  q.tets = tets;
  if (tets == 0) return q;
  const double scale = unit_scale(mesh);
  std::vector<double> eta(mesh.tets.size());
  std::vector<Part> parts(static_cast<std::size_t>(kParts));
  const par::Cpu cpu(threads);
  cpu.for_parts(kParts, [&](par::Size p) {
    Part& part = parts[static_cast<std::size_t>(p)];
    for (par::Size t = tets * p / kParts; t < tets * (p + 1) / kParts; ++t) {
      measure(mesh, scale, t, part, eta[static_cast<std::size_t>(t)]);
    }
  });
  Part total;
  for (const Part& part : parts) {
    for (std::size_t b = 0; b < kBins; ++b) total.bins[b] += part.bins[b];
    if (part.min < total.min) {
      total.min = part.min;
      total.worst = part.worst;
    }
    total.max = std::max(total.max, part.max);
    total.sum += part.sum;
    total.eta_sum += part.eta_sum;
    total.shape_sum += part.shape_sum;
    total.ratio_sum += part.ratio_sum;
    total.ratio_min = std::min(total.ratio_min, part.ratio_min);
    total.volume += part.volume;
  }
  const std::int64_t angles = 6 * tets;
  q.dihedral_min = total.min;
  q.worst_tet = static_cast<Index>(total.worst);
  q.dihedral_1 = percentile(total.bins, angles, 0.01);
  q.dihedral_5 = percentile(total.bins, angles, 0.05);
  q.dihedral_mean = total.sum / static_cast<double>(angles);
  q.dihedral_max = total.max;
  q.eta_sum = total.eta_sum / scale;
  q.shape_sum = total.shape_sum;
  q.eta_max = *std::max_element(eta.begin(), eta.end()) / scale;
  const auto at95 =
      eta.begin() + static_cast<std::ptrdiff_t>(
                        std::min(mesh.tets.size() - 1, static_cast<std::size_t>(0.95 * static_cast<double>(tets))));
  std::nth_element(eta.begin(), at95, eta.end());
  q.eta_95 = *at95 / scale;
  q.mean_ratio = total.ratio_sum / static_cast<double>(tets);
  q.mean_ratio_min = total.ratio_min;
  q.volume = total.volume / scale / scale / scale;
  for (std::size_t b = 0; b < kBins; ++b) {
    q.histogram[std::min<std::size_t>(17, b / (10 * kBinsPerDegree))] +=
        static_cast<double>(total.bins[b]) / static_cast<double>(angles);
  }
  return q;
}

}  // namespace tetune

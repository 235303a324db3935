// SPDX-License-Identifier: Apache-2.0
#include "tetune/quality.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>

#include "core/fetch_ahead.hpp"
#include "core/gather.hpp"
#include "core/tet_measures.hpp"
#include "core/types.hpp"
#include "core/unit_scale.hpp"
#include "core/validate_arrays.hpp"
#include "par/cpu.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

constexpr int kBinsPerDegree = 100;
constexpr std::size_t kBins = 180 * kBinsPerDegree + 1;
/// Counts of angles.
using Bins = std::vector<std::uint32_t>;
static_assert(6 * std::int64_t{kMaxTets} <= std::numeric_limits<std::uint32_t>::max());
/// Tetrahedra are measured in parts, each with its own counts; sums then run over the parts in order. A part's counts
/// take as long as some hundred tetrahedra.
par::Size part_count(par::Size tets) { return std::clamp<par::Size>(tets / 512, 1, 64); }
par::Size part_begin(par::Size tets, par::Size part) { return tets * part / part_count(tets); }

struct Part {
  double min = 180, max = 0, sum = 0;
  par::Size worst = -1;
  double eta_sum = 0, shape_sum = 0, ratio_sum = 0, ratio_min = 1, volume = 0;
};

constexpr int kLanes = kLanesOf<par::Pack>;

/// Some tetrahedra in a row, one a lane; the last one again where there are no more. For loops over all of them.
/// `scale` is a power of two that keeps products of coordinates in range.
TetShapeT<par::Pack> shapes_of(const TetMesh& mesh, double scale, par::Size first, par::Size last) {
  Vec3T<par::Pack> p[4];
  for (int l = 0; l < kLanes; ++l) {
    const par::Size t = std::min(first + l, last);
    fetch_ahead(mesh, t);
    const auto& tet = mesh.tets[static_cast<std::size_t>(t)];
    for (std::size_t k = 0; k < 4; ++k) {
      const Point3& at = mesh.points[static_cast<std::size_t>(tet[k])];
      p[k].x[l] = scale * at[0];
      p[k].y[l] = scale * at[1];
      p[k].z[l] = scale * at[2];
    }
  }
  return TetShapeT<par::Pack>(p);
}

double percentile(const Bins& bins, std::int64_t count, double share) {
  const auto wanted = static_cast<std::int64_t>(share * static_cast<double>(count));
  std::int64_t below = 0;
  for (std::size_t b = 0; b < bins.size(); ++b) {
    below += bins[b];
    if (below > wanted) return (static_cast<double>(b) + 0.5) / kBinsPerDegree;
  }
  return 180;
}

/// All measures over one part: what adds up, and its worst tetrahedra in order.
struct MeasuredPart {
  struct Extent {
    double min = 0, max = 0, sum = 0;
  };
  std::array<Extent, kMeasures> extents;
  std::vector<WorstTet> worst;
};

bool is_worse(const WorstTet& a, const WorstTet& b) {
  return a.dihedral < b.dihedral || (a.dihedral == b.dihedral && a.tet < b.tet);
}

/// Keeps `worst` sorted and no longer than `most`.
void offer(std::vector<WorstTet>& worst, std::size_t most, const WorstTet& tet) {
  if (worst.size() == most && (most == 0 || !is_worse(tet, worst.back()))) return;
  if (worst.size() == most) worst.pop_back();
  worst.insert(std::upper_bound(worst.begin(), worst.end(), tet, is_worse), tet);
}

/// The measures of every tetrahedron in single precision, one array a measure, and their sums by part.
class MeasureTable {
 public:
  MeasureTable(std::size_t tets, int worst)
      : most_(static_cast<std::size_t>(std::max(0, worst))),
        parts_(static_cast<std::size_t>(part_count(static_cast<par::Size>(tets)))) {
    for (auto& column : columns_) column.resize(tets);
  }

  void add(const TetShape& shape, par::Size t, par::Size p, bool first) {
    MeasuredPart& part = parts_[static_cast<std::size_t>(p)];
    const Measures m = all_measures(shape);
    for (std::size_t k = 0; k < kMeasures; ++k) {
      columns_[k][static_cast<std::size_t>(t)] = static_cast<float>(m[k]);
      MeasuredPart::Extent& e = part.extents[k];
      e.min = first ? m[k] : std::min(e.min, m[k]);
      e.max = first ? m[k] : std::max(e.max, m[k]);
      e.sum += m[k];
    }
    const auto at = [&m](Measure measure) { return m[static_cast<std::size_t>(measure)]; };
    offer(part.worst, most_, {static_cast<Index>(t), at(Measure::min_dihedral), at(Measure::harmonic), {}});
  }

  void summarize(const TetMesh& mesh, const par::Cpu& cpu, Quality& q) {
    cpu.for_parts(static_cast<par::Size>(kMeasures), [&](par::Size k) { summarize(static_cast<std::size_t>(k), q); });
    for (const MeasuredPart& part : parts_) {
      for (const WorstTet& tet : part.worst) offer(q.worst, most_, tet);
    }
    for (WorstTet& worst : q.worst) {
      for (const Index v : mesh.tets[static_cast<std::size_t>(worst.tet)]) {
        for (std::size_t k = 0; k < 3; ++k) worst.centroid[k] += 0.25 * mesh.points[static_cast<std::size_t>(v)][k];
      }
    }
  }

 private:
  void summarize(std::size_t k, Quality& q) {
    std::vector<float>& column = columns_[k];
    const auto tets = static_cast<par::Size>(column.size());
    MeasureSummary& s = q.measures[k];
    bool first = true;
    double sum = 0;
    for (const MeasuredPart& part : parts_) {
      const MeasuredPart::Extent& e = part.extents[k];
      s.min = first ? e.min : std::min(s.min, e.min);
      s.max = first ? e.max : std::max(s.max, e.max);
      sum += e.sum;
      first = false;
    }
    s.mean = sum / static_cast<double>(tets);
    const bool low = larger_is_better(static_cast<Measure>(k));
    // The 5 % first: what is worse then lies before it.
    auto end = column.end();
    const auto worst_share = [&](double share) {
      const auto at = column.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(tets));
      if (low) {
        std::nth_element(column.begin(), at, end);
      } else {
        std::nth_element(column.begin(), at, end, std::greater<>());
      }
      end = at + 1;
      return std::clamp(static_cast<double>(*at), s.min, s.max);
    };
    s.p5 = worst_share(0.05);
    s.p1 = worst_share(0.01);
  }

  std::size_t most_;
  std::array<std::vector<float>, kMeasures> columns_;
  std::vector<MeasuredPart> parts_;
};

/// Measures the tetrahedra of a part.
void measure_part(const TetMesh& mesh, double scale, par::Size p, Part& part, Bins& bins, double* eta,
                  MeasureTable* table) {
  const auto tets = static_cast<par::Size>(mesh.tets.size());
  const par::Size begin = part_begin(tets, p);
  const par::Size end = part_begin(tets, p + 1);
  for (par::Size first = begin; first < end; first += kLanes) {
    const TetShapeT<par::Pack> shapes = shapes_of(mesh, scale, first, end - 1);
    const par::Pack etas = shapes.eta();
    const par::Pack energies = shapes.shape_energy();
    for (int l = 0; l < kLanes && first + l < end; ++l) {
      for (const par::Pack& angles : shapes.angles) {
        const double angle = angles[l];
        ++bins[static_cast<std::size_t>(angle * kBinsPerDegree)];
        part.sum += angle;
        if (angle < part.min) {
          part.min = angle;
          part.worst = first + l;
        }
        part.max = std::max(part.max, angle);
      }
      eta[first + l] = etas[l];
      part.eta_sum += etas[l];
      part.shape_sum += energies[l];
      const double ratio = mean_ratio(shapes.volume[l], shapes.length2[l]);
      part.ratio_sum += ratio;
      part.ratio_min = std::min(part.ratio_min, ratio);
      part.volume += shapes.volume[l];
      if (table != nullptr) table->add(lane(shapes, l), first + l, p, first + l == begin);
    }
  }
}

Quality measure_mesh(const TetMesh& mesh, int threads, MeasureTable* table) {
  Quality q;
  const auto tets = static_cast<par::Size>(mesh.tets.size());
  q.tets = tets;
  if (tets == 0) return q;
  const double scale = unit_scale(mesh);
  std::vector<double> eta(mesh.tets.size());
  const par::Size part_total = part_count(tets);
  std::vector<Part> parts(static_cast<std::size_t>(part_total));
  Bins bins;
  std::mutex bins_mutex;
  const par::Cpu cpu(threads);
  cpu.for_parts(part_total, [&](par::Size p) {
    Bins part_bins(kBins, 0);
    measure_part(mesh, scale, p, parts[static_cast<std::size_t>(p)], part_bins, eta.data(), table);
    const std::lock_guard lock(bins_mutex);
    if (bins.empty()) return bins.swap(part_bins);
    std::transform(bins.begin(), bins.end(), part_bins.begin(), bins.begin(), std::plus<>());
  });
  Part total;
  for (const Part& part : parts) {
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
  // The middle of a bin may lie beyond all angles.
  q.dihedral_1 = std::clamp(percentile(bins, angles, 0.01), total.min, total.max);
  q.dihedral_5 = std::clamp(percentile(bins, angles, 0.05), total.min, total.max);
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
  for (std::size_t h = 0; h < q.histogram.size(); ++h) {
    const auto begin = bins.begin() + static_cast<std::ptrdiff_t>(10 * kBinsPerDegree * h);
    // 180 degrees count with the last.
    const auto end = h + 1 < q.histogram.size() ? begin + 10 * kBinsPerDegree : bins.end();
    q.histogram[h] = static_cast<double>(std::accumulate(begin, end, std::int64_t{0})) / static_cast<double>(angles);
  }
  if (table != nullptr) table->summarize(mesh, cpu, q);
  return q;
}

void check_arrays(const TetMesh& mesh) {
  if (const ValidationReport arrays = validate_arrays(mesh); !arrays.ok()) throw MeshError(arrays.message(false));
}

}  // namespace

const char* to_string(Measure measure) {
  switch (measure) {
    case Measure::min_dihedral:
      return "min_dihedral_deg";
    case Measure::max_dihedral:
      return "max_dihedral_deg";
    case Measure::mean_ratio:
      return "mean_ratio";
    case Measure::sicn:
      return "sicn";
    case Measure::gamma:
      return "gamma";
    case Measure::scaled_jacobian:
      return "scaled_jacobian";
    case Measure::radius_ratio:
      return "radius_ratio";
    case Measure::aspect_ratio:
      return "aspect_ratio";
    case Measure::harmonic:
      return "q_h";
  }
  return "";
}

bool larger_is_better(Measure measure) {
  return measure != Measure::max_dihedral && measure != Measure::radius_ratio && measure != Measure::aspect_ratio;
}

Quality quality(const TetMesh& mesh, int threads) {
  check_arrays(mesh);
  return measure_mesh(mesh, threads, nullptr);
}

Quality measure_all(const TetMesh& mesh, int threads, int worst) {
  check_arrays(mesh);
  MeasureTable table(mesh.tets.size(), worst);
  return measure_mesh(mesh, threads, &table);
}

std::vector<Measures> measure_each(const TetMesh& mesh, int threads) {
  check_arrays(mesh);
  const double scale = unit_scale(mesh);
  std::vector<Measures> measures(mesh.tets.size());
  const auto tets = static_cast<par::Size>(mesh.tets.size());
  par::Cpu(threads).for_parts(part_count(tets), [&](par::Size p) {
    const par::Size end = part_begin(tets, p + 1);
    for (par::Size first = part_begin(tets, p); first < end; first += kLanes) {
      const TetShapeT<par::Pack> shapes = shapes_of(mesh, scale, first, end - 1);
      for (int l = 0; l < kLanes && first + l < end; ++l) {
        measures[static_cast<std::size_t>(first + l)] = all_measures(lane(shapes, l));
      }
    }
  });
  return measures;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "tetune/quality.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>

#include "curved/curved_edges.hpp"
#include "math/constants.hpp"
#include "mesh/messages.hpp"
#include "mesh/validate_arrays.hpp"
#include "quality/shape_loop.hpp"

namespace tetune {
namespace {

using Pack = ShapePack;
constexpr int kLanes = kShapeLanes;

/// Counts of dihedral angles in bins of 0.01 degrees.
using AngleBins = std::vector<std::uint32_t>;
constexpr int kBinsPerDegree = 100;
constexpr int kBins = 180 * kBinsPerDegree + 1;
static_assert(6 * std::int64_t{kMaxTets} <= std::numeric_limits<std::uint32_t>::max());

bool is_worse(const WorstTet& a, const WorstTet& b) {
  return a.dihedral < b.dihedral || (a.dihedral == b.dihedral && a.tet < b.tet);
}

/// All measures of every tetrahedron in single precision, with exact extremes and sums per chunk, and the worst
/// tetrahedra. Chunks may be filled concurrently; sums over chunks run in order.
class MeasureTable {
 public:
  MeasureTable(Size tets, int worst_count)
      : worst_count_(to_size_t(std::max(0, worst_count))), chunks_(to_size_t(shape_chunk_count(tets))) {
    for (auto& column : columns_) column.resize(to_size_t(tets));
  }

  /// Stores the measures of tetrahedron t of a chunk.
  void add(const TetShape& shape, Size t, Size chunk) {
    Chunk& c = span_of(chunks_)[chunk];
    const Measures m = all_measures(shape);
    for (std::size_t k = 0; k < kMeasures; ++k) {
      span_of(columns_[k])[t] = static_cast<float>(m[k]);
      Extent& e = c.extents[k];
      e.min = std::min(e.min, m[k]);
      e.max = std::max(e.max, m[k]);
      e.sum += m[k];
    }
    add_to_worst(c.worst, {to_index(t), value(m, Measure::min_dihedral), value(m, Measure::harmonic), {}});
  }

  /// Writes Quality::measures and Quality::worst. Reorders the table: called once, last.
  void summarize(const TetMeshView& mesh, const backend::Cpu& cpu, Quality& quality) {
    cpu.for_parts(kMeasures, [&](Size k) { summarize_measure(to_size_t(k), quality.measures[to_size_t(k)]); });
    for (const Chunk& chunk : chunks_) {
      for (const WorstTet& tet : chunk.worst) add_to_worst(quality.worst, tet);
    }
    std::sort_heap(quality.worst.begin(), quality.worst.end(), is_worse);
    for (WorstTet& worst : quality.worst) worst.centroid = mesh.centroid(worst.tet);
  }

 private:
  struct Extent {
    double min = kInfinity, max = -kInfinity, sum = 0;
  };
  struct Chunk {
    std::array<Extent, kMeasures> extents;
    std::vector<WorstTet> worst;  ///< a heap
  };

  /// Adds a tetrahedron to a heap of the worst ones, whose front is the best of them.
  void add_to_worst(std::vector<WorstTet>& heap, const WorstTet& tet) const {
    if (heap.size() < worst_count_) {
      heap.push_back(tet);
    } else if (!heap.empty() && is_worse(tet, heap.front())) {
      std::pop_heap(heap.begin(), heap.end(), is_worse);
      heap.back() = tet;
    } else {
      return;
    }
    std::push_heap(heap.begin(), heap.end(), is_worse);
  }

  void summarize_measure(std::size_t measure, MeasureSummary& summary) {
    summary.min = kInfinity;
    summary.max = -kInfinity;
    double sum = 0;
    for (const Chunk& chunk : chunks_) {
      const Extent& e = chunk.extents[measure];
      summary.min = std::min(summary.min, e.min);
      summary.max = std::max(summary.max, e.max);
      sum += e.sum;
    }
    std::vector<float>& column = columns_[measure];
    const auto tets = static_cast<double>(column.size());
    summary.mean = sum / tets;
    const bool small_is_worse = larger_is_better(static_cast<Measure>(measure));
    // The larger share first: worse values are before its position then.
    auto end = column.end();
    const auto worst_percentile = [&](double share) {
      const auto position = column.begin() + static_cast<std::ptrdiff_t>(share * tets);
      if (small_is_worse) {
        std::nth_element(column.begin(), position, end);
      } else {
        std::nth_element(column.begin(), position, end, std::greater<>());
      }
      end = position + 1;
      return std::clamp(double{*position}, summary.min, summary.max);
    };
    summary.p5 = worst_percentile(0.05);
    summary.p1 = worst_percentile(0.01);
  }

  std::size_t worst_count_;
  std::array<std::vector<float>, kMeasures> columns_;
  std::vector<Chunk> chunks_;
};

/// Sums and extremes over a set of tetrahedra.
struct QualitySums {
  double angle_min = 180, angle_max = 0, angle_sum = 0;
  Size worst_tet = -1;
  double eta_sum = 0, shape_sum = 0, ratio_sum = 0, ratio_min = 1, volume = 0;

  void merge(const QualitySums& other) {
    if (other.angle_min < angle_min) {
      angle_min = other.angle_min;
      worst_tet = other.worst_tet;
    }
    angle_max = std::max(angle_max, other.angle_max);
    angle_sum += other.angle_sum;
    eta_sum += other.eta_sum;
    shape_sum += other.shape_sum;
    ratio_sum += other.ratio_sum;
    ratio_min = std::min(ratio_min, other.ratio_min);
    volume += other.volume;
  }
};

/// Measures one chunk of the tetrahedra.
struct MeasureChunk {
  const TetMeshView& mesh;
  Span<double> eta;
  MeasureTable* table;  ///< may be null

  QualitySums operator()(Size chunk, Span<std::uint32_t> bins) const {
    QualitySums sums;
    const Size begin = shape_chunk_begin(mesh.tets.size(), chunk);
    const Size end = shape_chunk_begin(mesh.tets.size(), chunk + 1);
    for (Size first = begin; first < end; first += kLanes) {
      const TetShapeT<Pack> shapes = load_shapes(mesh, first, end - 1);
      const Pack etas = shapes.eta();
      const Pack energies = shapes.shape_energy();
      const Pack ratios = mean_ratio(shapes.volume, shapes.length2);
      for (int l = 0; l < kLanes && first + l < end; ++l) {
        add_angles(shapes, l, first + l, bins, sums);
        eta[first + l] = etas[l];
        sums.eta_sum += etas[l];
        sums.shape_sum += energies[l];
        sums.ratio_sum += ratios[l];
        sums.ratio_min = std::min(sums.ratio_min, double{ratios[l]});
        sums.volume += shapes.volume[l];
        if (table != nullptr) table->add(lane(shapes, l), first + l, chunk);
      }
    }
    return sums;
  }

 private:
  static void add_angles(const TetShapeT<Pack>& shapes, int l, Size t, Span<std::uint32_t> bins, QualitySums& sums) {
    for (const Pack& angles : shapes.angles) {
      const double angle = angles[l];
      ++bins[static_cast<Size>(angle * kBinsPerDegree)];
      sums.angle_sum += angle;
      if (angle < sums.angle_min) {
        sums.angle_min = angle;
        sums.worst_tet = t;
      }
      sums.angle_max = std::max(sums.angle_max, angle);
    }
  }
};

/// The angle below which this share of all angles lies, in degrees.
double percentile(const AngleBins& bins, double angles, double share) {
  const auto rank = static_cast<std::int64_t>(share * angles);
  std::int64_t below = 0;
  double middle = 0.5;
  for (const std::uint32_t count : bins) {
    below += count;
    if (below > rank) return middle / kBinsPerDegree;
    middle += 1;
  }
  return 180;
}

void set_angles(const QualitySums& sums, const AngleBins& bins, Quality& q) {
  const double angles = 6 * static_cast<double>(q.tets);
  q.dihedral_min = sums.angle_min;
  q.worst_tet = to_index(sums.worst_tet);
  // The middle of a bin may lie outside the range of all angles.
  q.dihedral_1 = std::clamp(percentile(bins, angles, 0.01), sums.angle_min, sums.angle_max);
  q.dihedral_5 = std::clamp(percentile(bins, angles, 0.05), sums.angle_min, sums.angle_max);
  q.dihedral_mean = sums.angle_sum / angles;
  q.dihedral_max = sums.angle_max;
  auto begin = bins.begin();
  for (double& share : q.histogram) {
    // The last bin of the histogram includes 180 degrees.
    const auto end = &share == &q.histogram.back() ? bins.end() : begin + 10 * kBinsPerDegree;
    share = static_cast<double>(std::accumulate(begin, end, std::int64_t{0})) / angles;
    begin = end;
  }
}

Quality measure_mesh(const TetMesh& mesh, int threads, MeasureTable* table) {
  Quality q;
  q.tets = std::ssize(mesh.tets);
  if (q.tets == 0) return q;
  const double scale = unit_scale(mesh);
  const TetMeshView view(mesh, scale);
  std::vector<double> eta(mesh.tets.size());
  const Size chunks = shape_chunk_count(q.tets);
  std::vector<QualitySums> chunk_sums(to_size_t(chunks));
  AngleBins bins(kBins, 0);
  std::mutex bins_mutex;
  const backend::Cpu cpu(threads);
  const MeasureChunk measure_chunk{view, span_of(eta), table};
  cpu.for_parts(chunks, [&](Size chunk) {
    // Bins cost as much time as some hundred tetrahedra, so that chunks are larger.
    AngleBins chunk_bins(kBins, 0);
    span_of(chunk_sums)[chunk] = measure_chunk(chunk, span_of(chunk_bins));
    const std::lock_guard lock(bins_mutex);
    std::transform(bins.begin(), bins.end(), chunk_bins.begin(), bins.begin(), std::plus<>());
  });
  QualitySums sums;
  for (const QualitySums& chunk : chunk_sums) sums.merge(chunk);
  set_angles(sums, bins, q);
  const auto tets = static_cast<double>(q.tets);
  q.eta_sum = sums.eta_sum / scale;
  q.shape_sum = sums.shape_sum;
  q.eta_max = *std::max_element(eta.begin(), eta.end()) / scale;
  const auto at_95 = eta.begin() + std::min(q.tets - 1, static_cast<Size>(0.95 * tets));
  std::nth_element(eta.begin(), at_95, eta.end());
  q.eta_95 = *at_95 / scale;
  q.mean_ratio = sums.ratio_sum / tets;
  q.mean_ratio_min = sums.ratio_min;
  q.volume = sums.volume / scale / scale / scale;
  if (table != nullptr) table->summarize(view, cpu, q);
  return q;
}

}  // namespace

const char* to_string(Measure measure) {
  return name_of(measure, {"min_dihedral_deg", "max_dihedral_deg", "mean_ratio", "sicn", "gamma", "scaled_jacobian",
                           "radius_ratio", "aspect_ratio", "q_h"});
}

bool larger_is_better(Measure measure) {
  return measure != Measure::max_dihedral && measure != Measure::radius_ratio && measure != Measure::aspect_ratio;
}

Quality quality(const TetMesh& mesh, int threads) {
  require_arrays(mesh);
  Quality q = measure_mesh(mesh, threads, nullptr);
  q.curved = summarize_curved(mesh, threads, 0);
  return q;
}

Quality measure_all(const TetMesh& mesh, int threads, int worst) {
  require_arrays(mesh);
  MeasureTable table(std::ssize(mesh.tets), worst);
  Quality q = measure_mesh(mesh, threads, &table);
  q.curved = summarize_curved(mesh, threads, worst);
  return q;
}

std::vector<Measures> measure_each(const TetMesh& mesh, int threads) {
  require_arrays(mesh);
  const TetMeshView view(mesh, unit_scale(mesh));
  std::vector<Measures> result(mesh.tets.size());
  const Span<Measures> measures = span_of(result);
  backend::Cpu(threads).for_parts(shape_chunk_count(measures.size()), [&](Size chunk) {
    for_each_shape(view, chunk,
                   [&](const TetShapeT<Pack>& shapes, int l, Size t) { measures[t] = all_measures(lane(shapes, l)); });
  });
  return result;
}

}  // namespace tetune

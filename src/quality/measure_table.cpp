// SPDX-License-Identifier: Apache-2.0
#include "quality/measure_table.hpp"

#include <algorithm>
#include <functional>

namespace tetune {
namespace {

bool is_worse(const WorstTet& a, const WorstTet& b) {
  return a.dihedral < b.dihedral || (a.dihedral == b.dihedral && a.tet < b.tet);
}

/// Inserts a tetrahedron into the sorted list of the worst `max_size` ones.
void insert_worst(std::vector<WorstTet>& worst, std::size_t max_size, const WorstTet& tet) {
  if (worst.size() == max_size && (max_size == 0 || !is_worse(tet, worst.back()))) return;
  if (worst.size() == max_size) worst.pop_back();
  worst.insert(std::upper_bound(worst.begin(), worst.end(), tet, is_worse), tet);
}

}  // namespace

MeasureTable::MeasureTable(Size tets, Size chunks, int worst_count)
    : worst_count_(to_size_t(std::max(0, worst_count))), chunks_(to_size_t(chunks)) {
  for (auto& column : columns_) column.resize(to_size_t(tets));
}

void MeasureTable::add(const TetShape& shape, Size t, Size chunk, bool first) {
  Chunk& c = span_of(chunks_)[chunk];
  const Measures m = all_measures(shape);
  for (std::size_t k = 0; k < kMeasures; ++k) {
    span_of(columns_[k])[t] = static_cast<float>(m[k]);
    Extent& e = c.extents[k];
    e.min = first ? m[k] : std::min(e.min, m[k]);
    e.max = first ? m[k] : std::max(e.max, m[k]);
    e.sum += m[k];
  }
  const WorstTet tet{to_index(t), value(m, Measure::min_dihedral), value(m, Measure::harmonic), {}};
  insert_worst(c.worst, worst_count_, tet);
}

void MeasureTable::summarize(const TetMeshView& mesh, const backend::Cpu& cpu, Quality& quality) {
  cpu.for_parts(kMeasures, [&](Size k) {
    const std::size_t measure = to_size_t(k);
    summarize_measure(measure, quality.measures[measure]);
  });
  for (const Chunk& chunk : chunks_) {
    for (const WorstTet& tet : chunk.worst) insert_worst(quality.worst, worst_count_, tet);
  }
  for (WorstTet& worst : quality.worst) worst.centroid = mesh.centroid(worst.tet);
}

void MeasureTable::summarize_measure(std::size_t measure, MeasureSummary& summary) {
  bool first = true;
  double sum = 0;
  for (const Chunk& chunk : chunks_) {
    const Extent& e = chunk.extents[measure];
    summary.min = first ? e.min : std::min(summary.min, e.min);
    summary.max = first ? e.max : std::max(summary.max, e.max);
    sum += e.sum;
    first = false;
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

}  // namespace tetune

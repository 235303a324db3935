// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "backend/cpu.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "quality/tet_measures.hpp"

namespace tetune {

/// All measures of every tetrahedron in single precision, with exact extremes and sums per chunk, and the worst
/// tetrahedra. Chunks may be filled concurrently; sums over chunks run in order.
class MeasureTable {
 public:
  MeasureTable(Size tets, Size chunks, int worst_count);

  /// Stores the measures of tetrahedron t of a chunk. `first` marks the first one of the chunk.
  void add(const TetShape& shape, Size t, Size chunk, bool first);

  /// Writes Quality::measures and Quality::worst. Reorders the table: called once, last.
  void summarize(const TetMeshView& mesh, const backend::Cpu& cpu, Quality& quality);

 private:
  struct Extent {
    double min = 0, max = 0, sum = 0;
  };
  struct Chunk {
    std::array<Extent, kMeasures> extents;
    std::vector<WorstTet> worst;
  };

  void summarize_measure(std::size_t measure, MeasureSummary& summary);

  std::size_t worst_count_;
  std::array<std::vector<float>, kMeasures> columns_;
  std::vector<Chunk> chunks_;
};

}  // namespace tetune

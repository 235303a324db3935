// SPDX-License-Identifier: Apache-2.0
#include "boundary/sliding/weak_lines.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "backend/span.hpp"
#include "mesh/sorted.hpp"

namespace tetune {
namespace {

/// The graph of the feature edges, from which lines are removed.
class FeatureGraph {
 public:
  explicit FeatureGraph(std::vector<FeatureEdge> edges) : edges_(std::move(edges)) {
    for (FeatureEdge& e : edges_) {
      if (e.ends[0] > e.ends[1]) std::swap(e.ends[0], e.ends[1]);
    }
    erase_duplicates();
    std::vector<Index> vertices;
    for (const FeatureEdge& e : edges_) vertices.insert(vertices.end(), {e.ends[0], e.ends[1]});
    sort_unique(vertices);
    vertex2edges_.resize(vertices.size());
    for (Index e = 0; e < std::ssize(edges_); ++e) {
      for (Index& v : span_of(edges_)[e].ends) {
        v = position_in(vertices, v);
        span_of(vertex2edges_)[v].push_back(e);
      }
    }
  }

  /// Removes weak lines with an open end until there are none.
  std::vector<Index> remove_weak_lines() {
    std::vector<Index> corners;
    std::vector<Index> candidates(vertex2edges_.size());
    std::iota(candidates.begin(), candidates.end(), 0);
    while (!candidates.empty()) {
      std::vector<Index> ends;
      for (const Index v : candidates) {
        if (degree(v) != 1) continue;
        const Line line = line_from(v);
        const auto is_weak = [&](Index e) { return span_of(edges_)[e].is_weak != 0; };
        if (!std::all_of(line.edges.begin(), line.edges.end(), is_weak)) continue;
        for (const Index e : line.edges) {
          corners.push_back(span_of(edges_)[e].corner);
          for (const Index end : span_of(edges_)[e].ends) std::erase(span_of(vertex2edges_)[end], e);
        }
        ends.push_back(line.end);
      }
      candidates = std::move(ends);
    }
    return corners;
  }

 private:
  struct Line {
    std::vector<Index> edges;
    Index end;
  };

  /// Where sheets touch, several edges have the same ends: of these one is kept, which is not weak.
  void erase_duplicates() {
    const auto ends = [](const FeatureEdge& e) { return std::tuple(e.ends[0], e.ends[1]); };
    std::sort(edges_.begin(), edges_.end(), [&](const FeatureEdge& x, const FeatureEdge& y) {
      return std::tuple(ends(x), x.is_weak, x.corner) < std::tuple(ends(y), y.is_weak, y.corner);
    });
    const auto same_ends = [&](const FeatureEdge& x, const FeatureEdge& y) { return ends(x) == ends(y); };
    edges_.erase(std::unique(edges_.begin(), edges_.end(), same_ends), edges_.end());
  }
  Size degree(Index v) const { return std::ssize(span_of(vertex2edges_)[v]); }
  /// The line from its open end to the next vertex at which not exactly two edges meet.
  Line line_from(Index open_end) const {
    Line line{{}, open_end};
    do {
      const std::vector<Index>& at_end = span_of(vertex2edges_)[line.end];
      const Index e = line.edges.empty() || at_end.front() != line.edges.back() ? at_end.front() : at_end.back();
      const Index* ends = span_of(edges_)[e].ends;
      line.edges.push_back(e);
      line.end = ends[0] == line.end ? ends[1] : ends[0];
    } while (degree(line.end) == 2);
    return line;
  }

  std::vector<FeatureEdge> edges_;  ///< with their vertices numbered in increasing order
  std::vector<std::vector<Index>> vertex2edges_;
};

}  // namespace

std::vector<Index> find_weak_lines(std::vector<FeatureEdge> edges) {
  return FeatureGraph(std::move(edges)).remove_weak_lines();
}

}  // namespace tetune

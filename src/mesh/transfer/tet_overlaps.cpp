// SPDX-License-Identifier: Apache-2.0
#include "mesh/transfer/tet_overlaps.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "math/box_tree.hpp"
#include "math/constants.hpp"
#include "mesh/tet.hpp"
#include "mesh/tet_mesh_view.hpp"

namespace tetune {
namespace {

using VertexIds = std::array<Index, 4>;

Box box_of(const TetPoints& x) {
  Box box{x[0], x[0]};
  for (const Vec3& p : x) box.include(p);
  return box;
}

Vec3 centroid_of(const TetPoints& x) { return centroid(x[0], x[1], x[2], x[3]); }

/// For each tetrahedron of the result the one of the input with the same vertices at the same places, or -1.
std::vector<Index> find_unchanged(const TransferMeshes& meshes) {
  std::vector<Index> same(to_size_t(meshes.new_tets.size()), -1);
  std::vector<std::uint8_t> is_taken(to_size_t(meshes.old_tets.size()), 0);
  for (Index t = 0; t < std::ssize(same); ++t) {
    const Index old = meshes.tet2original[t];
    VertexIds ids{};
    for (std::size_t k = 0; k < 4; ++k) ids[k] = span_of(meshes.vertex2old)[meshes.new_tets[t][k]];
    if (span_of(is_taken)[old] != 0 || ascending(ids) != ascending(meshes.old_tets[old])) continue;
    span_of(is_taken)[old] = 1;
    span_of(same)[t] = old;
  }
  return same;
}

/// The tetrahedra of the input that are not in the result unchanged.
std::vector<Index> changed_old(const TransferMeshes& meshes) {
  std::vector<std::uint8_t> is_same(to_size_t(meshes.old_tets.size()), 0);
  for (const Index t : meshes.tet2same) {
    if (t >= 0) span_of(is_same)[t] = 1;
  }
  std::vector<Index> changed;
  for (Index t = 0; t < std::ssize(is_same); ++t) {
    if (span_of(is_same)[t] == 0) changed.push_back(t);
  }
  return changed;
}

/// Finds the entry of `tets` in the region of a tetrahedron of the input whose centroid is nearest.
class NearestEntry {
 public:
  NearestEntry(const TransferMeshes& meshes, const std::vector<Index>& tets)
      : meshes_(meshes), tets_(tets), tree_(centroids(meshes, tets)) {}

  /// -1 if there is none; the first of equally near ones.
  Size of(Index old) const {
    const Vec3 center = centroid_of(meshes_.old_tet(old));
    double best = kInfinity;
    Size found = -1;
    tree_.for_closer(center, best, [&](Index i) {
      const Index t = span_of(tets_)[i];
      if (meshes_.regions[meshes_.tet2original[t]] != meshes_.regions[old]) return;
      const Vec3 d = centroid_of(meshes_.new_tet(t)) - center;
      const double distance2 = dot(d, d);
      if (distance2 > best || (distance2 == best && found >= 0 && i > found)) return;
      best = distance2;
      found = i;
    });
    return found;
  }

 private:
  static std::vector<Box> centroids(const TransferMeshes& meshes, const std::vector<Index>& tets) {
    std::vector<Box> boxes;
    boxes.reserve(tets.size());
    for (const Index t : tets) {
      const Vec3 center = centroid_of(meshes.new_tet(t));
      boxes.push_back({center, center});
    }
    return boxes;
  }

  const TransferMeshes& meshes_;
  const std::vector<Index>& tets_;
  const BoxTree tree_;
};

struct TetPair {
  Size entry;
  Index old;
  double volume;
};

/// Measures how far the tetrahedra of the input are covered.
void measure_cover(const TransferMeshes& meshes, const std::vector<Index>& changed, TetOverlaps& result) {
  const std::size_t n = to_size_t(meshes.old_tets.size());
  result.old_volumes.resize(n);
  result.covered.assign(n, 1);
  double total = 0;
  for (Index t = 0; t < std::ssize(result.old_volumes); ++t) {
    total += span_of(result.old_volumes)[t] = volume(meshes.old_tet(t));
  }
  for (const Index t : changed) span_of(result.covered)[t] = 0;
  for (Size i = 0; i < std::ssize(result.old); ++i) {
    const Index t = span_of(result.old)[i];
    span_of(result.covered)[t] += span_of(result.volumes)[i] / span_of(result.old_volumes)[t];
  }
  std::optional<NearestEntry> nearest;
  constexpr double kRounding = 1e-12;
  for (const Index t : changed) {
    const double missing = 1 - span_of(result.covered)[t];
    if (missing > kRounding) result.uncovered += missing * span_of(result.old_volumes)[t] / total;
    if (span_of(result.covered)[t] > 0) continue;
    if (!nearest) nearest.emplace(meshes, result.tets);
    const Size near = nearest->of(t);
    if (near >= 0) result.uncovered_tets.emplace_back(t, near);
  }
}

}  // namespace

TransferMeshes::TransferMeshes(const TetMesh& input, const std::vector<VertexIds>& tets,
                               const std::vector<Index>& origins, const std::vector<MeshPlace>& places)
    : old_tets(span_of(input.tets)),
      new_tets(span_of(tets)),
      regions(span_of(input.tet_tags)),
      tet2original(span_of(origins)) {
  const double scale = unit_scale(input.points);
  for (const Point3& p : input.points) old_points.push_back(scale * vec(p));
  for (const MeshPlace& place : places) {
    const bool is_vertex = place.weights[0] == 1;
    vertex2old.push_back(is_vertex ? place.vertices[0] : -1);
    Vec3 x{0, 0, 0};
    for (std::size_t k = 0; k < 4; ++k) x = x + place.weights[k] * span_of(old_points)[place.vertices[k]];
    new_points.push_back(is_vertex ? span_of(old_points)[place.vertices[0]] : x);
  }
  tet2same = find_unchanged(*this);
}

std::optional<TetOverlaps> find_overlaps(const backend::Cpu& cpu, const TransferMeshes& meshes, Moments moments,
                                         const std::function<void(const std::vector<Index>&)>& begin,
                                         const OverlapVisitor& visit) {
  TetOverlaps result;
  for (Index t = 0; t < meshes.new_tets.size(); ++t) {
    if (span_of(meshes.tet2same)[t] < 0) result.tets.push_back(t);
  }
  begin(result.tets);
  const std::vector<Index> changed = changed_old(meshes);
  std::vector<Box> boxes;
  std::vector<TetFrame> frames;
  boxes.reserve(changed.size());
  frames.reserve(changed.size());
  for (const Index t : changed) {
    frames.emplace_back(meshes.old_tet(t));
    boxes.push_back(box_of(frames.back().points));
  }
  const BoxTree tree(boxes);

  constexpr Size kChunk = 128;
  const Size count = std::ssize(result.tets);
  std::vector<std::vector<TetPair>> chunks(to_size_t((count + kChunk - 1) / kChunk));
  cpu.for_parts(std::ssize(chunks), [&](Size chunk) {
    std::vector<TetPair>& pairs = span_of(chunks)[chunk];
    for (Size i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
      if (cpu.stop_requested()) return;
      const Index t = span_of(result.tets)[i];
      const TetFrame x(meshes.new_tet(t));
      const double size = std::fabs(x.six) / 6;
      tree.for_meeting(box_of(x.points), [&](Index item) {
        const Index old = span_of(changed)[item];
        if (meshes.regions[meshes.tet2original[t]] != meshes.regions[old]) return;
        const TetOverlap common = overlap(x, span_of(frames)[item], moments);
        if (common.part == 0) return;
        pairs.push_back({i, old, common.part * size});
        visit(i, old, common);
      });
    }
  });
  if (cpu.stop_requested()) return std::nullopt;
  result.offsets.assign(to_size_t(count) + 1, 0);
  std::size_t total = 0;
  for (const std::vector<TetPair>& pairs : chunks) total += pairs.size();
  result.old.reserve(total);
  result.volumes.reserve(total);
  for (std::vector<TetPair>& chunk : chunks) {
    const std::vector<TetPair> pairs = std::exchange(chunk, {});  // its memory is free after it
    for (const TetPair& pair : pairs) {
      ++span_of(result.offsets)[pair.entry + 1];
      result.old.push_back(pair.old);
      result.volumes.push_back(pair.volume);
    }
  }
  for (Size i = 0; i < count; ++i) span_of(result.offsets)[i + 1] += span_of(result.offsets)[i];
  measure_cover(meshes, changed, result);
  return result;
}

}  // namespace tetune

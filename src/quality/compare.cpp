// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "backend/cpu.hpp"
#include "curved/curved_edges.hpp"
#include "curved/quadratic_sheet.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/validate_arrays.hpp"
#include "quality/mesh_surface.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

using TagSet = std::set<int>;

TagSet tag_set(const std::vector<int>& tags) {
  TagSet set;
  const int* last = nullptr;
  for (const int& tag : tags) {
    if (last == nullptr || tag != *last) set.insert(tag);
    last = &tag;
  }
  return set;
}

TagSet nonzero_tag_set(const std::vector<int>& tags) {
  TagSet set = tag_set(tags);
  set.erase(0);
  return set;
}

double relative_change(double before, double after) { return before != 0 ? after / before - 1 : after != 0 ? 1 : 0; }

/// Volumes or areas by tag.
using SizeByTag = std::map<int, double>;

/// Adds up sizes of items by tag. Fast where most items have the tag of the one before.
class SizeSum {
 public:
  void add(int tag, double size) {
    if (entry_ == sizes_.end() || entry_->first != tag) entry_ = sizes_.try_emplace(tag, 0).first;
    entry_->second += size;
  }
  SizeByTag take() { return std::move(sizes_); }

 private:
  SizeByTag sizes_;
  SizeByTag::iterator entry_ = sizes_.end();
};

SizeByTag region_volumes(const TetMesh& mesh, const TetMeshView& view) {
  SizeSum volumes;
  const CurvedEdges edges(mesh);
  const auto volume = [&](Size t) {
    const std::array<Index, 4>& tet = view.tets[t];
    if (mesh.curved_edges.empty() || !edges.has_curved(tet)) return view.six_volume(view.tet(t)) / 6;
    TenNodes nodes = edges.nodes(tet);
    for (Vec3& node : nodes) node = view.scale * node;
    return signed_volume(nodes);
  };
  for (Size t = 0; t < view.tets.size(); ++t) {
    view.prefetch_ahead(t);
    volumes.add(span_of(mesh.tet_tags)[t], volume(t));
  }
  return volumes.take();
}

SizeByTag patch_areas(const TetMesh& mesh, const TetMeshView& view) {
  SizeSum areas;
  const QuadraticTriangles quadratic(mesh.points, mesh.curved_edges);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.triangle_tags[t] == 0) continue;
    const auto& v = mesh.triangles[t];
    areas.add(mesh.triangle_tags[t],
              mesh.curved_edges.empty()
                  ? area_of(TrianglePoints{view.position(v[0]), view.position(v[1]), view.position(v[2])})
                  : area_of(scaled(quadratic.of(v), view.scale)));
  }
  return areas.take();
}

double max_change(const SizeByTag& before, const SizeByTag& after) {
  double max_change = 0;
  for (const auto& [tag, size] : before) {
    const auto found = after.find(tag);
    max_change = std::max(max_change, std::fabs(relative_change(size, found == after.end() ? 0 : found->second)));
  }
  return max_change;
}

double total(const SizeByTag& sizes) {
  double sum = 0;
  for (const auto& [tag, size] : sizes) sum += size;
  return sum;
}

/// The number of listed vertices of the first mesh without a vertex of the second at the same position: the one of the
/// same id, or, because ids change when vertices are inserted or removed, any one in the list of the second.
std::int64_t count_moved(const TetMesh& before, const std::vector<Index>& ids, const TetMesh& after,
                         const std::vector<Index>& ids_after) {
  const Span<const Point3> points = span_of(before.points);
  const Span<const Point3> points_after = span_of(after.points);
  std::vector<Point3> positions;
  positions.reserve(ids_after.size());
  for (const Index id : ids_after) positions.push_back(points_after[id]);
  std::sort(positions.begin(), positions.end());
  return std::count_if(ids.begin(), ids.end(), [&](Index id) {
    if (id < points_after.size() && points[id] == points_after[id]) return false;
    return !std::binary_search(positions.begin(), positions.end(), points[id]);
  });
}

void compare_sizes(const TetMesh& before, const TetMesh& after, double scale, Comparison& c) {
  const TetMeshView old_view(before, scale);
  const TetMeshView new_view(after, scale);
  const SizeByTag old_volumes = region_volumes(before, old_view);
  const SizeByTag new_volumes = region_volumes(after, new_view);
  c.volume_change = relative_change(total(old_volumes), total(new_volumes));
  c.region_volume_change = max_change(old_volumes, new_volumes);
  const SizeByTag old_areas = patch_areas(before, old_view);
  SizeByTag new_areas = patch_areas(after, new_view);
  c.patch_area_change = max_change(old_areas, new_areas);
  for (const auto& [tag, size] : old_areas) {
    c.patches.push_back({tag, size / scale / scale, relative_change(size, new_areas[tag])});
  }
}

void compare_surfaces(const TetMesh& before, const TetMesh& after, double scale, int threads, std::int64_t max_samples,
                      Comparison& c) {
  const backend::Cpu cpu(threads);
  const MeshSurface old_surface = find_surface(before, scale, threads);
  const MeshSurface new_surface = find_surface(after, scale, threads);
  c.area_change = relative_change(old_surface.area, new_surface.area);
  c.mean_edge = old_surface.mean_edge / scale;
  if (!(old_surface.mean_edge > 0) || new_surface.triangles.empty()) return;
  const std::int64_t samples = std::max(old_surface.sample_count(), new_surface.sample_count());
  c.sample_stride = max_samples > 0 ? (samples - 1) / max_samples + 1 : 1;
  const LargestDistances new_to_old = max_distances(new_surface, old_surface, c.sample_stride, cpu);
  c.vertices_to_old = new_to_old.vertices / old_surface.mean_edge;
  c.new_to_old = new_to_old.all / old_surface.mean_edge;
  c.old_to_new = max_distances(old_surface, new_surface, c.sample_stride, cpu).all / old_surface.mean_edge;
}

void compare_tags(const TetMesh& before, const TetMesh& after, Comparison& c) {
  c.vertex_tags_kept = before.points.size() == after.points.size()
                           ? before.point_tags == after.point_tags
                           : nonzero_tag_set(before.point_tags) == nonzero_tag_set(after.point_tags);
  c.tet_tags_kept = tag_set(before.tet_tags) == tag_set(after.tet_tags);
  c.triangle_tags_kept = nonzero_tag_set(before.triangle_tags) == nonzero_tag_set(after.triangle_tags);
  c.edge_tags_kept = nonzero_tag_set(before.edge_tags) == nonzero_tag_set(after.edge_tags);
}

}  // namespace

Comparison compare(const TetMesh& before, const TetMesh& after, int threads, std::int64_t max_samples) {
  for (const TetMesh* mesh : {&before, &after}) require_arrays(*mesh);
  Comparison c;
  c.old_vertices = std::ssize(before.points);
  c.new_vertices = std::ssize(after.points);
  c.old_tets = std::ssize(before.tets);
  c.new_tets = std::ssize(after.tets);
  // A common unit in which squares and cubes of lengths neither underflow nor overflow.
  const double scale = std::min(unit_scale(before), unit_scale(after));
  compare_sizes(before, after, scale, c);
  compare_surfaces(before, after, scale, threads, max_samples, c);
  compare_tags(before, after, c);
  c.required_moved = count_moved(before, before.required_vertices, after, after.required_vertices);
  c.corners_moved = count_moved(before, before.corners, after, after.corners);
  return c;
}

}  // namespace tetune

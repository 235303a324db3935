// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <tuple>

#include "boundary/closest_triangle.hpp"
#include "core/connect.hpp"
#include "core/unit_scale.hpp"
#include "core/upload.hpp"
#include "core/validate_arrays.hpp"
#include "par/cpu.hpp"
#include "tetune/error.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

double area(const TrianglePoints& t) { return 0.5 * norm(cross(t[1] - t[0], t[2] - t[0])); }

/// The surfaces of a mesh: faces on one tetrahedron, and faces between regions.
struct Skin {
  std::vector<TrianglePoints> triangles;
  std::vector<Vec3> vertices;
  double area = 0;       ///< of the boundary
  double mean_edge = 0;  ///< of the boundary

  /// Vertices, and the middles of edges and triangles. The triangles at an edge run along it both ways: one is enough.
  std::vector<Vec3> samples() const {
    std::vector<Vec3> points = vertices;
    for (const TrianglePoints& t : triangles) {
      points.push_back((1.0 / 3) * (t[0] + t[1] + t[2]));
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& a = t[k];
        const Vec3& b = t[(k + 1) % 3];
        if (std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z)) points.push_back(0.5 * (a + b));
      }
    }
    return points;
  }
};

Skin find_skin(const TetMesh& mesh, double scale, const par::Cpu& cpu) {
  WorkMesh<par::Cpu> work = upload_mesh<par::Cpu>(mesh);
  build_adjacency(cpu, work);
  Skin skin;
  std::vector<char> seen(mesh.points.size(), 0);
  double edges = 0;
  std::size_t faces = 0;
  const MeshView view = work.view();
  for (Size t = 0; t < work.slots(); ++t) {
    for (int f = 0; f < 4; ++f) {
      const Link link = view.tet2tet[t][f];
      const bool outer = link == kNoLink;
      if (!outer && (link_tet(link) < t || mesh.tet_tags[static_cast<std::size_t>(link_tet(link))] ==
                                               mesh.tet_tags[static_cast<std::size_t>(t)]))
        continue;
      TrianglePoints triangle;
      for (int k = 0; k < 3; ++k) {
        const auto v = static_cast<std::size_t>(view.tet2vertex[t][face_vertex(f, k)]);
        triangle[static_cast<std::size_t>(k)] = scale * vec(mesh.points[v]);
        if (seen[v] == 0) skin.vertices.push_back(triangle[static_cast<std::size_t>(k)]);
        seen[v] = 1;
      }
      skin.triangles.push_back(triangle);
      if (!outer) continue;
      ++faces;
      for (std::size_t k = 0; k < 3; ++k) edges += norm(triangle[(k + 1) % 3] - triangle[k]);
      skin.area += area(triangle);
    }
  }
  if (faces > 0) skin.mean_edge = edges / (3 * static_cast<double>(faces));
  return skin;
}

/// Largest distance of the points from the surface. A point that is no farther than the farthest so far needs no exact
/// distance: the result is the same in any order.
double farthest(const std::vector<Vec3>& points, const ClosestTriangle& surface, const par::Cpu& cpu) {
  std::atomic<double> most{0};
  cpu.for_each(static_cast<Size>(points.size()), [&](Size i) {
    double known = most.load(std::memory_order_relaxed);
    const double distance2 = surface.closest(points[static_cast<std::size_t>(i)], known).distance2;
    while (distance2 > known && !most.compare_exchange_weak(known, distance2, std::memory_order_relaxed)) {
    }
  });
  return std::sqrt(most.load());
}

std::vector<int> tag_set(std::vector<int> tags) {
  std::sort(tags.begin(), tags.end());
  tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
  return tags;
}

double relative(double now, double before) { return before != 0 ? now / before - 1 : now != 0 ? 1 : 0; }

std::map<int, double> region_volumes(const TetMesh& mesh, double scale) {
  std::map<int, double> volumes;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto p = [&](std::size_t k) { return scale * vec(mesh.points[static_cast<std::size_t>(mesh.tets[t][k])]); };
    volumes[mesh.tet_tags[t]] += dot(cross(p(1) - p(0), p(2) - p(0)), p(3) - p(0)) / 6;
  }
  return volumes;
}

std::map<int, double> patch_areas(const TetMesh& mesh, double scale) {
  std::map<int, double> areas;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.triangle_tags[t] == 0) continue;
    const auto p = [&](std::size_t k) {
      return scale * vec(mesh.points[static_cast<std::size_t>(mesh.triangles[t][k])]);
    };
    areas[mesh.triangle_tags[t]] += area({p(0), p(1), p(2)});
  }
  return areas;
}

double largest_change(const std::map<int, double>& before, const std::map<int, double>& after) {
  double largest = 0;
  for (const auto& [tag, size] : before) {
    const auto at = after.find(tag);
    largest = std::max(largest, std::fabs(relative(at == after.end() ? 0 : at->second, size)));
  }
  return largest;
}

double total(const std::map<int, double>& sizes) {
  double sum = 0;
  for (const auto& [tag, size] : sizes) sum += size;
  return sum;
}

std::vector<int> nonzero(std::vector<int> tags) {
  tags.erase(std::remove(tags.begin(), tags.end(), 0), tags.end());
  return tag_set(std::move(tags));
}

/// Vertices of the first mesh's list that are not where they were. Where vertices have come or gone, ids say little:
/// any vertex of the second mesh's list may be there then.
std::int64_t count_moved(const TetMesh& before, const std::vector<Index>& ids, const TetMesh& after,
                         const std::vector<Index>& ids_after) {
  std::vector<Point3> places;
  places.reserve(ids_after.size());
  for (const Index id : ids_after) places.push_back(after.points[static_cast<std::size_t>(id)]);
  std::sort(places.begin(), places.end());
  return std::count_if(ids.begin(), ids.end(), [&](Index id) {
    const auto v = static_cast<std::size_t>(id);
    if (v < after.points.size() && before.points[v] == after.points[v]) return false;
    return !std::binary_search(places.begin(), places.end(), before.points[v]);
  });
}

}  // namespace

Comparison compare(const TetMesh& before, const TetMesh& after, int threads) {
  for (const TetMesh* mesh : {&before, &after}) {
    if (const ValidationReport arrays = validate_arrays(*mesh); !arrays.ok()) throw MeshError(arrays.message(false));
  }
  const par::Cpu cpu(threads);
  // In a unit of which squares and cubes neither vanish nor overflow.
  const double scale = std::min(unit_scale(before), unit_scale(after));
  const Skin old_skin = find_skin(before, scale, cpu);
  const Skin new_skin = find_skin(after, scale, cpu);
  Comparison c;
  c.old_vertices = static_cast<std::int64_t>(before.points.size());
  c.new_vertices = static_cast<std::int64_t>(after.points.size());
  c.old_tets = static_cast<std::int64_t>(before.tets.size());
  c.new_tets = static_cast<std::int64_t>(after.tets.size());
  const auto old_volumes = region_volumes(before, scale);
  const auto new_volumes = region_volumes(after, scale);
  c.volume_change = relative(total(new_volumes), total(old_volumes));
  c.area_change = relative(new_skin.area, old_skin.area);
  c.region_volume_change = largest_change(old_volumes, new_volumes);
  const auto old_areas = patch_areas(before, scale);
  auto new_areas = patch_areas(after, scale);
  c.patch_area_change = largest_change(old_areas, new_areas);
  for (const auto& [tag, size] : old_areas)
    c.patches.push_back({tag, size / scale / scale, relative(new_areas[tag], size)});
  c.mean_edge = old_skin.mean_edge / scale;
  if (old_skin.mean_edge > 0 && !new_skin.triangles.empty()) {
    const ClosestTriangle old_surface(old_skin.triangles);
    c.vertices_to_old = farthest(new_skin.vertices, old_surface, cpu) / old_skin.mean_edge;
    c.new_to_old = farthest(new_skin.samples(), old_surface, cpu) / old_skin.mean_edge;
    c.old_to_new = farthest(old_skin.samples(), ClosestTriangle(new_skin.triangles), cpu) / old_skin.mean_edge;
  }
  c.vertex_tags_kept = before.points.size() == after.points.size()
                           ? before.point_tags == after.point_tags
                           : nonzero(before.point_tags) == nonzero(after.point_tags);
  c.tet_tags_kept = tag_set(before.tet_tags) == tag_set(after.tet_tags);
  c.triangle_tags_kept = nonzero(before.triangle_tags) == nonzero(after.triangle_tags);
  c.edge_tags_kept = nonzero(before.edge_tags) == nonzero(after.edge_tags);
  c.required_moved = count_moved(before, before.required_vertices, after, after.required_vertices);
  c.corners_moved = count_moved(before, before.corners, after, after.corners);
  return c;
}

}  // namespace tetune

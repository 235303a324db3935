// SPDX-License-Identifier: Apache-2.0
#include "quality/mesh_surface.hpp"

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

#include "backend/atomic.hpp"
#include "curved/surface_distance.hpp"
#include "math/mix_bits.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/tet_orientation.hpp"

namespace tetune {
namespace {

/// A triangle, or facets of a curved one that are within a thousandth of its longest chord.
std::vector<TrianglePoints> facets_of(const QuadraticSheet::Triangle& triangle) {
  constexpr double kFacetError = 1e-3;
  double chord = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    chord = std::max(chord, norm(triangle.corners[(k + 1) % 3] - triangle.corners[k]));
  }
  return divide_into_facets({triangle}, kFacetError * chord).facets;
}

std::uint64_t hash_of(const Vec3& p) {
  std::uint64_t hash = 0;
  // The sum makes a zero positive.
  for (const double x : {p.x, p.y, p.z}) hash = mix_bits(hash + std::bit_cast<std::uint64_t>(x + 0.0));
  return hash;
}
/// The hash of a triangle, which does not depend on the order of its vertices.
std::uint64_t hash_of(const TrianglePoints& t) { return mix_bits(hash_of(t[0]) + hash_of(t[1]) + hash_of(t[2])); }

/// Samples, each with the hash of its vertex or triangle.
struct HashedSamples {
  std::vector<SurfaceSample> samples;
  std::vector<std::uint64_t> hashes;

  void add(const SurfaceSample& sample, std::uint64_t hash) {
    samples.push_back(sample);
    hashes.push_back(hash);
  }
};

/// One in `stride` of the vertices, of the midpoints of edges, and of the centroids of triangles. Of the triangles at
/// an edge at least one lists it in increasing order of its end points, as their orientation is consistent.
HashedSamples sample_surface(const MeshSurface& surface, std::int64_t stride) {
  HashedSamples sampled;
  for (Size i = 0; i < std::ssize(surface.vertices); i += stride) {
    const MeshSurface::Vertex& v = span_of(surface.vertices)[i];
    const double radius = search_radius(span_of(surface.triangles)[v.triangle]);
    sampled.add({.point = v.point, .radius = radius, .is_vertex = true, .start = v.id}, hash_of(v.point));
  }
  std::int64_t left = 0;  // to pass before the next sample
  for (Size i = 0; i < std::ssize(surface.triangles); ++i) {
    const TrianglePoints& t = span_of(surface.triangles)[i];
    const Index start = surface.ids.empty() ? -1 : span_of(surface.ids)[i][0];
    const auto add = [&](const Vec3& p) {
      if (left-- > 0) return;
      left = stride - 1;
      sampled.add({.point = p, .radius = search_radius(t), .is_vertex = false, .start = start}, hash_of(t));
    };
    add((1.0 / 3) * (t[0] + t[1] + t[2]));
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& a = t[k];
      const Vec3& b = t[(k + 1) % 3];
      if (std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z)) add(0.5 * (a + b));
    }
  }
  return sampled;
}

/// A set of hashes with a mark for each, for those that another set has too.
class MarkedHashes {
 public:
  explicit MarkedHashes(const std::vector<std::uint64_t>& hashes)
      : mask_(std::bit_ceil(2 * hashes.size() + 1) - 1), slots_(mask_ + 1, kEmpty), marks_(mask_ + 1, 0) {
    for (const std::uint64_t hash : hashes) slots_[slot_of(hash)] = hash;
  }
  /// Marks a hash if it is in the set. May be called concurrently.
  void mark(std::uint64_t hash) {
    const std::size_t slot = slot_of(hash);
    if (slots_[slot] == hash) backend::store_shared(marks_[slot], std::uint8_t{1});
  }
  bool is_marked(std::uint64_t hash) const { return marks_[slot_of(hash)] != 0; }

 private:
  static constexpr std::uint64_t kEmpty = 0;

  /// The slot of a hash, or the one where it would be.
  std::size_t slot_of(std::uint64_t hash) const {
    std::size_t slot = hash & mask_;
    while (slots_[slot] != hash && slots_[slot] != kEmpty) slot = (slot + 1) & mask_;
    return slot;
  }

  std::size_t mask_;
  std::vector<std::uint64_t> slots_;
  std::vector<std::uint8_t> marks_;
};

/// The samples without those of vertices and triangles that the other surface has. A search for them could take long
/// where many triangles share a vertex, and find a rounding error.
std::vector<SurfaceSample> without_shared(HashedSamples sampled, const MeshSurface& other, const backend::Cpu& cpu) {
  MarkedHashes hashes(sampled.hashes);
  cpu.for_each(std::ssize(other.vertices), [&](Size i) { hashes.mark(hash_of(span_of(other.vertices)[i].point)); });
  cpu.for_each(std::ssize(other.triangles), [&](Size i) { hashes.mark(hash_of(span_of(other.triangles)[i])); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < sampled.samples.size(); ++i) {
    if (!hashes.is_marked(sampled.hashes[i])) sampled.samples[kept++] = sampled.samples[i];
  }
  sampled.samples.resize(kept);
  return std::move(sampled.samples);
}

}  // namespace

double area_of(const TrianglePoints& triangle) {
  return 0.5 * norm(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
}

MeshSurface find_surface(const TetMesh& mesh, double scale, int threads) {
  MeshSurface surface;
  surface.mesh_vertices = std::ssize(mesh.points);
  const TetMeshView positions(mesh, scale);
  std::vector<char> on_surface(mesh.points.size(), 0);
  double edge_sum = 0;
  Size boundary_faces = 0;
  const QuadraticTriangles quadratic(mesh.points, mesh.curved_edges);
  for_each_surface_face(mesh, threads, [&](const SortedHalfFace& face, bool is_boundary) {
    std::array<Index, 3> v = face.vertices;
    if (face.odd) std::swap(v[1], v[2]);
    const TrianglePoints triangle{positions.position(v[0]), positions.position(v[1]), positions.position(v[2])};
    for (std::size_t k = 0; k < 3; ++k) {
      char& seen = span_of(on_surface)[v[k]];
      if (seen == 0) surface.vertices.push_back({v[k], triangle[k], std::ssize(surface.triangles)});
      seen = 1;
    }
    double area = 0;
    if (mesh.curved_edges.empty()) {
      area = area_of(triangle);
      surface.triangles.push_back(triangle);
      surface.ids.push_back(v);
    } else {
      const QuadraticSheet::Triangle curved = scaled(quadratic.of(v), scale);
      area = area_of(curved);
      const std::vector<TrianglePoints> facets = facets_of(curved);
      surface.triangles.insert(surface.triangles.end(), facets.begin(), facets.end());
    }
    if (!is_boundary) return;
    ++boundary_faces;
    surface.area += area;
    for (std::size_t k = 0; k < 3; ++k) edge_sum += norm(triangle[(k + 1) % 3] - triangle[k]);
  });
  if (boundary_faces > 0) surface.mean_edge = edge_sum / (3 * static_cast<double>(boundary_faces));
  return surface;
}

LargestDistances max_distances(const MeshSurface& from, const MeshSurface& to, std::int64_t stride,
                               const backend::Cpu& cpu) {
  const std::vector<SurfaceSample> samples = without_shared(sample_surface(from, stride), to, cpu);
  if (from.ids.empty() || to.ids.empty() || from.mesh_vertices != to.mesh_vertices) {
    return max_distances(samples, to.triangles, cpu);
  }
  const SurfaceDescent descent(to.triangles, to.ids, to.mesh_vertices, cpu);
  return max_distances(samples, to.triangles, cpu, &descent);
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#include "driver/curved/curved_skeleton.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "backend/span.hpp"
#include "boundary/constraints.hpp"
#include "boundary/vertex_dof.hpp"
#include "curved/curved_edges.hpp"
#include "driver/curved/curved_slide.hpp"
#include "mesh/element_kinds.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/sorted.hpp"
#include "mesh/tet.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/vertex_layers.hpp"
#include "tetune/data.hpp"

namespace tetune {
namespace {

/// The largest distance of a mid-side node from the midpoint, relative to the edge, at which an edge of the surface is
/// no constraint; see is_straight().
constexpr double kStraightEdge = 1e-9;

/// The largest distance of a node from the plane of a flat triangle, relative to the root of twice its area.
constexpr double kFlatTriangle = 1e-6;

using Triangle = std::array<Index, 3>;
using Edge = std::array<Index, 2>;

constexpr std::array<std::array<std::size_t, 2>, 3> kSides{{{0, 1}, {1, 2}, {2, 0}}};

/// Calls f(vertices) for each face of the boundary and between regions, and for each listed triangle that is tagged or
/// required.
template <class F>
void for_each_surface_triangle(const TetMesh& mesh, const F& f) {
  for_each_surface_face(mesh, 1, [&](const SortedHalfFace& face, bool) { f(face.vertices); });
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.triangle_tags[i] != 0) f(mesh.triangles[i]);
  }
  for (const Index i : mesh.required_triangles) f(span_of(mesh.triangles)[i]);
}

/// The entries of a list of the result, of `entries` in all, whose original is one of `originals`.
std::vector<Index> with_original(const std::vector<Index>& originals, const std::vector<Index>& new2original,
                                 std::size_t entries) {
  const std::set<Index> sought(originals.begin(), originals.end());
  std::vector<Index> result;
  for (Index i = 0; i < Index(entries); ++i) {
    if (sought.contains(original_of(new2original, i))) result.push_back(i);
  }
  return result;
}

/// Drops the entries of a list of the result that were added to the `originals` of the whole mesh. Returns those that
/// stay.
std::vector<Index> drop_added(std::size_t originals, std::size_t entries, std::vector<Index>& new2original) {
  std::vector<Index> kept;
  std::vector<Index> kept2original;
  for (Index i = 0; i < Index(entries); ++i) {
    const Index original = original_of(new2original, i);
    if (original >= Index(originals)) continue;
    kept.push_back(i);
    kept2original.push_back(original);
  }
  new2original = empty_if_identity(std::move(kept2original), originals);
  return kept;
}

}  // namespace

std::vector<Index> with_folded_face(const TetMesh& mesh, const std::vector<Index>& tets) {
  std::set<Triangle> surface;
  for_each_surface_triangle(mesh, [&surface](const Triangle& t) { surface.insert(ascending(t)); });
  const CurvedEdges edges(mesh);
  const auto tangent = [&](Index from, Index to) {
    const Vec3 p = vec(span_of(mesh.points)[from]);
    return 4.0 * (edges.middle(from, to) - p) - (vec(span_of(mesh.points)[to]) - p);
  };
  const auto is_folded = [&](const Triangle& t) {
    const Vec3 a = vec(span_of(mesh.points)[t[0]]);
    const Vec3 normal = cross(vec(span_of(mesh.points)[t[1]]) - a, vec(span_of(mesh.points)[t[2]]) - a);
    const bool is_flat = std::all_of(kSides.begin(), kSides.end(), [&](const auto& side) {
      const Vec3 middle = edges.middle(t[side[0]], t[side[1]]) - a;
      return std::fabs(dot(middle, normal)) <= kFlatTriangle * norm(normal) * std::sqrt(norm(normal));
    });
    return is_flat && std::any_of(kSides.begin(), kSides.end(), [&](const auto& side) {
             const Index at = t[side[0]];
             const Index third = t[3 - side[0] - side[1]];
             return dot(cross(tangent(at, t[side[1]]), tangent(at, third)), normal) <= 0;
           });
  };
  std::vector<Index> folded;
  for (const Index tet : tets) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Triangle face = ascending_face(span_of(mesh.tets)[tet], k);
      if (!surface.contains(face) || !is_folded(face)) continue;
      folded.push_back(tet);
      break;
    }
  }
  return folded;
}

std::vector<Index> find_unfolded(const TetMesh& mesh, int threads) {
  std::vector<Index> tets = find_invalid(mesh, threads);
  erase_listed(tets, with_folded_face(mesh, tets));
  return tets;
}

std::vector<Index> flatter_than(const TetMesh& mesh, double dihedral, int threads) {
  constexpr double kAngleRounding = 1e-9;
  const std::vector<std::int8_t> signs = volume_signs(mesh, threads);
  std::vector<Index> tets;
  for (Index t = 0; t < std::ssize(mesh.tets); ++t) {
    std::array<Vec3, 4> corners{};
    for (std::size_t k = 0; k < 4; ++k) corners[k] = vec(span_of(mesh.points)[span_of(mesh.tets)[t][k]]);
    const bool is_flat = min_dihedral(corners) < (1 - kAngleRounding) * dihedral;
    if (is_flat || span_of(signs)[t] != 1) tets.push_back(t);
  }
  return tets;
}

void lock_around(const TetMesh& mesh, std::vector<std::uint8_t> is_marked, int rings, std::vector<Index>& locked) {
  const std::size_t before = locked.size();
  Size around = 0;
  do {
    if (around > 0) add_layer(mesh.tets, is_marked);
    const std::vector<std::uint8_t> touches = tets_at(mesh.tets, is_marked);
    around = std::count(touches.begin(), touches.end(), 1);
    for (Index t = 0; t < std::ssize(touches); ++t) {
      if (span_of(touches)[t] != 0) locked.push_back(t);
    }
    sort_unique(locked);
  } while (--rings > 0 || (locked.size() == before && around > 0 && around < std::ssize(mesh.tets)));
}

HeldNodes find_held(const TetMesh& mesh, const Options& options) {
  HeldNodes held;
  const Constraints constraints = find_constraints(mesh, options);
  for (const VertexConstraint constraint : constraints.vertices) {
    held.vertices.push_back(constraint == VertexConstraint::none ? 0 : 1);
  }
  for_each_surface_triangle(mesh, [&held](const Triangle& t) {
    for (const auto& [i, j] : kSides) held.edges.push_back(ascending(t[i], t[j]));
  });
  for (const Edge& e : mesh.edges) held.edges.push_back(ascending(e[0], e[1]));
  for_each_other_middle(mesh, [&held](Index a, Index b) { held.edges.push_back(ascending(a, b)); });
  for (const Index t : constraints.locked_tets) {
    const auto& tet = span_of(mesh.tets)[t];
    for (const auto& [i, j] : kCurvedTetEdges) held.edges.push_back(ascending(tet[i], tet[j]));
  }
  sort_unique(held.edges);
  for (const Edge& e : held.edges) {
    for (const Index v : e) span_of(held.vertices)[v] = 1;
  }
  return held;
}

CurvedSkeleton::CurvedSkeleton(const TetMesh& whole, const HeldNodes& held, const std::vector<Index>& locked_tets,
                               const CurvedSlide* slide)
    : mesh(whole), whole_(whole), slide_(slide) {
  mesh.curved_edges.clear();
  keep_edges(held, locked_tets);
  require_triangles();
  if (slide_ != nullptr) slide_->constrain(mesh);
  mesh.required_tets.insert(mesh.required_tets.end(), locked_tets.begin(), locked_tets.end());
  sort_unique(mesh.required_tets);
}

void CurvedSkeleton::keep_edges(const HeldNodes& held, const std::vector<Index>& locked_tets) {
  std::set<Edge> locked;
  for (const Index t : locked_tets) {
    const auto& tet = span_of(whole_.tets)[t];
    for (const auto& [i, j] : kCurvedTetEdges) locked.insert(ascending(tet[i], tet[j]));
  }
  for (const CurvedEdge& edge : whole_.curved_edges) {
    const auto& [a, b] = edge.vertices;
    const bool is_held = held.has_edge(a, b);
    const bool may_move = slide_ != nullptr && slide_->has_edge(edge.vertices);
    if (locked.contains(edge.vertices) || (is_held && !may_move && !is_straight(whole_, edge, kStraightEdge))) {
      kept_.push_back(edge);
    } else if (is_held) {
      kept_unmoved_.push_back(edge);
    }
  }
}

void CurvedSkeleton::require_triangles() {
  const auto is_kept = [this](Index a, Index b) { return find_edge(kept_, ascending(a, b)) != nullptr; };
  std::set<Triangle> curved;
  for_each_surface_triangle(whole_, [&](const Triangle& t) {
    if (is_kept(t[0], t[1]) || is_kept(t[1], t[2]) || is_kept(t[2], t[0])) curved.insert(ascending(t));
  });
  for (Index i = 0; i < std::ssize(mesh.triangles); ++i) {
    const auto at = curved.find(ascending(span_of(mesh.triangles)[i]));
    if (at == curved.end()) continue;
    mesh.required_triangles.push_back(i);
    curved.erase(at);
  }
  std::vector<Index> new2old = identity_map(mesh.triangles.size());
  for (const Triangle& t : curved) {
    mesh.required_triangles.push_back(to_index(mesh.triangles.size()));
    mesh.triangles.push_back(t);
    mesh.triangle_tags.push_back(0);
    new2old.push_back(-1);
  }
  mesh.triangle_data = take_entries(mesh.triangle_data, new2old);
  for (Index e = 0; e < std::ssize(mesh.edges); ++e) {
    const Edge& edge = span_of(mesh.edges)[e];
    if (is_kept(edge[0], edge[1])) mesh.required_edges.push_back(e);
  }
  for (auto* list : {&mesh.required_triangles, &mesh.required_edges}) {
    sort_unique(*list);
  }
}

void CurvedSkeleton::restore(Report& report) {
  restore_triangles(report);
  restore_edges(report);
  restore_lists(report);
  restore_curved_edges(report);
}

void CurvedSkeleton::restore_triangles(Report& report) {
  const std::vector<Index> kept = drop_added(whole_.triangles.size(), mesh.triangles.size(), report.triangle2original);
  mesh.triangles = gather_entries(mesh.triangles, kept);
  mesh.triangle_tags = gather_entries(mesh.triangle_tags, kept);
  mesh.triangle_data = take_entries(mesh.triangle_data, kept);
}

void CurvedSkeleton::restore_edges(Report& report) {
  const std::vector<Index> kept = drop_added(whole_.edges.size(), mesh.edges.size(), report.edge2original);
  mesh.edges = gather_entries(mesh.edges, kept);
  mesh.edge_tags = gather_entries(mesh.edge_tags, kept);
  mesh.edge_data = take_entries(mesh.edge_data, kept);
}

void CurvedSkeleton::restore_lists(const Report& report) {
  mesh.required_triangles = with_original(whole_.required_triangles, report.triangle2original, mesh.triangles.size());
  mesh.required_edges = with_original(whole_.required_edges, report.edge2original, mesh.edges.size());
  mesh.required_tets = with_original(whole_.required_tets, report.tet2original, mesh.tets.size());
  if (slide_ == nullptr) return;
  mesh.required_vertices = with_original(whole_.required_vertices, report.vertex2original, mesh.points.size());
  mesh.ridges = with_original(whole_.ridges, report.edge2original, mesh.edges.size());
}

void CurvedSkeleton::restore_curved_edges(const Report& report) {
  const std::vector<Index> new2old = explicit_map(report.vertex2original, mesh.points.size());
  const std::vector<Index> old2new = inverse_map(new2old, whole_.points.size());
  std::set<Edge> edges;
  const auto add = [&edges](const auto& elements) {
    for (const auto& element : elements) {
      for (std::size_t i = 0; i < element.size(); ++i) {
        for (std::size_t j = i + 1; j < element.size(); ++j) edges.insert(ascending(element[i], element[j]));
      }
    }
  };
  add(mesh.tets);
  add(mesh.triangles);
  add(mesh.edges);
  for_each_other_middle(mesh, [&edges](Index a, Index b) { edges.insert(ascending(a, b)); });
  const auto vertices_now = [&](const CurvedEdge& edge) {
    return Edge{span_of(old2new)[edge.vertices[0]], span_of(old2new)[edge.vertices[1]]};
  };
  const auto has_moved = [&](Index from, Index to) {
    return to >= 0 && span_of(whole_.points)[from] != span_of(mesh.points)[to];
  };
  const auto restore = [&](const CurvedEdge& edge) {
    const Edge now = vertices_now(edge);
    if (now[0] >= 0 && now[1] >= 0 && edges.contains(now)) mesh.curved_edges.push_back({now, edge.middle});
  };
  mesh.curved_edges.clear();
  for (const CurvedEdge& edge : kept_) restore(edge);
  for (const CurvedEdge& edge : kept_unmoved_) {
    const Edge now = vertices_now(edge);
    if (!has_moved(edge.vertices[0], now[0]) && !has_moved(edge.vertices[1], now[1])) restore(edge);
  }
  // Vertices keep their order.
  std::sort(mesh.curved_edges.begin(), mesh.curved_edges.end(), is_before);
}

}  // namespace tetune

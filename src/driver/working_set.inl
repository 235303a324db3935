// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>

#include "core/unit_scale.hpp"
#include "core/upload.hpp"
#include "core/validate_arrays.hpp"
#include "driver/boundary_triangles.inl"
#include "driver/constraints.hpp"
#include "driver/slide_surface.inl"
#include "driver/working_set.hpp"
#include "par/atomic.hpp"
#include "tetune/data.hpp"
#include "tetune/error.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace working_set_detail {

struct NotCertified {
  MeshView mesh;
  TETUNE_HD bool operator()(Size t) const {
    const Tet tet = mesh.tet2vertex[t];
    const Orient o =
        orient(vec(mesh.points[tet[0]]), vec(mesh.points[tet[1]]), vec(mesh.points[tet[2]]), vec(mesh.points[tet[3]]));
    return !o.certified();
  }
};

struct LockTet {
  MeshView mesh;
  Span<const Index> slots;
  TETUNE_HD void operator()(Size i) const {
    for (int f = 0; f < 4; ++f) {
      const Link link = par::load_shared(mesh.tet2tet[slots[i]][f]);
      if (link == kNoLink) continue;
      par::atomic_or(mesh.tet2tet[slots[i]][f], kLocked);
      par::atomic_or(mesh.tet2tet[link_tet(link)][link_face(link)], kLocked);
    }
  }
};

/// Edges as pairs of work vertices, and ready to be looked up.
template <class Backend>
struct EdgeSet {
  typename Backend::template Buffer<Index> ends;
  typename Backend::template Buffer<std::uint64_t> keys;
  typename Backend::template Buffer<std::uint8_t> on_vertex;

  EdgeSet(const std::vector<Index>& pairs, Size vertices) {
    std::vector<std::uint64_t> sorted;
    std::vector<std::uint8_t> flags(static_cast<std::size_t>(vertices), 0);
    for (std::size_t e = 0; e < pairs.size(); e += 2) {
      sorted.push_back(ConstrainedEdges::edge_key(pairs[e], pairs[e + 1]));
      flags[static_cast<std::size_t>(pairs[e])] = flags[static_cast<std::size_t>(pairs[e + 1])] = 1;
    }
    std::sort(sorted.begin(), sorted.end());
    ends.upload(pairs);
    keys.upload(sorted);
    on_vertex.upload(flags);
  }
  ConstrainedEdges view() const { return {keys.span(), on_vertex.span()}; }
};

/// Whether the edges from `first` on can be feature lines, given where vertices may go without them: lines meet in few
/// places. (TetGen lists and tags all edges of its input.)
inline bool are_lines(const std::vector<Index>& ends, std::size_t first, const std::vector<Mobility>& kind) {
  std::vector<std::uint8_t> degree(kind.size(), 0);
  for (std::size_t i = first; i < ends.size(); ++i) {
    std::uint8_t& d = degree[static_cast<std::size_t>(ends[i])];
    if (d < 3) ++d;
  }
  PlainCount count;
  for (std::size_t v = 0; v < kind.size(); ++v) {
    if (kind[v] != Mobility::free) ++count.constrained;
    if (kind[v] != Mobility::fixed && degree[v] > 2) ++count.plain;
  }
  return count.few();
}

/// Of the mean length of its edges on the surface: so far may a vertex go there, by way of planes and lines, or over a
/// curved surface.
inline constexpr double kLeash = 0.5;
inline constexpr double kSlideLeash = 0.75;

struct FindLeash {
  Span<const Point> points;
  Span<const SurfaceTriangle> triangles;
  RowsView vertex2corner;
  double part;
  Span<Leash> leash;
  TETUNE_HD void operator()(Size v) const {
    const Vec3 home = vec(points[v]);
    double sum = 0;
    Size edges = 0;
    for (Size c = vertex2corner.begin(v); c < vertex2corner.end(v); ++c) {
      for (const Index other : triangles[vertex2corner.items[c] / 3].v) {
        if (other == v) continue;
        sum += norm(vec(points[other]) - home);
        ++edges;
      }
    }
    leash[v] = {home, edges > 0 ? part * sum / static_cast<double>(edges) : Leash::kEndless};
  }
};

/// Each vertex starts on its own place of the reference surface.
struct StartSite {
  Span<Site> site;
  TETUNE_HD void operator()(Size v) const { site[v] = {SiteKind::vertex, static_cast<Index>(v)}; }
};

/// The tetrahedra without the padding and order of the work mesh.
struct ToOriginal {
  Span<const Index> vertex2original;
  Span<Tet> tets;
  TETUNE_HD void operator()(Size t) const {
    Tet tet = tets[t];
    for (int k = 0; k < 4; ++k) tet[k] = vertex2original[tet[k]];
    tets[t] = tet;
  }
};

/// The caller's vertex ids, extended by those of the inserted vertices.
struct VertexIds {
  std::vector<Index> work2extended;  ///< or kRemoved
  std::vector<Index> extended2new;   ///< where they are once the removed ones are gone; -1 for these
  std::vector<Index> new2original;   ///< or -1 for inserted ones; empty where all were kept
  bool removed = false;

  /// Where each work vertex is in the result; kRemoved for those that are not.
  std::vector<Index> work2new() const {
    std::vector<Index> ids = work2extended;
    for (Index& v : ids) v = v == kRemoved ? v : extended2new[static_cast<std::size_t>(v)];
    return ids;
  }
};

inline VertexIds vertex_ids(std::vector<Index> vertex2original, std::size_t originals) {
  VertexIds ids;
  std::vector<std::uint8_t> keep(originals, 0);
  for (Index& v : vertex2original) {
    if (v == kInserted) {
      v = static_cast<Index>(keep.size());
      keep.push_back(1);
    } else if (v != kRemoved) {
      keep[static_cast<std::size_t>(v)] = 1;
    }
  }
  ids.removed = std::find(keep.begin(), keep.end(), 0) != keep.end();
  ids.extended2new = positions_of_kept(keep);
  if (ids.removed || keep.size() > originals) {
    for (std::size_t v = 0; v < keep.size(); ++v) {
      if (keep[v] != 0) ids.new2original.push_back(v < originals ? static_cast<Index>(v) : -1);
    }
  }
  ids.work2extended = std::move(vertex2original);
  return ids;
}

/// The inverse of positions_of_kept(); empty where all are.
inline std::vector<Index> kept_of(const std::vector<Index>& old2new) {
  std::vector<Index> new2old;
  for (std::size_t i = 0; i < old2new.size(); ++i) {
    if (old2new[i] >= 0) new2old.push_back(static_cast<Index>(i));
  }
  if (new2old.size() == old2new.size()) new2old.clear();
  return new2old;
}

/// The regions of the tetrahedra that these of the caller's became.
inline std::vector<int> tags_of(const std::vector<Index>& tet2original, const TetMesh& mesh) {
  std::vector<int> tags;
  tags.reserve(tet2original.size());
  for (const Index t : tet2original) tags.push_back(mesh.tet_tags[static_cast<std::size_t>(t)]);
  return tags;
}

/// Where the vertices are now. Those that did not move keep their place to the last bit.
inline void put_points(const std::vector<Point>& points, const VertexIds& ids, double scale,
                       std::vector<Point3>& extended) {
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (ids.work2extended[v] == kRemoved) continue;
    Point3& p = extended[static_cast<std::size_t>(ids.work2extended[v])];
    const Vec3 before = scale * vec(p);
    const Vec3 now = vec(points[v]);
    if (before.x == now.x && before.y == now.y && before.z == now.z) continue;
    p = {now.x / scale, now.y / scale, now.z / scale};
  }
}

/// Where all vertices are, removed ones too, under extended ids.
inline std::vector<Point3> extended_points(const TetMesh& before, const std::vector<Point>& points,
                                           const VertexIds& ids, double scale) {
  std::vector<Point3> extended = before.points;
  extended.resize(ids.extended2new.size());
  put_points(points, ids, scale, extended);
  return extended;
}

inline std::vector<DataArray> data_of_kept(const std::vector<DataArray>& data, const std::vector<Index>& old2new) {
  if (data.empty()) return {};
  std::vector<Index> new2old;
  for (std::size_t i = 0; i < old2new.size(); ++i) {
    if (old2new[i] >= 0) new2old.push_back(static_cast<Index>(i));
  }
  return take_entries(data, new2old);
}

/// Data of the vertices in the result. `tets` are in extended ids.
inline std::vector<DataArray> carried_point_data(const TetMesh& mesh, const std::vector<std::array<Index, 4>>& tets,
                                                 const std::vector<Point>& points, const VertexIds& ids, double scale) {
  if (mesh.point_data.empty() || ids.new2original.empty()) return mesh.point_data;
  const std::vector<Point3> extended = extended_points(mesh, points, ids, scale);
  std::vector<Index> extended2original(extended.size(), -1);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) extended2original[v] = static_cast<Index>(v);
  return data_of_kept(carry_point_data(mesh.point_data, extended2original, extended, tets), ids.extended2new);
}

/// The bound on the deviation takes the surface for one of the input's triangles.
inline bool flips_boundary(const Options& options) {
  return options.flips && options.boundary_flips && options.boundary != Boundary::fixed &&
         !(options.max_deviation > 0) && options.max_ring > 3;
}

/// Throws OverlapError where flips have made faces of three and more tetrahedra.
inline void check_faces(const TetMesh& before, const std::vector<Point>& points, const VertexIds& ids, double scale,
                        const decltype(TetMesh::tets)& tets, const std::vector<Index>& tet2original, int threads) {
  TetMesh after;
  after.points = extended_points(before, points, ids, scale);
  after.point_tags.resize(after.points.size());
  after.tets = tets;
  after.tet_tags.resize(tets.size());
  std::vector<Index> there;
  for (const Finding& finding : validate(after, threads).findings) {
    for (const Index t : finding.first) there.push_back(tet2original[static_cast<std::size_t>(t)]);
  }
  if (there.empty()) return;
  std::sort(there.begin(), there.end());
  there.erase(std::unique(there.begin(), there.end()), there.end());
  throw OverlapError(std::move(there));
}

/// Throws unless every volume is positive, or shall be made so; the few that rounding leaves in doubt are decided
/// exactly.
template <class Backend>
void check_volumes(const Backend& par, const TetMesh& mesh, const Options& options, WorkingSet<Backend>& work) {
  typename Backend::template Buffer<Index> doubtful(work.mesh.slots());
  const Size count = par.compact(work.mesh.slots(), NotCertified{work.mesh.view()}, doubtful.span());
  if (count == 0) return;
  // Exact arithmetic has the last word.
  const ValidationReport report = validate(mesh, options.threads);
  for (const Finding& f : report.findings) {
    const bool repairable = f.defect == Defect::inverted_tet || f.defect == Defect::flat_tet;
    if (!options.untangle || !repairable) throw MeshError(report.message(false));
    work.tangled += f.count;
  }
}

/// From the caller's ids to those of the work mesh.
inline std::vector<Index> inverse(const std::vector<Index>& to_original) {
  std::vector<Index> ids(to_original.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[static_cast<std::size_t>(to_original[i])] = static_cast<Index>(i);
  return ids;
}

/// Required tetrahedra and frozen regions.
template <class Backend>
void lock_tets(const Backend& par, const std::vector<Index>& tets, std::size_t required, WorkingSet<Backend>& work) {
  if (tets.empty()) return;
  const std::vector<Index> original2slot = inverse(work.mesh.tet2original.download());
  std::vector<Index> locked;
  for (const Index t : tets) locked.push_back(original2slot[static_cast<std::size_t>(t)]);
  typename Backend::template Buffer<Index> slots;
  slots.upload(locked);
  par.for_each(slots.size(), LockTet{work.mesh.view(), slots.span()});
  locked.resize(required);  // they come first
  work.required_slots = std::move(locked);
}

/// kMovable, kFrozen or kCorner for each work vertex. Listed triangles that are no faces hold their vertices.
inline std::vector<std::uint8_t> frozen_vertices(const TetMesh& mesh, const std::vector<std::uint8_t>& by_original,
                                                 const std::vector<Listed>& triangles,
                                                 const std::vector<Index>& original2vertex) {
  std::vector<std::uint8_t> frozen(mesh.points.size(), kMovable);
  const auto of = [&](std::size_t v) -> std::uint8_t& { return frozen[static_cast<std::size_t>(original2vertex[v])]; };
  for (std::size_t v = 0; v < frozen.size(); ++v) of(v) = by_original[v];
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (triangles[t] != Listed::absent) continue;
    for (const Index v : mesh.triangles[t]) of(static_cast<std::size_t>(v)) = kFrozen;
  }
  return frozen;
}

/// What vertices on the mesh's own surface may do. `ends`: those of the constrained edges, of which the first `ridges`
/// are ridges and required ones.
template <class Backend>
void find_mobilities(const Backend& par, const Options& options, const Surface<Backend>& surface,
                     const std::vector<Index>& ends, std::size_t ridges, const EdgeSet<Backend>& edges,
                     Span<std::uint8_t> frozen, WorkingSet<Backend>& work, Report& report) {
  Mobilities<Backend>& m = work.mobilities;
  const bool slides = options.boundary == Boundary::slide;
  const auto classify = [&](Span<const Index> feature_ends, const ConstrainedEdges& features) {
    if (slides) {
      build_reference(par, work.mesh, surface, feature_ends, features, frozen, options.feature_angle, m.kind.span(),
                      m.reference);
    } else {
      classify_vertices(par, work.mesh, surface, feature_ends, features, frozen, options.boundary == Boundary::fixed,
                        m.kind.span(), m.axis.span());
    }
  };
  // Ridges and required edges are features; tagged ones as well, unless they are too many to be lines.
  const EdgeSet<Backend> sharp({ends.begin(), ends.begin() + 2 * static_cast<std::ptrdiff_t>(ridges)},
                               work.mesh.vertices());
  classify(sharp.ends.span(), sharp.view());
  const auto tagged = static_cast<std::int64_t>(ends.size() / 2 - ridges);
  if (tagged > 0) {
    if (are_lines(ends, 2 * ridges, m.kind.download())) {
      classify(edges.ends.span(), work.flips.constrained());
    } else {
      report.edges_not_held = tagged;
    }
  }
  report.corners_not_held = hold_corners(par, frozen, m.kind.span());
  if (slides) {
    m.reference.kind.assign(m.kind);
    par.for_each(work.mesh.vertices(), StartSite{m.site.span()});
  }
}

inline void count_mobilities(const std::vector<Mobility>& kinds, Report& report) {
  for (const Mobility kind : kinds) {
    ++(kind == Mobility::free      ? report.free_vertices
       : kind == Mobility::plane   ? report.plane_vertices
       : kind == Mobility::line    ? report.line_vertices
       : kind == Mobility::surface ? report.surface_vertices
       : kind == Mobility::curve   ? report.curve_vertices
                                   : report.fixed_vertices);
  }
}

}  // namespace working_set_detail

template <class Backend>
void load(const Backend& par, const TetMesh& mesh, const Options& options, const SlideSurface* slides_on,
          WorkingSet<Backend>& work, Report& report) {
  using namespace working_set_detail;
  const ValidationReport arrays = validate_arrays(mesh);
  if (!arrays.ok()) throw MeshError(arrays.message(false));
  const Constraints constraints = find_constraints(mesh, options);

  work.scale = unit_scale(mesh);
  work.mesh = upload_mesh<Backend>(mesh, work.scale);
  work.mesh.law = law_of(options.energy);
  sort_mesh(par, work.mesh);
  const std::vector<Index> original2vertex = inverse(work.mesh.vertex2original.download());
  const AdjacencyReport adjacency = build_adjacency(par, work.mesh);
  if (adjacency.crowded_faces + adjacency.same_side_faces > 0) {
    throw MeshError(validate(mesh, options.threads).message(false));
  }
  check_volumes(par, mesh, options, work);
  const typename Backend::template Loan<int> tet_tags(mesh.tet_tags);
  lock_interfaces(par, work.mesh, tet_tags.span());
  lock_tets(par, constraints.locked_tets, mesh.required_tets.size(), work);

  // The surface, and the listed triangles.
  std::vector<std::uint8_t> required;
  if (!mesh.required_triangles.empty()) {
    required.resize(mesh.triangles.size(), 0);
    for (const Index t : mesh.required_triangles) required[static_cast<std::size_t>(t)] = 1;
  }
  const typename Backend::template Loan<std::array<Index, 3>> triangles(mesh.triangles);
  const typename Backend::template Loan<int> tags(mesh.triangle_tags);
  const typename Backend::template Loan<std::uint8_t> required_loan(required);
  const typename Backend::template Loan<int> frozen_patches(options.frozen_patches);
  const typename Backend::template Loan<Index> original2vertex_loan(original2vertex);
  const ListedTriangles listed{{reinterpret_cast<const Index*>(triangles.span().data()), 3 * triangles.span().size()},
                               tags.span(),
                               required_loan.span(),
                               frozen_patches.span(),
                               original2vertex_loan.span(),
                               options.open_boundaries};
  typename Backend::template Buffer<Listed> listed_state;
  Surface<Backend> surface;
  build_surface(par, work.mesh, listed, listed_state, surface);
  work.listed_triangles = listed_state.download();

  work.frozen = frozen_vertices(mesh, constraints.frozen, work.listed_triangles, original2vertex);
  typename Backend::template Buffer<std::uint8_t> frozen;
  frozen.upload(work.frozen);
  constexpr Size kMostCorners = std::numeric_limits<Index>::max();
  if (flips_boundary(options) && 3 * surface.triangles.size() <= kMostCorners) {
    build_boundary(par, surface, listed, frozen.span(), work.boundary);
  }

  // Listed edges: all hold against flips.
  std::vector<Index> ends;
  for (const auto& edge : constraints.edges) {
    for (const Index v : edge) ends.push_back(original2vertex[static_cast<std::size_t>(v)]);
  }
  EdgeSet<Backend> edges(ends, work.mesh.vertices());
  work.flips.constrained_keys.swap(edges.keys);
  work.flips.constrained_vertex.swap(edges.on_vertex);

  // What the vertices may do.
  const Size vertices = work.mesh.vertices();
  Mobilities<Backend>& m = work.mobilities;
  m.kind.resize(vertices);
  m.axis.resize(vertices);
  m.awake.resize(vertices);
  par.fill(m.awake.span(), std::uint8_t{1});
  const bool slides = options.boundary == Boundary::slide;
  if (slides) {
    m.max_deviation = (1 - 1e-9) * options.max_deviation * work.scale;  // a little less, for rounding
    // 0 would be none.
    if (options.max_deviation > 0) m.max_deviation = std::max(m.max_deviation, std::numeric_limits<double>::min());
    m.site.resize(vertices);
  }
  if (slides_on != nullptr) {
    take_surface(par, *slides_on, original2vertex, frozen.span(), work);
  } else {
    find_mobilities(par, options, surface, ends, constraints.ridges, edges, frozen.span(), work, report);
  }
  if (options.energy == Energy::shape && options.boundary != Boundary::fixed) {
    m.leash.resize(vertices);
    par.for_each(vertices, FindLeash{work.mesh.points.span(), surface.triangles.span(), surface.vertex2corner.view(),
                                     slides ? kSlideLeash : kLeash, m.leash.span()});
  }
  count_mobilities(m.kind.download(), report);
}

template <class Backend>
void store(const Backend& par, WorkingSet<Backend>& work, const Options& options, TetMesh& mesh,
           SlideSurface* slides_on, Report& report) {
  using namespace working_set_detail;
  // All that may fail comes first, so that the caller's mesh changes as a whole or not at all.
  const bool check = count_doubled_faces(par, work.mesh) > 0;
  const std::vector<Index> slot_of = compact_slots(par, work.mesh).download();
  VertexIds ids = vertex_ids(work.mesh.vertex2original.download(), mesh.points.size());
  work.mesh.vertex2original.upload(ids.work2extended);
  par.for_each(work.mesh.slots(), ToOriginal{work.mesh.vertex2original.span(), work.mesh.tet2vertex.span()});
  decltype(mesh.tets) tets(static_cast<std::size_t>(work.mesh.slots()));
  Backend::download(tets.data(), work.mesh.tet2vertex.span().data(), tets.size() * sizeof(Tet));
  std::vector<Index> tet2original = work.mesh.tet2original.download();
  std::vector<int> tet_tags = tags_of(tet2original, mesh);
  const std::vector<Point> points = work.mesh.points.download();
  if (check) check_faces(mesh, points, ids, work.scale, tets, tet2original, options.threads);
  mesh.points.reserve(ids.extended2new.size());
  mesh.point_tags.reserve(ids.extended2new.size());
  std::vector<std::uint8_t> keep(mesh.triangles.size());
  const OtherElements others(mesh);
  for (std::size_t t = 0; t < keep.size(); ++t) {
    keep[t] = work.listed_triangles[t] != Listed::loose || others.have(mesh.triangles[t]) ? 1 : 0;
  }
  const std::vector<Index> new_triangles = positions_of_kept(keep);
  const std::vector<Index> new_edges = positions_of_kept(lasting_edges(mesh, tets, others));
  std::vector<Index> triangle2original = kept_of(new_triangles);
  std::vector<Index> edge2original = kept_of(new_edges);
  const std::vector<BoundaryTriangle> boundary = work.boundary.triangles.download();
  auto point_data = carried_point_data(mesh, tets, points, ids, work.scale);
  auto tet_data = take_entries(mesh.tet_data, tet2original);
  auto triangle_data = data_of_kept(mesh.triangle_data, new_triangles);
  auto edge_data = data_of_kept(mesh.edge_data, new_edges);
  std::vector<std::array<Index, 3>> sites;
  if (slides_on != nullptr) sites = tell_sites(par, work, ids.work2extended);

  // From here on nothing fails.
  if (slides_on != nullptr) slides_on->site.swap(sites);
  mesh.point_data.swap(point_data);
  mesh.tet_data.swap(tet_data);
  mesh.triangle_data.swap(triangle_data);
  mesh.edge_data.swap(edge_data);
  mesh.tets.swap(tets);
  mesh.tet_tags.swap(tet_tags);
  mesh.points.resize(ids.extended2new.size());
  mesh.point_tags.resize(ids.extended2new.size(), 0);
  follow_flips(boundary, ids.work2extended, mesh.triangles);
  put_points(points, ids, work.scale, mesh.points);

  // Required tetrahedra never left their slots; compaction kept the order of the slots.
  for (std::size_t i = 0; i < mesh.required_tets.size(); ++i) {
    const auto at = std::lower_bound(slot_of.begin(), slot_of.end(), work.required_slots[i]);
    mesh.required_tets[i] = static_cast<Index>(at - slot_of.begin());
  }

  report.triangles_dropped = keep_triangles(mesh, new_triangles);
  report.edges_dropped = keep_edges(mesh, new_edges);
  if (ids.removed) keep_vertices(mesh, ids.extended2new);
  report.vertex2original = std::move(ids.new2original);
  report.tet2original = std::move(tet2original);
  report.triangle2original = std::move(triangle2original);
  report.edge2original = std::move(edge2original);
}

}  // namespace tetune

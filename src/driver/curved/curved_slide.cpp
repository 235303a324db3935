// SPDX-License-Identifier: Apache-2.0
#include "driver/curved/curved_slide.hpp"

#include <algorithm>
#include <numbers>
#include <set>
#include <utility>

#include "backend/span.hpp"
#include "curved/curved_edges.hpp"
#include "curved/surface_distance.hpp"
#include "driver/curved/chunked_queries.hpp"
#include "driver/curved/curved_sheets.hpp"
#include "math/constants.hpp"
#include "math/elementary.hpp"
#include "mesh/id_maps.hpp"
#include "mesh/sorted.hpp"
#include "mesh/tet.hpp"
#include "tetune/data.hpp"

namespace tetune {
namespace {

using Edge = std::array<Index, 2>;

constexpr double kNoFeature = 180;

std::array<Edge, 3> edges_of(const std::array<Index, 3>& t) {
  return {ascending(t[0], t[1]), ascending(t[1], t[2]), ascending(t[2], t[0])};
}

Vec3 at(const TetMesh& mesh, Index v) { return vec(span_of(mesh.points)[v]); }

/// The direction in which a quadratic triangle leaves the mid-side node of an edge: within it, perpendicular to the
/// edge.
Vec3 direction_at_middle(const TetMesh& mesh, const CurvedEdges& edges, const Edge& edge,
                         const std::array<Index, 3>& triangle) {
  const auto [a, b] = edge;
  const Index c = triangle[0] ^ triangle[1] ^ triangle[2] ^ a ^ b;  // the vertex that is not on the edge
  const Vec3 along = at(mesh, b) - at(mesh, a);
  const Vec3 inward = 2 * (edges.middle(a, c) + edges.middle(b, c) - edges.middle(a, b)) -
                      0.5 * (at(mesh, a) + at(mesh, b)) - at(mesh, c);
  const Vec3 d = inward - (dot(inward, along) / dot(along, along)) * along;
  return (1 / norm(d)) * d;
}

/// The unit tangent of an edge at its end `from`.
Vec3 tangent(const TetMesh& mesh, const CurvedEdges& edges, Index from, Index to) {
  const Vec3 d = 4 * edges.middle(from, to) - 3 * at(mesh, from) - at(mesh, to);
  return (1 / norm(d)) * d;
}

/// Whether two directions that leave an edge or a vertex turn by more than an angle.
bool turns(const Vec3& d, const Vec3& e, double angle) {
  return angle < kNoFeature && !(-dot(d, e) >= elementary::cos(angle * std::numbers::pi / 180));
}

using Triangle = std::array<Index, 3>;

std::vector<QuadraticSheet::Triangle> quadratic_of(const std::vector<Triangle>& triangles,
                                                   const QuadraticTriangles& quadratic) {
  std::vector<QuadraticSheet::Triangle> result;
  for (const Triangle& t : triangles) result.push_back(quadratic.of(t));
  return result;
}

bool are_same(const QuadraticSheet::Triangle& a, const QuadraticSheet::Triangle& b) {
  const auto same = [](const Vec3& p, const Vec3& q) { return p.x == q.x && p.y == q.y && p.z == q.z; };
  return std::equal(a.corners.begin(), a.corners.end(), b.corners.begin(), same) &&
         std::equal(a.offsets.begin(), a.offsets.end(), b.offsets.begin(), same);
}

/// The triangles of either of two surfaces that the other does not have bit for bit.
struct ChangedTriangles {
  std::vector<Triangle> before, after;

  ChangedTriangles(const std::vector<SheetTriangle>& old_triangles, const QuadraticTriangles& old_quadratic,
                   const std::vector<SheetTriangle>& new_triangles, const QuadraticTriangles& new_quadratic,
                   const std::vector<Index>& vertex2original) {
    std::set<Triangle> kept;
    std::set<Triangle> old_set;
    for (const SheetTriangle& t : old_triangles) old_set.insert(ascending(t.vertices));
    for (const SheetTriangle& t : new_triangles) {
      const Triangle now = ascending(t.vertices);
      Triangle original = now;
      if (!vertex2original.empty()) {
        for (Index& v : original) v = span_of(vertex2original)[v];
        // Vertices that remain keep their order, and inserted ones are -1.
        original = ascending(original);
      }
      const bool is_kept = old_set.contains(original) && are_same(old_quadratic.of(original), new_quadratic.of(now));
      if (is_kept) {
        kept.insert(original);
      } else {
        after.push_back(now);
      }
    }
    std::set_difference(old_set.begin(), old_set.end(), kept.begin(), kept.end(), std::back_inserter(before));
  }
};

}  // namespace

void LiftedNodes::apply(TetMesh& mesh) const {
  for (std::size_t i = 0; i < vertices.size(); ++i) span_of(mesh.points)[vertices[i]] = points[i];
  merge_edges(mesh.curved_edges, middles);
  // Other edges may have nodes that differ from the midpoint by rounding, and keep their bits.
  std::erase_if(mesh.curved_edges, [&](const CurvedEdge& e) {
    return find_edge(middles, e.vertices) != nullptr && is_straight(mesh, e, kStraight);
  });
}

CurvedSlide::CurvedSlide(const TetMesh& mesh, double feature_angle) : mesh_(mesh), triangles_(find_sheets(mesh)) {
  for (const SheetTriangle& t : triangles_) {
    for (const Edge& e : edges_of(t.vertices)) edges_.push_back(e);
  }
  sort_unique(edges_);
  find_features(feature_angle);
  find_chains(feature_angle);
}

bool CurvedSlide::has_edge(const Edge& edge) const { return std::binary_search(edges_.begin(), edges_.end(), edge); }

Edge CurvedSlide::listed_edge(Index e) const {
  if (e >= std::ssize(mesh_.edges)) return span_of(added_)[e - std::ssize(mesh_.edges)];
  return ascending(span_of(mesh_.edges)[e][0], span_of(mesh_.edges)[e][1]);
}

Index CurvedSlide::find_feature(const Edge& edge) const { return position_in(features_, edge); }

void CurvedSlide::find_features(double feature_angle) {
  const CurvedEdges curved(mesh_);
  std::vector<Edge> lines = find_lines(mesh_);
  std::map<Edge, std::vector<Index>> edge2triangles;
  for (Index t = 0; t < std::ssize(triangles_); ++t) {
    for (const Edge& e : edges_of(span_of(triangles_)[t].vertices)) edge2triangles[e].push_back(t);
  }
  for (const auto& [edge, around] : edge2triangles) {
    if (around.size() != 2) continue;
    const Vec3 d = direction_at_middle(mesh_, curved, edge, span_of(triangles_)[around[0]].vertices);
    const Vec3 e = direction_at_middle(mesh_, curved, edge, span_of(triangles_)[around[1]].vertices);
    if (turns(d, e, feature_angle)) lines.push_back(edge);
  }
  std::sort(lines.begin(), lines.end());
  const SurfaceParts parts = find_surface_parts(mesh_.points, triangles_, lines, kNoFeature);
  features_ = parts.features;
  std::sort(features_.begin(), features_.end());
  std::set<Edge> listed;
  for (Index e = 0; e < std::ssize(mesh_.edges); ++e) listed.insert(listed_edge(e));
  std::set_difference(features_.begin(), features_.end(), listed.begin(), listed.end(), std::back_inserter(added_));
  const QuadraticTriangles quadratic(mesh_.points, mesh_.curved_edges);
  std::vector<std::vector<QuadraticSheet::Triangle>> sheets(to_size_t(parts.sheets));
  sheet2sides_.resize(sheets.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    span_of(sheets)[parts.triangle2sheet[t]].push_back(quadratic.of(triangles_[t].vertices));
    span_of(sheet2sides_)[parts.triangle2sheet[t]] = triangles_[t].sides;
  }
  for (auto& sheet : sheets) sheets_.emplace_back(std::move(sheet));
}

void CurvedSlide::find_chains(double feature_angle) {
  const CurvedEdges curved(mesh_);
  std::map<Index, std::vector<Index>> vertex2features;
  for (Index f = 0; f < std::ssize(features_); ++f) {
    for (const Index v : span_of(features_)[f]) vertex2features[v].push_back(f);
  }
  const auto other_end = [this](Index f, Index v) { return span_of(features_)[f][0] ^ span_of(features_)[f][1] ^ v; };
  std::set<Index> ends;  // of chains
  for (const auto& [v, features] : vertex2features) {
    if (features.size() == 2) {
      const Vec3 d = tangent(mesh_, curved, v, other_end(features[0], v));
      const Vec3 e = tangent(mesh_, curved, v, other_end(features[1], v));
      if (!turns(d, e, feature_angle)) continue;
      corners_.push_back(v);
    }
    ends.insert(v);
  }
  feature2chain_.assign(features_.size(), -1);
  const QuadraticTriangles quadratic(mesh_.points, mesh_.curved_edges);
  for (Index first = 0; first < std::ssize(features_); ++first) {
    if (span_of(feature2chain_)[first] >= 0) continue;
    const Index chain = to_index(chains_.size());
    std::vector<Index> members{first};
    span_of(feature2chain_)[first] = chain;
    std::vector<QuadraticSheet::Triangle> segments;
    for (std::size_t i = 0; i < members.size(); ++i) {
      segments.push_back(quadratic.of(span_of(features_)[members[i]]));
      for (const Index v : span_of(features_)[members[i]]) {
        if (ends.contains(v)) continue;
        for (const Index next : vertex2features.at(v)) {
          if (std::exchange(span_of(feature2chain_)[next], chain) < 0) members.push_back(next);
        }
      }
    }
    chains_.emplace_back(std::move(segments));
  }
}

void CurvedSlide::constrain(TetMesh& skeleton) const {
  std::vector<Index> new2old = identity_map(skeleton.edges.size());
  for (Index e = 0; e < std::ssize(mesh_.edges); ++e) {
    if (find_feature(listed_edge(e)) >= 0) skeleton.ridges.push_back(e);
  }
  for (const Edge& edge : added_) {
    skeleton.ridges.push_back(to_index(skeleton.edges.size()));
    skeleton.edges.push_back(edge);
    skeleton.edge_tags.push_back(0);
    new2old.push_back(-1);
  }
  skeleton.edge_data = take_entries(skeleton.edge_data, new2old);
  skeleton.required_vertices.insert(skeleton.required_vertices.end(), corners_.begin(), corners_.end());
  for (const PeriodicLink& link : skeleton.periodic) {
    for (const auto& pair : link.pairs) {
      skeleton.required_vertices.insert(skeleton.required_vertices.end(), pair.begin(), pair.end());
    }
  }
  for (auto* list : {&skeleton.ridges, &skeleton.required_vertices}) {
    sort_unique(*list);
  }
}

/// The sheets between the same regions and of the same patch; all if there is none.
std::vector<const QuadraticSheet*> CurvedSlide::sheets_with(const std::array<int, 3>& sides) const {
  std::vector<const QuadraticSheet*> same, all;
  for (std::size_t i = 0; i < sheets_.size(); ++i) {
    all.push_back(&sheets_[i]);
    if (sheet2sides_[i] == sides) same.push_back(&sheets_[i]);
  }
  return same.empty() ? all : same;
}

/// The sheet that is nearest to a component of the slid surface, by the sum of squared distances.
const QuadraticSheet* CurvedSlide::sheet_of(const TetMesh& slid, const std::vector<SheetTriangle>& component,
                                            ChunkedQueries& queries) const {
  const std::vector<const QuadraticSheet*> candidates = sheets_with(component[0].sides);
  if (candidates.size() == 1) return candidates[0];
  std::vector<Vec3> points;
  for (const SheetTriangle& t : component) {
    Vec3 sum{0, 0, 0};
    for (const Index v : t.vertices) {
      points.push_back(at(slid, v));
      sum = sum + at(slid, v);
    }
    points.push_back((1.0 / 3) * sum);
  }
  const QuadraticSheet* nearest = candidates[0];  // where squared distances overflow
  double least = kInfinity;
  std::vector<double> distances(points.size());
  for (const QuadraticSheet* sheet : candidates) {
    double sum = 0;
    for (const Vec3& p : points) sum += sheet->distance2_of_box(p);
    if (sum > least) continue;
    sum = 0;
    // Most of the others are found to be farther after a few points.
    const Size n = std::ssize(points);
    for (Size begin = 0, end = 64; begin < n && sum < least && !queries.is_stopped(); begin = end, end *= 2) {
      end = std::min({n, end, begin + ChunkedQueries::kChunk});
      queries.chunk(begin, end, [&](Size i) { span_of(distances)[i] = sheet->distance2(span_of(points)[i]); });
      for (Size i = begin; i < end; ++i) sum += span_of(distances)[i];
    }
    if (sum >= least) continue;
    least = sum;
    nearest = sheet;
  }
  return nearest;
}

CurvedSlide::SlidSurface CurvedSlide::find_slid_surface(const TetMesh& slid, const Report& report) const {
  SlidSurface surface;
  std::vector<Edge> lines;
  for (Index e = 0; e < std::ssize(slid.edges); ++e) {
    const Index feature = find_feature(listed_edge(original_of(report.edge2original, e)));
    if (feature < 0) continue;
    const Edge edge = ascending(span_of(slid.edges)[e][0], span_of(slid.edges)[e][1]);
    const Index chain = span_of(feature2chain_)[feature];
    lines.push_back(edge);
    surface.edge2part[edge] = chain;
    for (const Index v : edge) surface.vertex2part[v] = chain;
  }
  std::sort(lines.begin(), lines.end());
  const std::vector<SheetTriangle> triangles = find_sheets(slid);
  const SurfaceParts parts = find_surface_parts(slid.points, triangles, lines, kNoFeature);
  surface.components.resize(to_size_t(parts.sheets));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Index component = parts.triangle2sheet[t];
    span_of(surface.components)[component].push_back(triangles[t]);
    const Index part = to_index(chains_.size()) + component;
    for (const Edge& e : edges_of(triangles[t].vertices)) surface.edge2part.try_emplace(e, part);
    for (const Index v : triangles[t].vertices) surface.vertex2part.try_emplace(v, part);
  }
  return surface;
}

std::optional<LiftedNodes> CurvedSlide::lift(const TetMesh& slid, const Report& report, int threads,
                                             const std::function<bool()>& stop) const {
  const auto original = [&report](Index v) { return original_of(report.vertex2original, v); };
  const auto stays = [&](Index v) {
    return original(v) >= 0 && span_of(mesh_.points)[original(v)] == span_of(slid.points)[v];
  };
  const SlidSurface surface = find_slid_surface(slid, report);
  LiftedNodes lifted;
  struct Node {
    Vec3 straight;
    Index part;
  };
  std::vector<Node> nodes;
  for (const auto& [v, part] : surface.vertex2part) {
    if (stays(v)) continue;
    lifted.vertices.push_back(v);
    nodes.push_back({at(slid, v), part});
  }
  for (const auto& [edge, part] : surface.edge2part) {
    const auto [a, b] = edge;
    if (stays(a) && stays(b) && has_edge(ascending(original(a), original(b)))) continue;
    lifted.middles.push_back({edge, {}});
    nodes.push_back({0.5 * (at(slid, a) + at(slid, b)), part});
  }
  ChunkedQueries queries(threads, stop);
  const std::size_t chains = chains_.size();
  std::vector<const QuadraticSheet*> part2sheet(chains + surface.components.size(), nullptr);
  for (std::size_t i = 0; i < chains; ++i) part2sheet[i] = &chains_[i];
  for (const Node& node : nodes) {
    const QuadraticSheet*& sheet = span_of(part2sheet)[node.part];
    if (sheet == nullptr) sheet = sheet_of(slid, surface.components[to_size_t(node.part) - chains], queries);
    if (queries.is_stopped()) return std::nullopt;
  }
  std::vector<Point3> points(nodes.size());
  queries.all(std::ssize(nodes), [&](Size i) {
    const Node& node = span_of(nodes)[i];
    span_of(points)[i] = to_point(span_of(part2sheet)[node.part]->lift(node.straight));
  });
  if (queries.is_stopped()) return std::nullopt;
  const std::size_t vertices = lifted.vertices.size();
  for (std::size_t i = 0; i < lifted.middles.size(); ++i) lifted.middles[i].middle = points[vertices + i];
  points.resize(vertices);
  lifted.points = std::move(points);
  return lifted;
}

SurfaceDeviation CurvedSlide::deviation(const TetMesh& result, const Report& report, const Options& options,
                                        const std::function<bool()>& stop) const {
  const double limit = options.max_deviation;
  const QuadraticTriangles old_quadratic(mesh_.points, mesh_.curved_edges);
  const QuadraticTriangles new_quadratic(result.points, result.curved_edges);
  const ChangedTriangles changed(triangles_, old_quadratic, find_sheets(result), new_quadratic, report.vertex2original);
  const auto old_triangles = quadratic_of(changed.before, old_quadratic);
  const auto new_triangles = quadratic_of(changed.after, new_quadratic);
  SurfaceDeviation deviation;
  const auto add = [&](const std::vector<Triangle>& triangles, const std::vector<double>& bounds,
                       const auto& original) {
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      deviation.bound = std::max(deviation.bound, bounds[i]);
      if (!(bounds[i] > limit)) continue;
      for (const Index v : triangles[i]) {
        if (original(v) >= 0) deviation.vertices.push_back(original(v));
      }
    }
  };
  // Triangles that have not changed are on both surfaces.
  add(changed.after, bound_distances(new_triangles, old_triangles, limit, options.threads, stop),
      [&report](Index v) { return original_of(report.vertex2original, v); });
  add(changed.before, bound_distances(old_triangles, new_triangles, limit, options.threads, stop),
      [](Index v) { return v; });
  return deviation;
}

}  // namespace tetune

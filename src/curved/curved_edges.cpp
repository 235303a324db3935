// SPDX-License-Identifier: Apache-2.0
#include "curved/curved_edges.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "backend/cpu.hpp"
#include "mesh/messages.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/validate_arrays.hpp"

namespace tetune {
namespace {

bool has_smaller_jacobian(const CurvedTet& a, const CurvedTet& b) {
  return a.scaled_jacobian() < b.scaled_jacobian() || (a.scaled_jacobian() == b.scaled_jacobian() && a.tet < b.tet);
}

}  // namespace

const char* to_string(CurvedValidity validity) { return name_of(validity, {"valid", "inverted", "undecided"}); }

const CurvedEdge* find_edge(const std::vector<CurvedEdge>& sorted, const std::array<Index, 2>& edge) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), CurvedEdge{edge, {}}, is_before);
  return at != sorted.end() && at->vertices == edge ? &*at : nullptr;
}

void merge_edges(std::vector<CurvedEdge>& sorted, std::vector<CurvedEdge> changed) {
  std::sort(changed.begin(), changed.end(), is_before);
  std::vector<CurvedEdge> merged;
  std::set_union(changed.begin(), changed.end(), sorted.begin(), sorted.end(), std::back_inserter(merged), is_before);
  sorted = std::move(merged);
}

bool is_straight(const TetMesh& mesh, const CurvedEdge& edge, double tolerance) {
  const Vec3 p = vec(span_of(mesh.points)[edge.vertices[0]]);
  const Vec3 q = vec(span_of(mesh.points)[edge.vertices[1]]);
  constexpr double kCoordinateRounding = 2e-14;
  double largest = 0;
  for (const double x : edge.middle) largest = std::max(largest, std::fabs(x));
  return norm(vec(edge.middle) - 0.5 * (p + q)) <= tolerance * norm(q - p) + kCoordinateRounding * largest;
}

CurvedEdges::CurvedEdges(const TetMesh& mesh) : mesh_(mesh), first_(mesh.points.size() + 1, 0) {
  for (const CurvedEdge& edge : mesh.curved_edges) ++span_of(first_)[edge.vertices[0] + 1];
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
}

const CurvedEdge* CurvedEdges::find(Index a, Index b) const {
  const auto edge = ascending(a, b);
  const auto begin = mesh_.curved_edges.begin() + span_of(first_)[edge[0]];
  const auto end = mesh_.curved_edges.begin() + span_of(first_)[edge[0] + 1];
  const auto at = std::lower_bound(begin, end, edge[1], [](const CurvedEdge& e, Index v) { return e.vertices[1] < v; });
  return at != end && at->vertices[1] == edge[1] ? &*at : nullptr;
}

Vec3 CurvedEdges::middle(Index a, Index b) const {
  if (const CurvedEdge* edge = find(a, b)) return vec(edge->middle);
  return 0.5 * (vec(span_of(mesh_.points)[a]) + vec(span_of(mesh_.points)[b]));
}

bool CurvedEdges::has_curved(const std::array<Index, 4>& tet) const {
  return std::any_of(kCurvedTetEdges.begin(), kCurvedTetEdges.end(),
                     [&](const auto& e) { return find(tet[e[0]], tet[e[1]]) != nullptr; });
}

TenNodes CurvedEdges::nodes(const std::array<Index, 4>& tet) const {
  TenNodes nodes{};
  for (std::size_t k = 0; k < 4; ++k) nodes[k] = vec(span_of(mesh_.points)[tet[k]]);
  for (std::size_t e = 0; e < 6; ++e) nodes[4 + e] = middle(tet[kCurvedTetEdges[e][0]], tet[kCurvedTetEdges[e][1]]);
  return nodes;
}

std::vector<Index> curved_tets(const TetMesh& mesh, const CurvedEdges& edges) {
  std::vector<Index> tets;
  if (mesh.curved_edges.empty()) return tets;
  for (Index t = 0; t < std::ssize(mesh.tets); ++t) {
    if (edges.has_curved(span_of(mesh.tets)[t])) tets.push_back(t);
  }
  return tets;
}

std::vector<CurvedTet> measure_tets(const TetMesh& mesh, const CurvedEdges& edges, const std::vector<Index>& tets,
                                    int threads) {
  constexpr Size kChunk = 64;
  std::vector<CurvedTet> result(tets.size());
  const Size n = std::ssize(tets);
  backend::Cpu(threads).for_parts((n + kChunk - 1) / kChunk, [&](Size chunk) {
    for (Size i = chunk * kChunk; i < std::min(n, (chunk + 1) * kChunk); ++i) {
      const Index t = span_of(tets)[i];
      CurvedTet& tet = span_of(result)[i];
      tet = measure_nodes(edges.nodes(span_of(mesh.tets)[t]));
      tet.tet = t;
      tet.centroid = TetMeshView(mesh).centroid(t);
    }
  });
  return result;
}

std::vector<CurvedTet> measure_curved_tets(const TetMesh& mesh, int threads) {
  const CurvedEdges edges(mesh);
  return measure_tets(mesh, edges, curved_tets(mesh, edges), threads);
}

std::vector<Index> find_invalid(const TetMesh& mesh, int threads) {
  return not_valid(measure_curved_tets(mesh, threads));
}

std::vector<Index> not_valid(const std::vector<CurvedTet>& tets) {
  return not_valid_or_below(tets, -std::numeric_limits<double>::infinity());
}

std::vector<Index> not_valid_or_below(const std::vector<CurvedTet>& tets, double limit) {
  std::vector<Index> ids;
  for (const CurvedTet& t : tets) {
    if (t.validity != CurvedValidity::valid || t.scaled_jacobian() < limit) ids.push_back(t.tet);
  }
  return ids;
}

CurvedQuality summarize_curved(const TetMesh& mesh, int threads, int worst) {
  CurvedQuality q;
  q.curved_edges = std::ssize(mesh.curved_edges);
  if (q.curved_edges == 0) return q;
  std::vector<CurvedTet> tets = measure_curved_tets(mesh, threads);
  q.tets = std::ssize(tets);
  for (const CurvedTet& t : tets) {
    q.valid += t.validity == CurvedValidity::valid ? 1 : 0;
    q.inverted += t.validity == CurvedValidity::inverted ? 1 : 0;
    q.undecided += t.validity == CurvedValidity::undecided ? 1 : 0;
    q.bad_integration += t.integration_ratio > 0 ? 0 : 1;
    q.min_scaled_jacobian = std::min(q.min_scaled_jacobian, t.scaled_jacobian());
    q.max_corner_ratio = std::max(q.max_corner_ratio, t.corner_ratio);
    q.max_middle_offset = std::max(q.max_middle_offset, t.middle_offset);
  }
  std::sort(tets.begin(), tets.end(), has_smaller_jacobian);
  tets.resize(std::min(tets.size(), to_size_t(std::max(0, worst))));
  q.worst = std::move(tets);
  return q;
}

std::vector<CurvedTet> measure_curved_each(const TetMesh& mesh, int threads) {
  require_arrays(mesh);
  return measure_curved_tets(mesh, threads);
}

CurvedQuality measure_curved(const TetMesh& mesh, int threads, int worst) {
  require_arrays(mesh);
  return summarize_curved(mesh, threads, worst);
}

}  // namespace tetune

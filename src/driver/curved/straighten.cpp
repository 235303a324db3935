// SPDX-License-Identifier: Apache-2.0
#include "driver/curved/straighten.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "backend/span.hpp"
#include "boundary/constraints.hpp"
#include "curved/curved_edges.hpp"
#include "driver/curved/curved_skeleton.hpp"
#include "mesh/element_kinds.hpp"
#include "mesh/sorted.hpp"

namespace tetune {
namespace {

using Edge = SurfaceCurvature::Edge;

/// The number of bisections that find the part of the curvature to keep, to within 1/64.
constexpr int kBisections = 6;
/// The number of rounds that bisect; in later ones elements become straight.
constexpr int kBisectedRounds = 3;
constexpr int kMaxStraighteningRounds = 40;

Point3 midpoint(const TetMesh& mesh, const Edge& edge) {
  return tetune::midpoint(span_of(mesh.points)[edge[0]], span_of(mesh.points)[edge[1]]);
}

template <class F>
void for_each_edge(const std::array<Index, 4>& tet, const F& f) {
  for (const auto& [i, j] : kCurvedTetEdges) f(ascending(tet[i], tet[j]));
}

std::set<Edge> edges_of(const TetMesh& mesh, const std::vector<Index>& tets) {
  std::set<Edge> edges;
  for (const Index t : tets) for_each_edge(span_of(mesh.tets)[t], [&edges](const Edge& e) { edges.insert(e); });
  return edges;
}

/// The held curved edges, except those of frozen regions and patches, of required elements and of other kinds.
std::vector<CurvedEdge> reducible_edges(const TetMesh& mesh, const HeldNodes& held, const Options& options) {
  std::set<Edge> frozen = edges_of(mesh, find_constraints(mesh, options).locked_tets);
  const auto freeze = [&frozen, &mesh](Index triangle) {
    const auto& t = span_of(mesh.triangles)[triangle];
    for (std::size_t k = 0; k < 3; ++k) frozen.insert(ascending(t[k], t[(k + 1) % 3]));
  };
  for (const Index t : mesh.required_triangles) freeze(t);
  for (Index t = 0; t < std::ssize(mesh.triangles); ++t) {
    const auto& tags = options.frozen_patches;
    if (std::find(tags.begin(), tags.end(), span_of(mesh.triangle_tags)[t]) != tags.end()) freeze(t);
  }
  for (const Index e : mesh.required_edges) {
    frozen.insert(ascending(span_of(mesh.edges)[e][0], span_of(mesh.edges)[e][1]));
  }
  for_each_other_middle(mesh, [&frozen](Index a, Index b) { frozen.insert(ascending(a, b)); });
  std::vector<CurvedEdge> edges;
  for (const CurvedEdge& e : mesh.curved_edges) {
    if (held.has_edge(e.vertices[0], e.vertices[1]) && !frozen.contains(e.vertices)) edges.push_back(e);
  }
  return edges;
}

class Straightener {
 public:
  Straightener(TetMesh& mesh, const HeldNodes& held, const Options& options, const RelaxationGoal& goal)
      : mesh_(mesh), held_(held), goal_(goal), surface_(reducible_edges(mesh, held, options)) {}

  std::vector<StraightenedEdge> run() {
    for (int round = 0; round < kMaxStraighteningRounds; ++round) {
      const std::vector<Index> bad = find_invalid(mesh_, goal_.threads);
      const std::set<Edge> edges = edges_of(mesh_, bad);
      if (std::none_of(edges.begin(), edges.end(), [this](const Edge& e) { return surface_.has(e); })) break;
      if (round < kBisectedRounds) {
        bisect(bad);
      } else {
        surface_.reduce(mesh_, held_, bad, 0);
      }
    }
    restore_where_valid();
    return surface_.reduced(mesh_);
  }

 private:
  /// Edges of the surface of tetrahedra that are connected by such edges. They keep the same part of their curvature.
  struct Group {
    std::vector<Index> tets;
    double valid = 0, invalid = 1;  ///< parts of the curvature
  };

  /// Groups tetrahedra, and lists the group of each of their edges on the surface.
  std::vector<Group> find_groups(const std::vector<Index>& tets, std::map<Edge, std::size_t>& edge2group) const {
    std::vector<std::size_t> parents(tets.size());
    std::iota(parents.begin(), parents.end(), 0);
    const auto root = [&parents](std::size_t i) {
      while (parents[i] != i) i = parents[i];
      return i;
    };
    for (std::size_t i = 0; i < tets.size(); ++i) {
      for_each_edge(span_of(mesh_.tets)[tets[i]], [&](const Edge& e) {
        if (!surface_.has(e)) return;
        const auto [at, is_new] = edge2group.try_emplace(e, i);
        const auto [low, high] = std::minmax({root(i), root(at->second)});
        parents[high] = low;
      });
    }
    std::vector<Group> groups(tets.size());
    for (std::size_t i = 0; i < tets.size(); ++i) groups[root(i)].tets.push_back(tets[i]);
    for (auto& [edge, group] : edge2group) group = root(group);
    return groups;
  }

  /// Finds for each group of bad tetrahedra the largest part of the curvature with which they can be made valid.
  void bisect(const std::vector<Index>& bad) {
    std::map<Edge, std::size_t> edge2group;
    std::vector<Group> groups = find_groups(bad, edge2group);
    for (int step = 0; step < kBisections; ++step) {
      TetMesh trial = mesh_;
      SurfaceCurvature curvature = surface_;
      for (const Group& g : groups) curvature.reduce(trial, held_, g.tets, (g.valid + g.invalid) / 2);
      std::set<std::size_t> failed;
      const auto fail = [&](const std::vector<Index>& tets) {
        for (const Edge& e : edges_of(trial, tets)) {
          if (const auto at = edge2group.find(e); at != edge2group.end()) failed.insert(at->second);
        }
      };
      // Relaxation of an element with a folded face takes long and fails.
      std::vector<Index> invalid = find_invalid(trial, goal_.threads);
      const std::vector<Index> folded = with_folded_face(trial, invalid);
      fail(folded);
      erase_listed(invalid, folded);
      relax_curved(trial, held_, invalid, goal_);
      fail(find_invalid(trial, goal_.threads));
      for (std::size_t i = 0; i < groups.size(); ++i) {
        Group& g = groups[i];
        (failed.contains(i) ? g.invalid : g.valid) = (g.valid + g.invalid) / 2;
      }
    }
    for (const Group& g : groups) {
      if (!g.tets.empty()) surface_.reduce(mesh_, held_, g.tets, g.valid);
    }
    relax_curved(mesh_, held_, find_invalid(mesh_, goal_.threads), goal_);
  }

  /// Gives each edge as much of its curvature back as leaves the elements around it valid without relaxation: those of
  /// a group do not all need the same part. Straight edges, which the mesh does not list, are listed meanwhile.
  void restore_where_valid() {
    std::map<Edge, std::vector<Index>> edge2tets;
    std::vector<CurvedEdge> straight;
    for (const StraightenedEdge& e : surface_.reduced(mesh_)) {
      edge2tets[e.vertices];
      if (e.kept == 0) straight.push_back({e.vertices, midpoint(mesh_, e.vertices)});
    }
    merge_edges(mesh_.curved_edges, std::move(straight));
    for (Index t = 0; t < std::ssize(mesh_.tets) && !edge2tets.empty(); ++t) {
      for_each_edge(span_of(mesh_.tets)[t], [&](const Edge& e) {
        if (const auto at = edge2tets.find(e); at != edge2tets.end()) at->second.push_back(t);
      });
    }
    const CurvedEdges edges(mesh_);
    for (CurvedEdge& edge : mesh_.curved_edges) {
      const auto tets = edge2tets.find(edge.vertices);
      if (tets == edge2tets.end()) continue;
      double valid = surface_.kept(edge.vertices);
      double part = 1;
      for (double step = 1 - valid; step > 1.0 / (1 << kBisections); step /= 2) {
        surface_.set(mesh_, edge, part);
        const bool is_valid = not_valid(measure_tets(mesh_, edges, tets->second, goal_.threads)).empty();
        if (is_valid) valid = part;
        if (is_valid && part == 1) break;
        part += is_valid ? step / 2 : -step / 2;
      }
      surface_.set(mesh_, edge, valid);
    }
    std::erase_if(mesh_.curved_edges, [this](const CurvedEdge& e) { return surface_.is_straight(e.vertices); });
  }

  TetMesh& mesh_;
  const HeldNodes& held_;
  const RelaxationGoal& goal_;
  SurfaceCurvature surface_;
};

}  // namespace

SurfaceCurvature::SurfaceCurvature(const std::vector<CurvedEdge>& edges) {
  for (const CurvedEdge& e : edges) surface_[e.vertices] = {e.middle, 1};
}

void SurfaceCurvature::set(const TetMesh& mesh, CurvedEdge& edge, double kept) {
  State& state = surface_.at(edge.vertices);
  state.kept = kept;
  if (kept == 1) {
    edge.middle = state.middle;
    return;
  }
  const Point3 chord = midpoint(mesh, edge.vertices);
  for (std::size_t c = 0; c < 3; ++c) edge.middle[c] = chord[c] + kept * (state.middle[c] - chord[c]);
}

void SurfaceCurvature::reduce(TetMesh& mesh, const HeldNodes& held, const std::vector<Index>& tets, double kept) {
  const std::set<Edge> edges = edges_of(mesh, tets);
  std::erase_if(mesh.curved_edges, [&](CurvedEdge& e) {
    if (!edges.contains(e.vertices)) return false;
    if (!has(e.vertices)) return kept == 0 && !held.has_edge(e.vertices[0], e.vertices[1]);
    set(mesh, e, kept * surface_.at(e.vertices).kept);
    return kept == 0;
  });
}

std::vector<StraightenedEdge> SurfaceCurvature::reduced(const TetMesh& mesh) const {
  std::vector<StraightenedEdge> edges;
  for (const auto& [edge, state] : surface_) {
    if (state.kept == 1) continue;
    const double offset = norm(vec(state.middle) - vec(midpoint(mesh, edge)));
    edges.push_back({edge, state.kept, (1 - state.kept) * offset});
  }
  return edges;
}

std::vector<StraightenedEdge> straighten(TetMesh& mesh, const HeldNodes& held, const Options& options,
                                         const RelaxationGoal& goal) {
  return Straightener(mesh, held, options, goal).run();
}

}  // namespace tetune

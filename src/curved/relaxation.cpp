// SPDX-License-Identifier: Apache-2.0
#include "curved/relaxation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <span>
#include <utility>

#include "backend/cpu.hpp"
#include "curved/curved_edges.hpp"
#include "curved/minimize.hpp"
#include "curved/relaxation_energy.hpp"
#include "energy/quality_floor.hpp"
#include "math/angle.hpp"
#include "math/elementary.hpp"
#include "mesh/sorted.hpp"
#include "mesh/vertex_tets.hpp"

namespace tetune {
namespace {

constexpr int kRings = 2;  ///< of tetrahedra around the listed ones, which a patch includes

using TetList = std::vector<Index>;

/// The tetrahedra within kRings around the listed ones, as connected groups in ascending order.
std::vector<TetList> find_patches(const TetMesh& mesh, const VertexTets& vertex2tets, const TetList& tets) {
  std::vector<std::uint8_t> in_patch(mesh.tets.size(), 0);
  TetList all = tets;
  for (const Index t : all) span_of(in_patch)[t] = 1;
  const auto add_neighbors = [&](Index t, TetList& to, std::uint8_t from, std::uint8_t mark) {
    for (const Index v : span_of(mesh.tets)[t]) {
      for (const Index n : vertex2tets.of(v)) {
        if (span_of(in_patch)[n] != from) continue;
        span_of(in_patch)[n] = mark;
        to.push_back(n);
      }
    }
  };
  std::size_t begin = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    const std::size_t end = all.size();
    for (std::size_t i = begin; i < end; ++i) add_neighbors(all[i], all, 0, 1);
    begin = end;
  }
  std::sort(all.begin(), all.end());
  std::vector<TetList> patches;
  for (const Index seed : all) {
    if (span_of(in_patch)[seed] != 1) continue;
    TetList patch{seed};
    span_of(in_patch)[seed] = 2;
    for (std::size_t i = 0; i < patch.size(); ++i) add_neighbors(patch[i], patch, 1, 2);
    std::sort(patch.begin(), patch.end());
    patches.push_back(std::move(patch));
  }
  return patches;
}

/// The quantities that a new state of a patch must improve.
struct PatchQuality {
  std::int64_t not_valid = 0;
  double min_scaled_jacobian = 1;
  bool improves(const PatchQuality& before) const {
    constexpr double kMinGain = 1e-3;
    if (not_valid != before.not_valid) return not_valid < before.not_valid;
    return not_valid == 0 && min_scaled_jacobian > before.min_scaled_jacobian + kMinGain;
  }
};

/// New positions of the nodes of a patch.
struct PatchResult {
  bool improved = false;
  TetList left;  ///< the tetrahedra to relax in another way
  std::vector<std::pair<Index, Point3>> vertices;
  std::vector<CurvedEdge> edges;
};

/// The ideal shapes of the elements of a patch.
enum class Ideal {
  straight,  ///< the straight element: for the scaled Jacobian
  regular,   ///< a regular tetrahedron: where elements are too flat to take them for ideal
};

/// A regular tetrahedron of the volume of a straight one, but no less than a quarter of that with the same edges.
std::array<Vec3, 4> regular_like(const std::array<Vec3, 4>& x) {
  double length2 = 0;
  for (const auto& [i, j] : kCurvedTetEdges) length2 += dot(x[j] - x[i], x[j] - x[i]) / 6;
  const double regular = length2 * std::sqrt(length2 / 2);  // six times the volume
  const double volume = dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]);
  // The corners of a cube with edges of this length.
  const double a = elementary::cbrt(std::max(volume, regular / 4) / 2);
  return {Vec3{0, 0, 0}, {a, a, 0}, {0, a, a}, {a, 0, a}};
}

/// The nodes that relaxation moves, of those that are not held.
enum class MovingNodes { all, mid_side };

/// One way to relax a patch.
struct Attempt {
  Ideal ideal;
  MovingNodes moving;
};
constexpr std::array<Attempt, 4> kAttempts{{{Ideal::straight, MovingNodes::all},
                                            {Ideal::straight, MovingNodes::mid_side},
                                            {Ideal::regular, MovingNodes::all},
                                            {Ideal::regular, MovingNodes::mid_side}}};

/// The elements around a group of bad ones.
class Patch {
 public:
  Patch(const TetMesh& mesh, const CurvedEdges& edges, const HeldNodes& held, const VertexTets& vertex2tets,
        const RelaxationGoal& goal, const TetList& tets)
      : mesh_(mesh), edges_(edges), held_(held), vertex2tets_(vertex2tets), goal_(goal), tets_(tets) {}

  /// Relaxes the patch in one way. `listed`: the tetrahedra that need it, ascending, in this patch and in others.
  PatchResult relax(const Attempt& attempt, const TetList& listed) {
    collect_nodes();
    best_quality_ = judge(nodes_);
    best_nodes_ = nodes_;
    PatchResult best;
    if (is_enough()) return best;
    const std::vector<std::size_t> unknowns = find_unknowns(attempt.moving);
    if (!unknowns.empty()) solve(unknowns, attempt.ideal, best);
    if (best_quality_.not_valid > 0) {
      best.left = not_valid();
    } else if (!best.improved) {
      std::set_intersection(tets_.begin(), tets_.end(), listed.begin(), listed.end(), std::back_inserter(best.left));
    }
    return best;
  }

 private:
  bool is_stopped() const { return goal_.stop && goal_.stop(); }
  bool is_enough() const { return goal_.only_valid && best_quality_.not_valid == 0; }
  bool contains(Index t) const { return std::binary_search(tets_.begin(), tets_.end(), t); }

  void collect_nodes() {
    std::map<Index, std::size_t> vertices;
    std::map<std::array<Index, 2>, std::size_t> middles;
    const auto node_of = [this](auto& map, const auto& key, const auto& place) {
      const auto [at, is_new] = map.try_emplace(key, nodes_.size());
      if (is_new) nodes_.push_back(place());
      return at->second;
    };
    for (const Index t : tets_) {
      const auto& tet = span_of(mesh_.tets)[t];
      PatchElement element;
      std::array<Vec3, 4> corners{};
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k] = vec(span_of(mesh_.points)[tet[k]]);
        element.nodes[k] = node_of(vertices, tet[k], [&] { return corners[k]; });
      }
      for (std::size_t e = 0; e < 6; ++e) {
        const auto edge = ascending(tet[kCurvedTetEdges[e][0]], tet[kCurvedTetEdges[e][1]]);
        element.nodes[4 + e] = node_of(middles, edge, [&] { return edges_.middle(edge[0], edge[1]); });
      }
      elements_.push_back(element);
    }
    node2vertex_.assign(nodes_.size(), -1);
    node2edge_.assign(nodes_.size(), {-1, -1});
    for (const auto& [v, node] : vertices) node2vertex_[node] = v;
    for (const auto& [edge, node] : middles) node2edge_[node] = edge;
  }

  /// Nodes that are not held and whose elements are all in the patch.
  std::vector<std::size_t> find_unknowns(MovingNodes moving) const {
    std::vector<std::size_t> unknowns;
    const auto has_all = [this](std::span<const Index> tets) {
      return std::all_of(tets.begin(), tets.end(), [this](Index t) { return contains(t); });
    };
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const Index v = node2vertex_[n];
      const auto& [a, b] = node2edge_[n];
      bool moves = false;
      if (v >= 0) {
        moves = moving == MovingNodes::all && span_of(held_.vertices)[v] == 0 && has_all(vertex2tets_.of(v));
      } else if (!held_.has_edge(a, b)) {
        TetList around;
        std::set_intersection(vertex2tets_.of(a).begin(), vertex2tets_.of(a).end(), vertex2tets_.of(b).begin(),
                              vertex2tets_.of(b).end(), std::back_inserter(around));
        moves = has_all(around);
      }
      if (moves) unknowns.push_back(n);
    }
    return unknowns;
  }

  TenNodes nodes_of(const PatchElement& element, const std::vector<Vec3>& nodes) const {
    TenNodes ten{};
    for (std::size_t k = 0; k < 10; ++k) ten[k] = nodes[element.nodes[k]];
    return ten;
  }

  /// The tetrahedra that are not valid with the best positions.
  TetList not_valid() const {
    TetList tets;
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      if (measure_nodes(nodes_of(elements_[i], best_nodes_)).validity != CurvedValidity::valid)
        tets.push_back(tets_[i]);
    }
    return tets;
  }

  PatchQuality judge(const std::vector<Vec3>& nodes) const {
    PatchQuality quality;
    for (const PatchElement& element : elements_) {
      const CurvedTet t = measure_nodes(nodes_of(element, nodes));
      quality.not_valid += t.validity == CurvedValidity::valid ? 0 : 1;
      quality.min_scaled_jacobian = std::min(quality.min_scaled_jacobian, t.scaled_jacobian());
    }
    return quality;
  }

  /// Whether the straight elements keep their smallest dihedral angle.
  bool keeps_angles(const std::vector<Vec3>& nodes) const {
    return std::all_of(elements_.begin(), elements_.end(), [&](const PatchElement& element) {
      std::array<Vec3, 4> before{};
      std::array<Vec3, 4> after{};
      bool moved = false;
      for (std::size_t k = 0; k < 4; ++k) {
        before[k] = nodes_[element.nodes[k]];
        after[k] = nodes[element.nodes[k]];
        moved = moved || norm(after[k] - before[k]) > 0;
      }
      if (!moved) return true;
      return min_dihedral(after) >= std::min(goal_.min_dihedral, min_dihedral(before));
    });
  }

  /// Minimizes the regularized energy with a falling epsilon until the determinants are positive, then the sharper
  /// energies, whose maximum over the elements counts for more. Keeps the best of all stages.
  void solve(const std::vector<std::size_t>& unknowns, Ideal ideal, PatchResult& best) {
    constexpr int kMaxStages = 20;
    constexpr int kMaxStuck = 4;
    constexpr int kIterations = 200;
    constexpr double kFirstStep = 0.02;
    // Epsilon is at least about a fifth of the most negative determinant.
    constexpr double kMinEpsilon2 = 1e-12;
    constexpr double kDeterminantPart2 = 0.04;
    constexpr double kMinRise = 1e-6;  // of the smallest determinant, relative
    RelaxationEnergy energy(elements_with(unknowns, nodes_, ideal), nodes_, unknowns);
    std::vector<double> x = energy.start();
    const auto stop = [this] { return is_stopped(); };
    const double step = kFirstStep * mean_edge();
    double least = energy.smallest_determinant(x);
    const auto evaluate = [&energy](const std::vector<double>& at, std::vector<double>& g) { return energy(at, g); };
    energy.epsilon = 1;
    int stuck = 0;
    for (int stage = 0; stage < kMaxStages && !(least > 0) && stuck < kMaxStuck; ++stage) {
      if (is_stopped()) return;
      energy.epsilon = std::min(energy.epsilon / 2, std::sqrt(kMinEpsilon2 + kDeterminantPart2 * least * least));
      minimize_lbfgs(x, step, kIterations, evaluate, stop);
      const double last = std::exchange(least, energy.smallest_determinant(x));
      // Determinants that held nodes alone make negative stay so.
      stuck = least > last + kMinRise * std::fabs(last) ? 0 : stuck + 1;
      take_if_better(energy.nodes_at(x), unknowns, best);
    }
    if (!(least > 0) || is_enough()) return;
    energy.epsilon = 0;
    minimize_lbfgs(x, step, kIterations, evaluate, stop);
    const std::vector<Vec3> nodes = energy.nodes_at(x);
    take_if_better(nodes, unknowns, best);
    if (is_enough()) return;
    RelaxationEnergy sharp(elements_with(unknowns, nodes, Ideal::straight), nodes, unknowns);
    if (!(sharp.smallest_determinant(x) > 0)) return;
    for (const int power : {1, 4, 16}) {
      if (is_stopped()) return;
      sharp.power = power;
      const auto evaluate_sharp = [&sharp](const std::vector<double>& at, std::vector<double>& g) {
        return sharp(at, g);
      };
      minimize_lbfgs(x, step, kIterations, evaluate_sharp, stop);
      take_if_better(sharp.nodes_at(x), unknowns, best);
      if (is_enough()) return;
    }
  }

  /// The elements with an unknown node, with ideal shapes for nodes at these positions.
  std::vector<PatchElement> elements_with(const std::vector<std::size_t>& unknowns, const std::vector<Vec3>& nodes,
                                          Ideal ideal) const {
    std::vector<PatchElement> moving;
    for (const PatchElement& element : elements_) {
      const bool has = std::any_of(element.nodes.begin(), element.nodes.end(), [&](std::size_t n) {
        return std::binary_search(unknowns.begin(), unknowns.end(), n);
      });
      if (!has) continue;
      std::array<Vec3, 4> corners{};
      for (std::size_t k = 0; k < 4; ++k) corners[k] = nodes[element.nodes[k]];
      moving.push_back(element);
      moving.back().inverse_ideal = inverse_of_edges(ideal == Ideal::straight ? corners : regular_like(corners));
    }
    return moving;
  }

  double mean_edge() const {
    double sum = 0;
    for (const PatchElement& element : elements_) {
      for (const auto& [i, j] : kCurvedTetEdges) sum += norm(nodes_[element.nodes[i]] - nodes_[element.nodes[j]]);
    }
    return sum / (6 * double(elements_.size()));
  }

  void take_if_better(const std::vector<Vec3>& nodes, const std::vector<std::size_t>& unknowns, PatchResult& best) {
    const PatchQuality quality = judge(nodes);
    if (!quality.improves(best_quality_) || !keeps_angles(nodes)) return;
    best_quality_ = quality;
    best_nodes_ = nodes;
    best = {true, {}, {}, {}};
    for (const std::size_t n : unknowns) {
      const Point3 p = to_point(nodes[n]);
      if (node2vertex_[n] >= 0) {
        best.vertices.emplace_back(node2vertex_[n], p);
      } else {
        best.edges.push_back({node2edge_[n], p});
      }
    }
  }

  const TetMesh& mesh_;
  const CurvedEdges& edges_;
  const HeldNodes& held_;
  const VertexTets& vertex2tets_;
  const RelaxationGoal& goal_;
  const TetList& tets_;
  std::vector<Vec3> nodes_;
  std::vector<Index> node2vertex_;  ///< -1 for a mid-side node
  std::vector<std::array<Index, 2>> node2edge_;
  std::vector<PatchElement> elements_;
  PatchQuality best_quality_;
  std::vector<Vec3> best_nodes_;
};

}  // namespace

double min_dihedral(const std::array<Vec3, 4>& x) {
  const double w = dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]);
  return w > 0 ? upper_atan2(1.0, QualityFloor::dihedral_cots(x.data(), w).max) * kDegreesPerRadian : -1;
}

bool HeldNodes::has_edge(Index a, Index b) const {
  return std::binary_search(edges.begin(), edges.end(), ascending(a, b));
}

void relax_curved(TetMesh& mesh, const HeldNodes& held, const std::vector<Index>& tets, const RelaxationGoal& goal) {
  const backend::Cpu cpu(goal.threads);
  const VertexTets vertex2tets(cpu, mesh);
  TetList left = tets;
  for (const Attempt& attempt : kAttempts) {
    if (left.empty()) break;
    sort_unique(left);
    if (attempt.moving == MovingNodes::all && !goal.moves_vertices) continue;
    const CurvedEdges edges(mesh);
    const std::vector<TetList> patches = find_patches(mesh, vertex2tets, left);
    std::vector<PatchResult> results(patches.size());
    // Patches have no element in common, so that no node moves in two of them.
    cpu.for_parts(std::ssize(patches), [&](Size i) {
      span_of(results)[i] = Patch(mesh, edges, held, vertex2tets, goal, span_of(patches)[i]).relax(attempt, left);
    });
    left.clear();
    std::vector<CurvedEdge> changed;
    for (const PatchResult& result : results) {
      for (const auto& [v, p] : result.vertices) span_of(mesh.points)[v] = p;
      changed.insert(changed.end(), result.edges.begin(), result.edges.end());
      left.insert(left.end(), result.left.begin(), result.left.end());
    }
    merge_edges(mesh.curved_edges, std::move(changed));
  }
}

}  // namespace tetune

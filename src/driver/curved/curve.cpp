// SPDX-License-Identifier: Apache-2.0
#include "tetune/curve.hpp"

#include <functional>
#include <optional>
#include <utility>

#include "curved/curved_edges.hpp"
#include "curved/finer_surface.hpp"
#include "curved/surface_middles.hpp"
#include "driver/curved/curved_sheets.hpp"
#include "driver/curved/curved_skeleton.hpp"
#include "driver/curved/straighten.hpp"
#include "driver/geometry/geometry_middles.hpp"
#include "mesh/element_kinds.hpp"
#include "mesh/validate_arrays.hpp"
#include "phases/progress/latched_hooks.hpp"
#include "system/real_text.hpp"
#include "tetune/error.hpp"
#include "tetune/options.hpp"
#include "tetune/quality.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

/// Elements below this scaled Jacobian are relaxed.
constexpr double kRelaxCurvedBelow = 0.1;
/// The part of the curvature that a round of straightening leaves; rounds after kPartialRounds leave none.
constexpr double kKept = 0.75;
constexpr int kPartialRounds = 12;
/// Elements are relaxed in every kRelaxEvery-th round only, as a relaxation that fails takes long.
constexpr int kRelaxEvery = 6;

/// The surface of a finer mesh, with its own mid-side nodes or those that are reconstructed.
FinerSurface find_finer(const TetMesh& mesh, double feature_angle) {
  if (const ValidationReport report = validate_arrays(mesh); !report.ok()) {
    throw MeshError("the finer surface: " + report.message(false));
  }
  std::vector<SheetTriangle> sheets = find_sheets(mesh);
  if (mesh.tets.empty()) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      sheets.push_back({mesh.triangles[i], {mesh.triangle_tags[i], -1, 0}});
    }
  }
  if (sheets.empty()) throw MeshError("the finer surface: the mesh has neither tetrahedra nor triangles");
  const auto lines = find_lines(mesh);
  const SurfaceParts parts = find_surface_parts(mesh.points, sheets, lines, feature_angle);
  if (!mesh.curved_edges.empty()) return {mesh.points, sheets, parts, mesh.curved_edges};
  return {mesh.points, sheets, parts, find_surface_middles(mesh.points, sheets, lines, feature_angle)};
}

/// One call of curve().
class CurveRun {
 public:
  /// `stop` is called by all threads.
  CurveRun(TetMesh& mesh, const CurveOptions& options, std::function<bool()> stop) : mesh_(mesh), options_(options) {
    Options fixed;
    fixed.boundary = Boundary::fixed;
    held_ = find_held(mesh, fixed);
    goal_.min_dihedral = quality(mesh, options.threads).dihedral_min;
    goal_.threads = options.threads;
    goal_.stop = std::move(stop);
    find_middles();
    mesh.second_order = true;
  }

  CurveReport run() {
    CurveReport report;
    report.edges_off_geometry = off_geometry_;
    SurfaceCurvature surface(mesh_.curved_edges);
    const std::vector<Point3> before = mesh_.points;
    for (int round = 0;; ++round) {
      std::vector<CurvedTet> tets = measure();
      if (round == 0) report.not_valid_before = std::ssize(not_valid(tets));
      if (round % kRelaxEvery == 0 && round <= kPartialRounds) {
        relax_curved(mesh_, held_, not_valid_or_below(tets, kRelaxCurvedBelow), goal_);
        tets = measure();
      }
      const std::vector<Index> bad = not_valid(tets);
      if (bad.empty()) break;
      surface.reduce(mesh_, held_, bad, round < kPartialRounds ? kKept : 0);
    }
    report.straightened = surface.reduced(mesh_);
    for (std::size_t v = 0; v < before.size(); ++v) report.vertices_moved += mesh_.points[v] != before[v] ? 1 : 0;
    const CurvedQuality q = summarize_curved(mesh_, options_.threads, 0);
    report.curved_edges = q.curved_edges;
    report.curved_tets = q.tets;
    report.min_scaled_jacobian = q.min_scaled_jacobian;
    return report;
  }

 private:
  void find_middles() {
    if (options_.geometry != nullptr) {
      GeometryMiddles middles = find_geometry_middles(mesh_, *options_.geometry);
      mesh_.curved_edges = std::move(middles.edges);
      off_geometry_ = middles.off_geometry;
      return;
    }
    const std::vector<SheetTriangle> sheets = find_sheets(mesh_);
    std::optional<FinerSurface> finer;
    if (options_.surface != nullptr) {
      finer = find_finer(*options_.surface, options_.feature_angle);
      check_is_near(*finer, mesh_.points, sheets);
    }
    mesh_.curved_edges = find_surface_middles(mesh_.points, sheets, find_lines(mesh_), options_.feature_angle,
                                              finer ? &*finer : nullptr);
  }

  std::vector<CurvedTet> measure() const { return measure_curved_tets(mesh_, options_.threads); }

  TetMesh& mesh_;
  const CurveOptions& options_;
  HeldNodes held_;
  std::int64_t off_geometry_ = 0;
  RelaxationGoal goal_;
};

}  // namespace

CurveReport curve(TetMesh& mesh, const CurveOptions& options) {
  if (!(options.feature_angle > 0 && options.feature_angle <= 180)) {
    throw OptionError("feature_angle is " + number_text(options.feature_angle) + "; it must be in (0, 180]");
  }
  if (options.threads < 0 || options.threads > 4096) {
    throw OptionError("threads is " + std::to_string(options.threads) + "; it must be from 0 to 4096");
  }
  if (options.surface != nullptr && options.geometry != nullptr) {
    throw OptionError("surface and geometry exclude each other: the mid-side nodes are on one of them");
  }
  if (const ValidationReport report = validate(mesh, options.threads); !report.ok()) {
    throw MeshError("only a valid mesh can be curved; optimize it first, with untangle where it is inverted: " +
                    report.message(false));
  }
  if (!mesh.curved_edges.empty()) {
    throw MeshError("the mesh has " + std::to_string(mesh.curved_edges.size()) +
                    " curved edges already; make it straight first (order 1)");
  }
  for (const ElementBlock& block : mesh.others) {
    if (block.kind == kPoints) continue;
    throw MeshError("the mesh has " + block.kind + ", which " +
                    (has_middles(mesh, block) ? "would not follow a curved surface"
                                              : "would stay linear beside second-order tetrahedra") +
                    "; take them out, or make second-order elements in the program that made the mesh");
  }
  TetMesh curved = mesh;
  if (curved.deck != nullptr) curved.deck_nodes.clear();
  curved.deck = nullptr;
  const Context caller{{}, options.stop};
  const LatchedHooks hooks(caller);
  const CurveReport report = CurveRun(curved, options, hooks.context().stop).run();
  mesh = std::move(curved);
  return report;
}

}  // namespace tetune

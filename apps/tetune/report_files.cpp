// SPDX-License-Identifier: Apache-2.0
#include "report_files.hpp"
#include "tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetune::cli {

using Json = nlohmann::ordered_json;

namespace {

/// Angles of sweeps are measured only with --trace-angles.
Json if_measured(double angle) { return angle > 0 ? Json(angle) : Json(); }

template <class Counts, std::size_t kSize>
void add_counts(Json& json, const std::array<CountInfo<Counts>, kSize>& kinds, const Counts& counts) {
  for (const auto& kind : kinds) json[kind.key] = counts.*kind.count;
}

Json sweeps_json(const Report& r) {
  Json sweeps = Json::array();
  for (const SweepReport& s : r.sweeps) {
    sweeps.push_back({{"iteration", s.iteration},
                      {"moved", s.moved},
                      {"energy_before", s.energy_before},
                      {"decrease", s.decrease},
                      {"gradient_norm2", s.gradient_norm2},
                      {"gradient_norm", s.gradient_norm2},  // the former name, until version 0.3
                      {"dihedral_min_deg", if_measured(s.dihedral_min)},
                      {"seconds", s.seconds}});
  }
  return sweeps;
}

Json flip_passes_json(const Report& r) {
  Json passes = Json::array();
  for (const FlipReport& f : r.flip_passes) {
    Json& pass = passes.emplace_back(
        Json{{"after_iteration", f.iteration}, {"pass", f.pass}, {"active", f.active}, {"evaluated", f.evaluated}});
    add_counts<FlipCounts>(pass, kFlipCounts, f);
    pass["decrease"] = f.decrease;
    pass["seconds"] = f.seconds;
  }
  return passes;
}

Json worst_rounds_json(const Report& r) {
  Json rounds = Json::array();
  for (const WorstReport& w : r.worst_rounds) {
    rounds.push_back({{"work", w.work},
                      {"round", w.round},
                      {"worst", w.worst},
                      {"inserted", w.inserted},
                      {"removed", w.removed},
                      {"flips", w.flips},
                      {"moved", w.moved},
                      {"dihedral_min_deg", if_measured(w.dihedral_min)},
                      {"seconds", w.seconds}});
  }
  return rounds;
}

}  // namespace

Json to_json(const CurvedQuality& q) {
  Json worst = Json::array();
  const auto if_finite = [](double x) { return std::isfinite(x) ? Json(x) : Json(); };
  for (const CurvedTet& t : q.worst) {
    worst.push_back({{"tetrahedron", t.tet + 1},
                     {"validity", to_string(t.validity)},
                     {"jacobian_min", {if_finite(t.min_lower), if_finite(t.min_upper)}},
                     {"jacobian_max", {if_finite(t.max_lower), if_finite(t.max_upper)}},
                     {"corner_ratio", if_finite(t.corner_ratio)},
                     {"integration_ratio", if_finite(t.integration_ratio)},
                     {"middle_offset", t.middle_offset},
                     {"centroid", t.centroid}});
  }
  return {{"curved_edges", q.curved_edges},
          {"tetrahedra", q.tets},
          {"valid", q.valid},
          {"inverted", q.inverted},
          {"undecided", q.undecided},
          {"bad_integration", q.bad_integration},
          {"min_scaled_jacobian", if_finite(q.min_scaled_jacobian)},
          {"max_corner_ratio", if_finite(q.max_corner_ratio)},
          {"max_middle_offset", q.max_middle_offset},
          {"worst", worst}};
}

Json to_json(const Quality& q) {
  Json measures = Json::object();
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const MeasureSummary& s = q.measures[k];
    measures[to_string(static_cast<Measure>(k))] = {
        {"min", s.min}, {"worst_1_percent", s.p1}, {"worst_5_percent", s.p5}, {"mean", s.mean}, {"max", s.max}};
  }
  Json worst = Json::array();
  for (const WorstTet& w : q.worst) {
    worst.push_back(
        {{"tetrahedron", w.tet + 1}, {"min_dihedral_deg", w.dihedral}, {"q_h", w.harmonic}, {"centroid", w.centroid}});
  }
  Json json = {{"tetrahedra", q.tets},
               {"dihedral_min_deg", q.dihedral_min},
               {"dihedral_1_percent_deg", q.dihedral_p1},
               {"dihedral_5_percent_deg", q.dihedral_p5},
               {"dihedral_mean_deg", q.dihedral_mean},
               {"dihedral_max_deg", q.dihedral_max},
               {"eta_max", q.eta_max},
               {"eta_95_percent", q.eta_95},
               {"eta_sum", q.eta_sum},
               {"shape_sum", q.shape_sum},
               {"mean_ratio", q.mean_ratio},
               {"mean_ratio_min", q.mean_ratio_min},
               {"volume", q.volume},
               {"worst_tetrahedron", q.worst_tet + 1},
               {"dihedral_histogram_10_deg", q.histogram},
               {"measures", measures},
               {"worst", worst}};
  if (q.curved.tets > 0) json["curved"] = to_json(q.curved);
  return json;
}

Json to_json(const Comparison& c) {
  Json patches = Json::array();
  for (const PatchChange& p : c.patches) {
    patches.push_back({{"tag", p.tag}, {"area_before", p.area_before}, {"area_change", p.area_change}});
  }
  return {{"volume_change", c.volume_change},
          {"area_change", c.area_change},
          {"region_volume_change", c.region_volume_change},
          {"patch_area_change", c.patch_area_change},
          {"patches", patches},
          {"mean_boundary_edge", c.mean_edge},
          {"distance_vertices_to_old", c.vertices_to_old},
          {"distance_new_to_old", c.new_to_old},
          {"distance_old_to_new", c.old_to_new},
          {"distance_sample_stride", c.sample_stride},
          {"deviation", c.mean_edge * std::max(c.new_to_old, c.old_to_new)},
          {"vertices_before", c.old_vertices},
          {"vertices_after", c.new_vertices},
          {"vertex_tags_kept", c.vertex_tags_kept},
          {"edge_tags_kept", c.edge_tags_kept},
          {"triangle_tags_kept", c.triangle_tags_kept},
          {"tetrahedron_tags_kept", c.tet_tags_kept},
          {"required_vertices_moved", c.required_moved},
          {"corners_moved", c.corners_moved}};
}

Json to_json(const Report& r) {
  Json json = {{"device", r.device},
               {"device_reason", r.device_reason},
               {"threads", r.threads},
               {"stopped", to_string(r.stop)},
               {"seconds", r.seconds},
               {"vertices", r.vertices},
               {"vertices_free", r.free_vertices},
               {"vertices_in_plane", r.plane_vertices},
               {"vertices_on_line", r.line_vertices},
               {"vertices_on_surface", r.surface_vertices},
               {"vertices_on_curve", r.curve_vertices},
               {"vertices_thin", r.thin_vertices},
               {"vertices_periodic", r.periodic_vertices},
               {"vertices_fixed", r.fixed_vertices},
               {"corners_not_held", r.corners_not_held},
               {"edges_not_held", r.edges_not_held},
               {"line_ends_not_held", r.line_ends_not_held},
               {"tetrahedra_before", r.tets_before},
               {"tetrahedra_after", r.tets_after},
               {"tetrahedra_bad", r.tets_bad},
               {"tetrahedra_active", r.tets_active},
               {"triangles_dropped", r.triangles_dropped},
               {"edges_dropped", r.edges_dropped},
               {"uncovered", r.uncovered},
               {"transfer_stopped", r.transfer_stopped},
               {"colors", r.colors},
               {"energy_before", r.energy_before},
               {"energy_after", r.energy_after}};
  add_counts<OperationCounts>(json, kOperationCounts, r);
  json["phase_seconds"] = Json::object();
  for (const PhaseTime& p : r.phases) json["phase_seconds"][p.phase] = p.seconds;
  json["sweeps"] = sweeps_json(r);
  json["flip_passes"] = flip_passes_json(r);
  json["worst_rounds"] = worst_rounds_json(r);
  json["restarts"] = r.restarts;
  json["restarts_kept"] = r.restarts_kept;
  json["curved_deviation"] = r.deviation;
  json["straightened"] = Json::array();
  for (const StraightenedEdge& e : r.straightened) {
    json["straightened"].push_back(
        {{"edge", {e.vertices[0] + 1, e.vertices[1] + 1}}, {"kept", e.kept}, {"moved", e.moved}});
  }
  json["targets"] = Json::array();
  for (const TargetReport& t : r.targets) json["targets"].push_back(to_json(t));
  return json;
}

namespace {

Json held_by_json(const std::array<std::int64_t, kLimitingConstraints>& counts) {
  Json held_by = Json::object();
  for (std::size_t k = 0; k < kLimitingConstraints; ++k) {
    held_by[to_string(static_cast<LimitingConstraint>(k))] = counts[k];
  }
  return held_by;
}

Json worst_json(const std::vector<MissedTet>& missed) {
  Json worst = Json::array();
  for (const MissedTet& m : missed) {
    Json item = {
        {"tetrahedron", m.tet + 1}, {"value", m.value}, {"centroid", m.centroid}, {"held_by", to_string(m.held_by)}};
    if (m.held_by == LimitingConstraint::surface_angle) {
      item["edge"] = {m.edge[0] + 1, m.edge[1] + 1};
      item["surface_angle_deg"] = m.surface_angle;
    }
    worst.push_back(item);
  }
  return worst;
}

}  // namespace

Json to_json(const TargetReport& r) {
  return {{"measure", to_string(r.target.measure)},
          {"value", r.target.value},
          {"met", r.met()},
          {"tetrahedra", r.tets},
          {"missed", r.missed},
          {"held_by", held_by_json(r.held_by)},
          {"worst", worst_json(r.worst)}};
}

Json to_json(const AcceptanceReport& report) {
  Json results = Json::array();
  for (const CriterionResult& r : report.results) {
    const AcceptanceCriterion& c = r.criterion;
    results.push_back({{"measure", info_of(c.measure).name},
                       {"verdict", to_string(r.verdict)},
                       {"warn", c.warn ? Json(*c.warn) : Json()},
                       {"fail", c.fail ? Json(*c.fail) : Json()},
                       {"allowed_percent", c.allowed_percent},
                       {"count", r.count},
                       {"warned", r.warned},
                       {"failed", r.failed},
                       {"worst", r.worst},
                       {"worst_tetrahedron", r.worst_tet + 1},
                       {"centroid", r.centroid},
                       {"source", c.source}});
  }
  return {{"criteria", report.name}, {"verdict", to_string(report.verdict)}, {"results", results}};
}

Json to_json(const CriteriaReport& report) {
  Json json = {{"before", to_json(report.before)}, {"after", to_json(report.after)}, {"rounds", Json::array()}};
  for (const CriteriaRound& r : report.rounds) {
    json["rounds"].push_back({{"rings", r.rings},
                              {"active", r.active},
                              {"failed_before", r.failed_before},
                              {"failed_after", r.failed_after},
                              {"kept", r.kept},
                              {"seconds", r.seconds}});
  }
  if (!report.undone.empty()) json["undone"] = report.undone;
  if (!report.no_rounds.empty()) json["no_rounds"] = report.no_rounds;
  json["limits"] = Json::array();
  for (const CriterionLimits& l : report.limits) {
    json["limits"].push_back({{"measure", info_of(l.criterion.measure).name},
                              {"held_by", held_by_json(l.held_by)},
                              {"worst", worst_json(l.worst)}});
  }
  return json;
}

Json to_json(const ValidationReport& report) {
  Json findings = Json::array();
  for (const Finding& f : report.findings) {
    Json first = Json::array();
    for (const Index id : f.first) first.push_back(id + 1);
    findings.push_back({{"kind", to_string(f.defect)}, {"where", f.where}, {"count", f.count}, {"first", first}});
  }
  return {{"valid", report.ok()}, {"findings", findings}};
}

std::size_t periodic_pairs(const TetMesh& mesh) {
  return std::accumulate(mesh.periodic.begin(), mesh.periodic.end(), std::size_t{0},
                         [](std::size_t n, const PeriodicLink& link) { return n + link.pairs.size(); });
}

Json counts_json(const TetMesh& mesh) {
  Json json = {{"listed_inside_out", mesh.listed_inside_out},
               {"vertices", mesh.points.size()},
               {"tetrahedra", mesh.tets.size()},
               {"triangles", mesh.triangles.size()},
               {"edges", mesh.edges.size()},
               {"corners", mesh.corners.size()},
               {"required_vertices", mesh.required_vertices.size()},
               {"ridges", mesh.ridges.size()},
               {"required_edges", mesh.required_edges.size()},
               {"required_triangles", mesh.required_triangles.size()},
               {"required_tetrahedra", mesh.required_tets.size()},
               {"periodic_pairs", periodic_pairs(mesh)}};
  for (const ElementBlock& block : mesh.others) {
    json[block.kind] = json.value(block.kind, std::size_t{0}) + block.tags.size();  // of either order
  }
  return json;
}

std::vector<std::string> run_warnings(const Report& report, const std::string& displacement) {
  std::string names;
  for (const std::string& name : report.moved_fields) {
    if (name != displacement) names += (names.empty() ? "" : ", ") + name;
  }
  std::vector<std::string> warnings = constraint_notes(report);
  if (!report.unchanged.empty()) warnings.push_back(report.unchanged);
  warnings.insert(warnings.end(), report.repeated_numbers.begin(), report.repeated_numbers.end());
  warnings.insert(warnings.end(), report.curved_warnings.begin(), report.curved_warnings.end());
  if (report.transfer_stopped) {
    warnings.push_back(
        "--data conserve: the run was stopped, and the transfer took longer than the run before it; data are those of "
        "--data interpolate, so totals have changed");
  }
  if (names.empty()) return warnings;
  warnings.push_back(
      "the values of " + names +
      " moved with their vertices; if they sample a field, --data interpolate or --data conserve evaluates it at the "
      "new positions");
  return warnings;
}

std::string json_text(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

std::string trace_csv(const Report& report) {
  std::string text = "event,iteration,pass,energy_before,decrease,gradient_norm2,moved,active,evaluated";
  for (const auto& kind : kFlipCounts) text += fmt::format(",{}", kind.key);
  text += ",seconds\n";
  double energy = report.energy_before;
  auto pass = report.flip_passes.begin();
  const auto flips_after = [&](int iteration) {
    for (; pass != report.flip_passes.end() && pass->iteration == iteration; ++pass) {
      text += fmt::format("flips,{},{},{:.17g},{:.17g},,,{},{}", iteration, pass->pass, energy, pass->decrease,
                          pass->active, pass->evaluated);
      for (const auto& kind : kFlipCounts) text += fmt::format(",{}", (*pass).*kind.count);
      text += fmt::format(",{:.6f}\n", pass->seconds);
      energy -= pass->decrease;
    }
  };
  flips_after(0);
  for (const SweepReport& s : report.sweeps) {
    text += fmt::format("sweep,{},,{:.17g},{:.17g},{:.17g},{},,{},{:.6f}\n", s.iteration, s.energy_before, s.decrease,
                        s.gradient_norm2, s.moved, std::string(kFlipCounts.size(), ','), s.seconds);
    energy = s.energy_before - s.decrease;
    flips_after(s.iteration);
  }
  return text;
}

}  // namespace tetune::cli

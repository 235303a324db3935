// SPDX-License-Identifier: Apache-2.0
#include "tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "report_files.hpp"

namespace tetune::cli {
namespace {

std::string tag_counts(const std::vector<int>& tags) {
  std::map<int, std::size_t> counts;
  for (const int tag : tags) ++counts[tag];
  constexpr std::size_t kShown = 8;
  std::string text;
  for (std::size_t shown = 0; const auto& [tag, count] : counts) {
    if (shown++ == kShown) {
      text += fmt::format(", ... ({} tags)", counts.size());
      break;
    }
    text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", tag, count);
  }
  return text;
}

std::string names_of(const std::vector<DataArray>& data) {
  std::string text;
  for (const DataArray& array : data) {
    text += (text.empty() ? "" : ", ") + array.name;
    if (array.components > 1) text += fmt::format(" ({})", array.components);
  }
  return text;
}

const char* yes(bool value) { return value ? "yes" : "NO"; }

}  // namespace

std::string format_value(Measure measure, double value) {
  const bool angle = measure == Measure::min_dihedral || measure == Measure::max_dihedral;
  return angle ? fmt::format("{:.3f}", value) : fmt::format("{:.5g}", value);
}

std::string mesh_summary(const TetMesh& mesh) {
  std::string text;
  const auto line = [&text](const std::string& name, std::size_t count, const std::string& extra) {
    if (count > 0) text += fmt::format("  {:<22}{:>12}{}\n", name, count, extra.empty() ? "" : "   tags " + extra);
  };
  line("vertices", mesh.points.size(), tag_counts(mesh.point_tags));
  line("tetrahedra", mesh.tets.size(), tag_counts(mesh.tet_tags));
  line("listed triangles", mesh.triangles.size(), tag_counts(mesh.triangle_tags));
  line("listed edges", mesh.edges.size(), tag_counts(mesh.edge_tags));
  for (const ElementBlock& b : mesh.others)
    line(b.kind + (mesh.second_order && b.second_order ? " (order 2)" : ""), b.tags.size(), tag_counts(b.tags));
  line("corners", mesh.corners.size(), "");
  line("required vertices", mesh.required_vertices.size(), "");
  line("ridges", mesh.ridges.size(), "");
  line("required edges", mesh.required_edges.size(), "");
  line("required triangles", mesh.required_triangles.size(), "");
  line("required tetrahedra", mesh.required_tets.size(), "");
  line("periodic pairs", periodic_pairs(mesh), "");
  for (const Group& group : mesh.groups) {
    text += fmt::format("  {:<22}{:>12}   {}{}\n", fmt::format("group of dimension {}", group.dimension), group.number,
                        group.name.empty() ? "" : fmt::format("\"{}\", ", group.name),
                        group.tags.empty() ? "no elements" : fmt::format("tags {}", fmt::join(group.tags, ", ")));
  }
  const auto data = [&text](const char* where, const std::vector<DataArray>& arrays) {
    if (!arrays.empty()) text += fmt::format("  data on {:<14}{}\n", where, names_of(arrays));
  };
  data("vertices", mesh.point_data);
  data("tetrahedra", mesh.tet_data);
  data("triangles", mesh.triangle_data);
  data("edges", mesh.edge_data);
  if (mesh.listed_inside_out) {
    text += "  all tetrahedra are listed inside out (negative volumes), and are written in the same way\n";
  }
  return text;
}

std::string curved_table(const CurvedQuality& q) {
  if (q.tets == 0) return "";
  std::string text = fmt::format(
      "  curved edges          {:>12}\n  curved tetrahedra     {:>12}   {} proved valid, {} inverted, {} undecided\n"
      "  scaled Jacobian  min  {:>12.5g}   corner ratio max {:.5g}, offset of mid-side nodes max {:.5g}\n",
      q.curved_edges, q.tets, q.valid, q.inverted, q.undecided, q.min_scaled_jacobian, q.max_corner_ratio,
      q.max_middle_offset);
  if (q.bad_integration > 0) {
    text += fmt::format("  not positive at an integration point: {} tetrahedra\n", q.bad_integration);
  }
  if (q.worst.empty()) return text;
  text += "  worst curved, counted from 1\n";
  for (const CurvedTet& t : q.worst) {
    text += fmt::format(
        "    {:>10}  {:<9}  scaled Jacobian {:>10.4g}  corner ratio {:>9.4g}  near {:.6g} {:.6g} {:.6g}\n", t.tet + 1,
        to_string(t.validity), t.scaled_jacobian(), t.corner_ratio, t.centroid[0], t.centroid[1], t.centroid[2]);
  }
  return text;
}

std::string curved_change(const CurvedQuality& before, const CurvedQuality& after) {
  if (before.tets == 0 && after.tets == 0) return "";
  const auto jacobian = [](const CurvedQuality& q) {
    return q.tets == 0 ? "-" : fmt::format("{:.4g}", q.min_scaled_jacobian);
  };
  return fmt::format("  curved: {} of {} not proved valid -> {} of {}; smallest scaled Jacobian {} -> {}\n",
                     before.tets - before.valid, before.tets, after.tets - after.valid, after.tets, jacobian(before),
                     jacobian(after));
}

std::string quality_table(const std::vector<std::string>& titles, const std::vector<Quality>& columns) {
  struct Row {
    const char* name;
    double Quality::*value;
    int digits;
    char type;
  };
  static constexpr std::array kRows{Row{"dihedral min  (deg)", &Quality::dihedral_min, 3, 'f'},
                                    Row{"         1 %", &Quality::dihedral_p1, 2, 'f'},
                                    Row{"         5 %", &Quality::dihedral_p5, 2, 'f'},
                                    Row{"         mean", &Quality::dihedral_mean, 2, 'f'},
                                    Row{"         max", &Quality::dihedral_max, 3, 'f'},
                                    Row{"eta      max", &Quality::eta_max, 5, 'g'},
                                    Row{"         95 %", &Quality::eta_95, 5, 'g'},
                                    Row{"         sum", &Quality::eta_sum, 8, 'g'},
                                    Row{"shape energy  sum", &Quality::shape_sum, 8, 'g'},
                                    Row{"mean ratio  mean", &Quality::mean_ratio, 4, 'f'},
                                    Row{"            min", &Quality::mean_ratio_min, 4, 'f'}};
  std::string text = fmt::format("  {:<22}", "");
  for (const std::string& title : titles) text += fmt::format("{:>14}", title);
  text += fmt::format("\n  {:<22}", "tetrahedra");
  for (const Quality& q : columns) text += fmt::format("{:>14}", q.tets);
  text += '\n';
  for (const Row& row : kRows) {
    text += fmt::format("  {:<22}", row.name);
    for (const Quality& q : columns) {
      const double value = q.*row.value;
      text +=
          row.type == 'f' ? fmt::format("{:>14.{}f}", value, row.digits) : fmt::format("{:>14.{}g}", value, row.digits);
    }
    text += '\n';
  }
  return text;
}

std::string measure_table(const std::string& title, const Quality& quality) {
  if (quality.tets == 0) return "";
  std::string text =
      fmt::format("  {:<22}{:>12}{:>12}{:>12}{:>12}{:>12}\n", title, "worst", "1 %", "5 %", "mean", "best");
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const auto measure = static_cast<Measure>(k);
    const MeasureSummary& s = quality.measures[k];
    const bool low = larger_is_better(measure);
    text += fmt::format("  {:<22}", to_string(measure));
    for (const double value : {low ? s.min : s.max, s.p1, s.p5, s.mean, low ? s.max : s.min}) {
      text += fmt::format("{:>12}", format_value(measure, value));
    }
    text += '\n';
  }
  return text;
}

std::string worst_table(const std::string& title, const Quality& quality) {
  if (quality.worst.empty()) return "";
  std::string text = fmt::format("  {:<22}{:>12}{:>12}    centroid\n", title, "min angle", "q_h");
  for (const WorstTet& w : quality.worst) {
    text += fmt::format("  {:<22}{:>12.3f}{:>12.4g}    {:.6g} {:.6g} {:.6g}\n", w.tet + 1, w.dihedral, w.harmonic,
                        w.centroid[0], w.centroid[1], w.centroid[2]);
  }
  return text;
}

std::string histogram(const Quality& quality) {
  const double max_share = *std::max_element(quality.histogram.begin(), quality.histogram.end());
  std::string text = "  dihedral angles\n";
  for (std::size_t b = 0; b < quality.histogram.size(); ++b) {
    const double share = quality.histogram[b];
    const auto bar = max_share > 0 ? static_cast<std::size_t>(std::lround(40 * share / max_share)) : 0;
    text +=
        fmt::format("  {:>4} -{:>4} deg {:>7.3f} %  {}\n", 10 * b, 10 * (b + 1), 100 * share, std::string(bar, '#'));
  }
  return text;
}

std::string surface_table(const Comparison& c) {
  std::string text;
  text += fmt::format("  volume change          {:+.2e} (largest of a region {:.2e})\n", c.volume_change,
                      c.region_volume_change);
  text += fmt::format("  surface area change    {:+.2e} (largest of a tagged patch {:.2e})\n", c.area_change,
                      c.patch_area_change);
  const auto distance = [&](const char* name, const char* what, double edges) {
    text +=
        fmt::format("  {:<22} {} {:.2e} ({:.2e} of the mean boundary edge)\n", name, what, edges * c.mean_edge, edges);
  };
  distance("surface distance", "new to old", c.new_to_old);
  distance("", "old to new", c.old_to_new);
  distance("", "vertices to old", c.vertices_to_old);
  if (c.sample_stride > 1) {
    text += fmt::format("  {:<22} at one in {} vertices, midpoints and centroids; at all: tetune compare IN OUT\n", "",
                        c.sample_stride);
  }
  return text;
}

std::string comparison_table(const Comparison& c) {
  std::string text;
  text += fmt::format("  vertices               {} -> {}\n", c.old_vertices, c.new_vertices);
  text += fmt::format("  tetrahedra             {} -> {}\n", c.old_tets, c.new_tets);
  text += surface_table(c);
  text += fmt::format("  tags kept              vertices {}, edges {}, triangles {}, tetrahedra {}\n",
                      yes(c.vertex_tags_kept), yes(c.edge_tags_kept), yes(c.triangle_tags_kept), yes(c.tet_tags_kept));
  text += fmt::format("  listed vertices moved  required {}, corners {}\n", c.required_moved, c.corners_moved);
  return text;
}

std::string constraint_table(const Report& r) {
  std::string text;
  const auto line = [&text](const char* name, std::int64_t count) {
    if (count > 0) text += fmt::format("  {:<22}{:>12}\n", name, count);
  };
  line("free vertices", r.free_vertices);
  line("vertices in planes", r.plane_vertices);
  line("vertices on lines", r.line_vertices);
  line("vertices on surface", r.surface_vertices);
  line("vertices on curves", r.curve_vertices);
  line("periodic vertices", r.periodic_vertices);
  line("fixed vertices", r.fixed_vertices);
  return text;
}

std::vector<std::string> constraint_notes(const Report& r) {
  std::vector<std::string> texts;
  if (r.corners_not_held > 0) {
    texts.push_back(fmt::format(
        "{} listed corners lie where the surface has no feature and are too many for a list of corners: they may move",
        r.corners_not_held));
  }
  if (r.edges_not_held > 0) {
    texts.push_back(
        fmt::format("{} tagged edges are too many for feature lines: their vertices may leave them", r.edges_not_held));
  }
  if (r.line_ends_not_held > 0) {
    texts.push_back(
        fmt::format("{} ends and junctions of tagged edges are too many for those of lines: they may move along them",
                    r.line_ends_not_held));
  }
  if (r.thin_vertices > 0) {
    texts.push_back(
        fmt::format("{} vertices of thin curved sheets and their rims do not slide, as the sheets could become several "
                    "times as thick: "
                    "--max-deviation lets them slide within a bound",
                    r.thin_vertices));
  }
  if (r.triangles_dropped > 0) {
    texts.push_back(fmt::format(
        "{} listed triangles constrain nothing and are dropped: they are not faces of the mesh, or lie inside a "
        "region without a tag or with --no-open-boundaries; an interface is kept if the tetrahedra on its sides or "
        "its triangles have tags: name cell data that have them (--tags), or write a format with tags, such as .msh",
        r.triangles_dropped));
  }
  if (r.edges_dropped > 0) {
    texts.push_back(
        fmt::format("{} listed edges without a tag are not edges of the result and are dropped", r.edges_dropped));
  }
  constexpr double kRounding = 1e-12;
  if (r.uncovered > kRounding) {
    texts.push_back(fmt::format(
        "{:.2g} % of the input's volume is outside the result; its data were assigned to the nearest tetrahedra",
        100 * r.uncovered));
  }
  return texts;
}

std::string straightened_text(const std::vector<StraightenedEdge>& edges) {
  if (edges.empty()) return {};
  std::string text = fmt::format(
      "  {} edges of the surface were partly straightened, as an element would not be valid otherwise; vertices "
      "counted from 1, and the fraction of the curvature that is kept:\n",
      edges.size());
  for (const StraightenedEdge& e : edges) {
    text += fmt::format("    {} {}: {:.1f} %, mid-side node moved by {:.4g}\n", e.vertices[0] + 1, e.vertices[1] + 1,
                        100 * e.kept, e.moved);
  }
  return text;
}

std::string count_line(const Report& r, const char* reason) {
  std::string text = fmt::format("  {} sweeps", r.sweeps.size());
  for (const auto& kind : kOperationCounts) {
    if (r.*kind.count > 0) text += fmt::format(", {} {}", r.*kind.count, kind.title);
  }
  text += fmt::format(", {}; {} of {} vertices fixed\n", reason, r.fixed_vertices, r.vertices);
  if (r.tets_untangled > 0) {
    text += fmt::format(
        "  {} inverted or flat tetrahedra made positive; \"before\" uses the absolute volume of inverted ones\n",
        r.tets_untangled);
  }
  return text + straightened_text(r.straightened);
}

std::string active_line(const Report& r, const Options& options) {
  if (options.only_below.empty()) return "";
  if (r.tets_active == 0) {
    return "  nothing to do: no tetrahedron is below the limits of --only-below, and the mesh stays as it is\n";
  }
  return fmt::format("  {} tetrahedra below the limits of --only-below, {} might change; all others stay\n", r.tets_bad,
                     r.tets_active);
}

std::string run_table(const Report& report) {
  std::string text = "  sweep     moved         energy       decrease  |grad tr|^2     time s\n";
  for (const SweepReport& s : report.sweeps) {
    text += fmt::format("  {:>5} {:>9} {:>14.8g} {:>14.4g} {:>12.4g} {:>10.4f}\n", s.iteration, s.moved,
                        s.energy_before, s.decrease, s.gradient_norm2, s.seconds);
  }
  text += "  after sweep  pass     active  evaluated";
  for (const auto& kind : kFlipCounts) text += fmt::format(" {:>14}", kind.name);
  text += "       decrease     time s\n";
  for (const FlipReport& f : report.flip_passes) {
    text += fmt::format("  {:>11} {:>5} {:>10} {:>10}", f.iteration, f.pass, f.active, f.evaluated);
    for (const auto& kind : kFlipCounts) text += fmt::format(" {:>14}", f.*kind.count);
    text += fmt::format(" {:>14.4g} {:>10.4f}\n", f.decrease, f.seconds);
  }
  if (!report.worst_rounds.empty())
    text += "  work        round      worst inserted removed   flips   moved     time s\n";
  for (const WorstReport& w : report.worst_rounds) {
    text += fmt::format("  {:<11} {:>5} {:>10} {:>8} {:>7} {:>7} {:>7} {:>10.4f}\n", w.work, w.round, w.worst,
                        w.inserted, w.removed, w.flips, w.moved, w.seconds);
  }
  text += "  phase        time s\n";
  for (const PhaseTime& p : report.phases) text += fmt::format("  {:<10} {:>8.4f}\n", p.phase, p.seconds);
  return text;
}

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#include "mesh/validate_arrays.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backend/span.hpp"
#include "mesh/finding_collector.hpp"

namespace tetune {
namespace {

/// Whether all ids are in [0, size); vectorizes, because nearly every array is valid.
bool all_below(Span<const Index> ids, Size size) {
  std::uint32_t max_id = 0;
  for (Size i = 0; i < ids.size(); ++i) max_id = std::max(max_id, static_cast<std::uint32_t>(ids[i]));
  return ids.size() == 0 || max_id < size;
}

/// Checks the indices of elements with `per_element` indices each.
void check_indices(Span<const Index> ids, Size size, Size per_element, const std::string& where,
                   ValidationReport& report) {
  if (all_below(ids, size)) return;
  FindingCollector out_of_range(Defect::index_out_of_range, where);
  Size last = -1;
  for (Size i = 0; i < ids.size(); ++i) {
    if (ids[i] >= 0 && ids[i] < size) continue;
    const Size element = i / per_element;
    if (element != last) out_of_range.add(element);
    last = element;
  }
  out_of_range.finish(report);
}

template <std::size_t N>
void check_elements(const std::vector<std::array<Index, N>>& elements, Size vertices, const std::string& where,
                    ValidationReport& report) {
  if (elements.empty()) return;
  check_indices({elements.front().data(), Size{N} * std::ssize(elements)}, vertices, N, where, report);
}

void add_bad_length(Size length, const std::string& where, ValidationReport& report) {
  report.findings.push_back({Defect::bad_array_length, length, {}, where});
}

void check_length(Size tags, Size elements, const std::string& where, ValidationReport& report) {
  if (tags != elements) add_bad_length(tags, where, report);
}

void check_data(const std::vector<DataArray>& data, Size entries, const std::string& where, ValidationReport& report) {
  for (const DataArray& array : data) {
    const Size values = std::visit([](const auto& v) { return std::ssize(v); }, array.values);
    const Size components = array.components;
    if (components < 1 || values / components != entries || values % components != 0) {
      add_bad_length(values, "values of \"" + array.name + "\" on " + where, report);
    }
  }
}

void check_block(const ElementBlock& block, Size vertices, ValidationReport& report) {
  const Size elements = std::ssize(block.tags);
  const Size per_element = std::max(1, block.vertices_per_element);
  if (block.vertices_per_element < 1) add_bad_length(block.vertices_per_element, "vertices of " + block.kind, report);
  check_length(elements * per_element, std::ssize(block.element2vertex), block.kind, report);
  check_indices(span_of(block.element2vertex), vertices, per_element, block.kind, report);
  check_indices(span_of(block.required), elements, 1, "required " + block.kind, report);
  check_data(block.data, elements, block.kind, report);
}

void check_coordinates(Span<const Point3> points, ValidationReport& report) {
  // 0 * x is 0 for a finite x, otherwise NaN: one branch for all.
  double zero = 0;
  for (Size v = 0; v < points.size(); ++v) zero += 0 * points[v][0] + 0 * points[v][1] + 0 * points[v][2];
  if (zero == 0) return;
  FindingCollector not_finite(Defect::not_finite, "vertices");
  for (Size v = 0; v < points.size(); ++v) {
    const Point3& p = points[v];
    if (!std::all_of(p.begin(), p.end(), [](double x) { return std::isfinite(x); })) not_finite.add(v);
  }
  not_finite.finish(report);
}

}  // namespace

ValidationReport validate_counts(const ArrayCounts& counts) {
  ValidationReport report;
  const auto check = [&report](Size entries, Index max_entries, const std::string& where) {
    if (entries <= max_entries) return;
    add_bad_length(entries, where + " (there can be " + std::to_string(max_entries) + ")", report);
  };
  check(counts.vertices, kMaxEntries, "vertices");
  check(counts.tets, kMaxTets, "tetrahedra");
  check(counts.triangles, kMaxEntries, "triangles");
  check(counts.edges, kMaxEntries, "edges");
  check(counts.others, kMaxEntries, "elements of other kinds");
  return report;
}

ValidationReport validate_arrays(const TetMesh& mesh) {
  const Size vertices = std::ssize(mesh.points);
  const Size tets = std::ssize(mesh.tets);
  const Size triangles = std::ssize(mesh.triangles);
  const Size edges = std::ssize(mesh.edges);
  ArrayCounts counts{vertices, tets, triangles, edges};
  for (const ElementBlock& block : mesh.others) counts.others += std::ssize(block.tags);
  ValidationReport report = validate_counts(counts);
  if (!report.ok()) return report;
  check_length(std::ssize(mesh.point_tags), vertices, "vertex tags", report);
  check_length(std::ssize(mesh.tet_tags), tets, "tetrahedron tags", report);
  check_length(std::ssize(mesh.triangle_tags), triangles, "triangle tags", report);
  check_length(std::ssize(mesh.edge_tags), edges, "edge tags", report);
  check_elements(mesh.tets, vertices, "tetrahedra", report);
  check_elements(mesh.triangles, vertices, "triangles", report);
  check_elements(mesh.edges, vertices, "edges", report);
  check_indices(span_of(mesh.corners), vertices, 1, "corners", report);
  check_indices(span_of(mesh.required_vertices), vertices, 1, "required vertices", report);
  check_indices(span_of(mesh.ridges), edges, 1, "ridges", report);
  check_indices(span_of(mesh.required_edges), edges, 1, "required edges", report);
  check_indices(span_of(mesh.required_triangles), triangles, 1, "required triangles", report);
  check_indices(span_of(mesh.required_tets), tets, 1, "required tetrahedra", report);
  for (const ElementBlock& block : mesh.others) check_block(block, vertices, report);
  check_data(mesh.point_data, vertices, "vertices", report);
  check_data(mesh.tet_data, tets, "tetrahedra", report);
  check_data(mesh.triangle_data, triangles, "triangles", report);
  check_data(mesh.edge_data, edges, "edges", report);
  check_coordinates(span_of(mesh.points), report);
  return report;
}

}  // namespace tetune

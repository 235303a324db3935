// SPDX-License-Identifier: Apache-2.0
#include "tetune/validate.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "backend/cpu.hpp"
#include "mesh/connect.hpp"
#include "mesh/element_kinds.hpp"
#include "mesh/finding_texts.hpp"
#include "mesh/messages.hpp"
#include "mesh/sorted.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/validate_arrays.hpp"
#include "mesh/work_mesh.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Collects the elements that have one defect: their number and the first ids.
class FindingCollector {
 public:
  FindingCollector(Defect defect, std::string where) : finding_{defect, 0, {}, std::move(where)} {}
  void add(std::int64_t id) {
    ++finding_.count;
    if (finding_.first.size() < kShownIds) finding_.first.push_back(static_cast<Index>(id));
  }
  void set_bad_index(BadIndex bad) { finding_.bad_index = std::move(bad); }
  /// Appends the finding to the report if there is any element.
  void finish(ValidationReport& report) const {
    if (finding_.count > 0) report.findings.push_back(finding_);
  }

 private:
  Finding finding_;
};

/// Whether all ids are in [0, size). Without an early exit, so that the loop vectorizes: nearly every array is valid.
bool all_below(Span<const Index> ids, Size size) {
  std::uint32_t max_id = 0;
  for (Size i = 0; i < ids.size(); ++i) max_id = std::max(max_id, static_cast<std::uint32_t>(ids[i]));
  return ids.size() == 0 || max_id < size;
}

/// Describes the first index out of range; requires one.
BadIndex find_bad_index(Span<const Index> ids, Size size, const std::string& list) {
  BadIndex bad{0, size, list};
  Index min_id = ids[0], max_id = ids[0];
  for (Size i = ids.size() - 1; i >= 0; --i) {
    min_id = std::min(min_id, ids[i]);
    max_id = std::max(max_id, ids[i]);
    if (ids[i] < 0 || ids[i] >= size) bad.index = ids[i];
  }
  bad.from_one = min_id >= 1 && max_id == size;
  return bad;
}

/// Checks that the ids of elements, `per_element` each, are in [0, size): those of entries of `list`.
void check_indices(Span<const Index> ids, Size size, const std::string& list, Size per_element,
                   const std::string& where, ValidationReport& report) {
  if (all_below(ids, size)) return;
  FindingCollector out_of_range(Defect::index_out_of_range, where);
  out_of_range.set_bad_index(find_bad_index(ids, size, list));
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
  check_indices({elements.front().data(), Size{N} * std::ssize(elements)}, vertices, "vertices", N, where, report);
}

/// `expected`: negative where no length would be right.
void check_length(Size entries, Size expected, const std::string& where, ValidationReport& report) {
  if (entries == expected) return;
  report.findings.push_back({Defect::bad_array_length, entries, {}, where, std::nullopt, expected});
}

void check_data(const std::vector<DataArray>& data, Size entries, const std::string& where, ValidationReport& report) {
  for (const DataArray& array : data) {
    const Size values = std::visit([](const auto& v) { return std::ssize(v); }, array.values);
    const Size components = array.components;
    const std::string name = "values of \"" + array.name + "\" on " + where;
    if (components < 1) {
      check_length(values, -1, name + ", of " + std::to_string(components) + " components,", report);
    } else {
      check_length(values, components * entries, name, report);
    }
  }
}

void check_block(const ElementBlock& block, Size vertices, ValidationReport& report) {
  const Size elements = std::ssize(block.tags);
  const Size per_element = std::max(1, block.vertices_per_element);
  const ElementKind* const kind = find_element_kind(block.kind);
  check_length(Size{block.vertices_per_element}, kind == nullptr ? per_element : Size{kind->vertices},
               "vertices of " + block.kind, report);
  check_length(elements * per_element, std::ssize(block.element2vertex), block.kind, report);
  check_indices(span_of(block.element2vertex), vertices, "vertices", per_element, block.kind, report);
  check_indices(span_of(block.required), elements, block.kind, 1, "required " + block.kind, report);
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

/// For each entry of a sorted list, 1 if it is an edge of a tetrahedron, of a listed triangle or of another element of
/// second order, or a listed edge.
std::vector<std::uint8_t> find_edges(const TetMesh& mesh, const std::vector<CurvedEdge>& list) {
  std::vector<std::uint8_t> found(list.size(), 0);
  const auto find = [&](Index a, Index b) {
    const std::array edge{std::min(a, b), std::max(a, b)};
    const auto at = std::lower_bound(list.begin(), list.end(), edge,
                                     [](const CurvedEdge& e, const auto& sought) { return e.vertices < sought; });
    if (at != list.end() && at->vertices == edge) span_of(found)[at - list.begin()] = 1;
  };
  const auto find_in = [&](const auto& elements) {
    for (const auto& element : elements) {
      for (std::size_t i = 0; i < element.size(); ++i) {
        for (std::size_t j = i + 1; j < element.size(); ++j) find(element[i], element[j]);
      }
    }
  };
  find_in(mesh.tets);
  find_in(mesh.triangles);
  find_in(mesh.edges);
  for_each_other_middle(mesh, find);
  return found;
}

void check_curved_edges(const TetMesh& mesh, ValidationReport& report) {
  const std::string where = "curved edges";
  const std::vector<CurvedEdge>& list = mesh.curved_edges;
  FindingCollector out_of_range(Defect::index_out_of_range, where);
  FindingCollector not_finite(Defect::not_finite, where);
  FindingCollector bad(Defect::bad_curved_edge, where);
  bool is_sorted = true;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto& [vertices, middle] = list[i];
    const Size points = std::ssize(mesh.points);
    if (vertices[0] < 0 || vertices[1] >= points) {
      out_of_range.set_bad_index({vertices[0] < 0 ? vertices[0] : vertices[1], points, "vertices"});
      out_of_range.add(Size(i));
    }
    if (!std::all_of(middle.begin(), middle.end(), [](double x) { return std::isfinite(x); })) not_finite.add(Size(i));
    if (vertices[0] < vertices[1] && (i == 0 || list[i - 1].vertices < vertices)) continue;
    bad.add(Size(i));
    is_sorted = false;
  }
  if (is_sorted) {
    const std::vector<std::uint8_t> found = find_edges(mesh, list);
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (found[i] == 0) bad.add(Size(i));
    }
  }
  for (const FindingCollector* defect : {&out_of_range, &not_finite, &bad}) defect->finish(report);
}

using Tet4 = std::array<Index, 4>;

bool has_repeated_vertex(Tet4 v) {
  std::sort(v.begin(), v.end());
  return std::adjacent_find(v.begin(), v.end()) != v.end();
}

void check_volumes(const TetMesh& mesh, int threads, ValidationReport& report) {
  FindingCollector repeated(Defect::repeated_vertex, "tetrahedra");
  FindingCollector inverted(Defect::inverted_tet, "tetrahedra");
  FindingCollector flat(Defect::flat_tet, "tetrahedra");
  FindingCollector tiny(Defect::tiny_tet, "tetrahedra");
  const std::vector<std::int8_t> signs = volume_signs(mesh, threads);
  for (std::size_t t = 0; t < signs.size(); ++t) {
    if (signs[t] == 1) continue;
    FindingCollector& defect = has_repeated_vertex(mesh.tets[t]) ? repeated
                               : signs[t] < 0                    ? inverted
                               : signs[t] == 0                   ? flat
                                                                 : tiny;
    defect.add(static_cast<std::int64_t>(t));
  }
  for (const FindingCollector* defect : {&repeated, &inverted, &flat, &tiny}) defect->finish(report);
}

/// Adds each id once, in increasing order, to a finding of tetrahedra.
void add_tets(std::vector<Index> tets, Defect defect, ValidationReport& report) {
  sort_unique(tets);
  FindingCollector finding(defect, "tetrahedra");
  for (const Index t : tets) finding.add(t);
  finding.finish(report);
}

/// A tetrahedron at a face, by its sorted vertices.
struct TetAtFace {
  Tet4 vertices;
  const SortedHalfFace* half_face;
  bool operator<(const TetAtFace& other) const {
    return std::tie(vertices, half_face) < std::tie(other.vertices, other.half_face);
  }
};

/// Reports duplicate tetrahedra, and the tetrahedra at faces that are non-manifold or have both sides on one of them.
/// Faces count the tetrahedra that differ, as otherwise each face of a duplicate would be such a face too.
void find_bad_faces(const TetMesh& mesh, int threads, ValidationReport& report) {
  std::vector<Index> duplicate;
  std::vector<Index> non_manifold;
  std::vector<Index> misoriented;
  const TetMeshView view(mesh);
  std::vector<TetAtFace> at_face;
  for_each_face(sorted_half_faces(mesh, threads), [&](auto begin, auto end) {
    at_face.clear();
    for (auto half_face = begin; half_face != end; ++half_face) {
      Tet4 vertices = view.tets[half_face->tet];
      std::sort(vertices.begin(), vertices.end());
      at_face.push_back({vertices, &*half_face});
    }
    std::sort(at_face.begin(), at_face.end());
    std::size_t different = 0;
    for (const TetAtFace& t : at_face) {
      if (different == 0 || at_face[different - 1].vertices != t.vertices) {
        at_face[different++] = t;
      } else if (at_face[different - 1].half_face->tet != t.half_face->tet) {
        duplicate.push_back(t.half_face->tet);
      }
    }
    at_face.resize(different);
    if (at_face.size() > 2) {
      for (const TetAtFace& t : at_face) non_manifold.push_back(t.half_face->tet);
    } else if (at_face.size() == 2 && at_face[0].half_face->odd == at_face[1].half_face->odd) {
      misoriented.push_back(std::max(at_face[0].half_face->tet, at_face[1].half_face->tet));
    }
  });
  add_tets(duplicate, Defect::duplicate_tet, report);
  add_tets(non_manifold, Defect::face_on_three_tets, report);
  add_tets(misoriented, Defect::same_side_of_face, report);
}

/// The coordinate of the largest absolute value; requires vertices.
LargestCoordinate largest_coordinate(const TetMesh& mesh) {
  LargestCoordinate largest;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    for (const double x : mesh.points[v]) {
      if (std::fabs(x) > std::fabs(largest.value)) largest = {Index(v), x};
    }
  }
  return largest;
}

/// A finding without ids: "3 of the tetrahedra are flat (zero volume)".
std::string sentence(const Finding& f) {
  if (f.defect == Defect::bad_array_length) {
    const std::string text = f.where + " have " + std::to_string(f.count) + " entries";
    return f.expected < 0 ? text : text + ", and not " + std::to_string(f.expected);
  }
  struct Predicate {
    bool has;
    const char* rest;
  };
  static constexpr Predicate kPredicates[] = {
      {true, "an index out of range"},
      {true, "the wrong length"},
      {true, "a coordinate that is not a finite number"},
      {true, "the same vertex twice"},
      {false, "inverted (negative volume)"},
      {false, "flat (zero volume)"},
      {false, "too small for arithmetic at the scale of the largest coordinate"},
      {false, "listed twice"},
      {false, "at a non-manifold face, which three or more share"},
      {false, "misoriented, on the same side of a face as a neighbor"},
      {false, "not in ascending order, listed twice or no edge of an element"}};
  const Predicate& p = kPredicates[std::size_t(f.defect)];
  const char* const verb = p.has ? (f.count == 1 ? "has" : "have") : f.count == 1 ? "is" : "are";
  return std::to_string(f.count) + " of the " + f.where + " " + verb + " " + p.rest;
}

}  // namespace

const char* to_string(Defect defect) {
  return name_of(defect, {"index out of range", "array of the wrong length", "coordinate that is not a finite number",
                          "the same vertex twice in one tetrahedron", "inverted tetrahedra (negative volume)",
                          "flat tetrahedra (zero volume)",
                          "tetrahedra too small for arithmetic at the scale of the largest coordinate",
                          "tetrahedra listed twice", "tetrahedra at a non-manifold face, which three or more share",
                          "misoriented tetrahedra, on the same side of a face as their neighbor",
                          "entry that is not in ascending order, listed twice or no edge of an element"});
}

std::string ValidationReport::message(bool one_based, const std::string& advice) const {
  std::string text = "the mesh is not valid:";
  bool can_be_untangled = true;
  for (const Finding& f : findings) {
    text += "\n  " + sentence(f) + first_ids(f.first, one_based);
    if (f.bad_index) text += text_of(*f.bad_index, one_based);
    if (f.place) text += ", the first " + place_text(*f.place);
    if (f.largest) text += text_of(*f.largest, one_based);
    can_be_untangled = can_be_untangled && (f.defect == Defect::inverted_tet || f.defect == Defect::flat_tet);
  }
  return text + (can_be_untangled ? "\n  " + advice + ", or repair the mesh in the program that made it."
                                  : std::string("\n  ") + advice_on(findings));
}

ValidationReport validate_counts(const ArrayCounts& counts) {
  ValidationReport report;
  const auto check = [&report](Size entries, Index max_entries, const std::string& where) {
    if (entries <= max_entries) return;
    check_length(entries, -1, where + ", of which there can be " + std::to_string(max_entries) + ",", report);
  };
  check(counts.vertices, kMaxEntries, "vertices");
  check(counts.tets, kMaxTets, "tetrahedra");
  check(counts.triangles, kMaxEntries, "triangles");
  check(counts.edges, kMaxEntries, "edges");
  check(counts.others, kMaxEntries, "elements of other kinds");
  return report;
}

ValidationReport validate_indices(const TetMesh& mesh) {
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
  check_indices(span_of(mesh.corners), vertices, "vertices", 1, "corners", report);
  check_indices(span_of(mesh.required_vertices), vertices, "vertices", 1, "required vertices", report);
  check_indices(span_of(mesh.ridges), edges, "edges", 1, "ridges", report);
  check_indices(span_of(mesh.required_edges), edges, "edges", 1, "required edges", report);
  check_indices(span_of(mesh.required_triangles), triangles, "triangles", 1, "required triangles", report);
  check_indices(span_of(mesh.required_tets), tets, "tetrahedra", 1, "required tetrahedra", report);
  for (const PeriodicLink& link : mesh.periodic) check_elements(link.pairs, vertices, "periodic pairs", report);
  for (const ElementBlock& block : mesh.others) check_block(block, vertices, report);
  check_data(mesh.point_data, vertices, "vertices", report);
  check_data(mesh.tet_data, tets, "tetrahedra", report);
  check_data(mesh.triangle_data, triangles, "triangles", report);
  check_data(mesh.edge_data, edges, "edges", report);
  return report;
}

ValidationReport validate_arrays(const TetMesh& mesh) {
  ValidationReport report = validate_indices(mesh);
  check_coordinates(span_of(mesh.points), report);
  if (!mesh.curved_edges.empty() && report.ok()) check_curved_edges(mesh, report);
  return report;
}

void require_arrays(const TetMesh& mesh) {
  if (const ValidationReport report = validate_arrays(mesh); !report.ok()) throw MeshError(report.message(false));
}

ValidationReport validate(const TetMesh& mesh, int threads) {
  ValidationReport report = validate_arrays(mesh);
  if (!report.ok()) return report;
  check_volumes(mesh, threads, report);
  const backend::Cpu cpu(threads);
  WorkMesh<backend::Cpu> work = upload_mesh(cpu, mesh);
  if (!build_adjacency(cpu, work).ok()) find_bad_faces(mesh, threads, report);
  for (Finding& f : report.findings) {
    f.place = TetMeshView(mesh).centroid(f.first[0]);
    if (f.defect == Defect::tiny_tet) f.largest = largest_coordinate(mesh);
  }
  return report;
}

}  // namespace tetune

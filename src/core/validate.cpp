// SPDX-License-Identifier: Apache-2.0
#include "tetune/validate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/connect.hpp"
#include "core/fetch_ahead.hpp"
#include "core/first_ids.hpp"
#include "core/orient.hpp"
#include "core/unit_scale.hpp"
#include "core/upload.hpp"
#include "core/validate_arrays.hpp"
#include "par/cpu.hpp"

namespace tetune {
namespace {

/// Collects offenders of one kind.
class Collector {
 public:
  Collector(Defect defect, std::string where) : finding_{defect, 0, {}, std::move(where)} {}
  void add(std::int64_t id) {
    ++finding_.count;
    if (finding_.first.size() < kShownIds) finding_.first.push_back(static_cast<Index>(id));
  }
  void finish(ValidationReport& report) const {
    if (finding_.count > 0) report.findings.push_back(finding_);
  }

 private:
  Finding finding_;
};

/// Whether all are in [0, size): in vector code, as nearly always all are.
bool all_below(const Index* ids, std::size_t count, std::size_t size) {
  std::uint32_t most = 0;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, static_cast<std::uint32_t>(ids[i]));
  return count == 0 || most < size;
}

void check_indices(const std::vector<Index>& ids, std::size_t size, std::size_t each, const std::string& where,
                   ValidationReport& report) {
  if (all_below(ids.data(), ids.size(), size)) return;
  Collector out(Defect::index_out_of_range, where);
  std::int64_t last = -1;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] >= 0 && static_cast<std::size_t>(ids[i]) < size) continue;
    const auto element = static_cast<std::int64_t>(i / each);
    if (element != last) out.add(element);
    last = element;
  }
  out.finish(report);
}

template <std::size_t N>
void check_elements(const std::vector<std::array<Index, N>>& elements, std::size_t vertices, const std::string& where,
                    ValidationReport& report) {
  if (!elements.empty() && all_below(elements.front().data(), N * elements.size(), vertices)) return;
  Collector out(Defect::index_out_of_range, where);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const bool bad = std::any_of(elements[i].begin(), elements[i].end(),
                                 [vertices](Index v) { return v < 0 || static_cast<std::size_t>(v) >= vertices; });
    if (bad) out.add(static_cast<std::int64_t>(i));
  }
  out.finish(report);
}

void check_length(std::size_t tags, std::size_t elements, const std::string& where, ValidationReport& report) {
  if (tags == elements) return;
  report.findings.push_back({Defect::bad_array_length, static_cast<std::int64_t>(tags), {}, where});
}

void check_data(const std::vector<DataArray>& data, std::size_t entries, const std::string& where,
                ValidationReport& report) {
  for (const DataArray& array : data) {
    const std::size_t values = std::visit([](const auto& v) { return v.size(); }, array.values);
    const auto each = static_cast<std::size_t>(std::max(0, array.components));
    if (each == 0 || values / each != entries || values % each != 0) {
      report.findings.push_back({Defect::bad_array_length,
                                 static_cast<std::int64_t>(values),
                                 {},
                                 "values of \"" + array.name + "\" on " + where});
    }
  }
}

/// Sign of a volume; kTiny where it is positive but too small to compute with.
constexpr std::int8_t kTiny = 2;
/// The bound of such a volume. It depends on the order of the vertices, and flips choose that by themselves: of a
/// volume that is certified in one order, it is above kOrientBound * kOrientUnderflow / 8 in all.
constexpr double kTinyBound = 1e-270;

std::int8_t orient_tet(const TetMesh& mesh, double scale, std::size_t t) {
  const auto& tet = mesh.tets[t];
  const auto p = [&](std::size_t k) -> const Point3& { return mesh.points[static_cast<std::size_t>(tet[k])]; };
  const Orient o = orient(scale * vec(p(0)), scale * vec(p(1)), scale * vec(p(2)), scale * vec(p(3)));
  if (o.certified()) return 1;
  if (is_certified(-o.det, o.bound)) return -1;
  const int sign = orient_sign(p(0), p(1), p(2), p(3));
  return static_cast<std::int8_t>(sign > 0 && !(o.bound > kTinyBound) ? kTiny : sign);
}

std::vector<std::int8_t> orient_all(const TetMesh& mesh, int threads) {
  const double scale = unit_scale(mesh);
  std::vector<std::int8_t> sign(mesh.tets.size());
  const par::Cpu cpu(threads);
  cpu.for_each(static_cast<Size>(mesh.tets.size()), [&](Size t) {
    fetch_ahead(mesh, t);
    sign[static_cast<std::size_t>(t)] = orient_tet(mesh, scale, static_cast<std::size_t>(t));
  });
  return sign;
}

/// One side of a face: its vertices in increasing order, and whether the tetrahedron lists them in an odd permutation.
struct Side {
  std::array<Index, 3> key;
  Index tet;
  bool odd;
};

/// All sides, those of one face together, by id of the tetrahedron: for bad input only.
std::vector<Side> sorted_sides(const TetMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(4 * mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (int f = 0; f < 4; ++f) {
      Side s{{}, static_cast<Index>(t), false};
      for (int k = 0; k < 3; ++k) {
        s.key[static_cast<std::size_t>(k)] = mesh.tets[t][static_cast<std::size_t>(face_vertex(f, k))];
      }
      const auto order = [&s](std::size_t i, std::size_t j) {
        if (s.key[j] < s.key[i]) {
          std::swap(s.key[i], s.key[j]);
          s.odd = !s.odd;
        }
      };
      order(0, 1);
      order(1, 2);
      order(0, 1);
      sides.push_back(s);
    }
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.key != b.key ? a.key < b.key : a.tet < b.tet; });
  return sides;
}

/// The tetrahedra behind crowded or one-sided faces.
void find_bad_faces(const TetMesh& mesh, Collector& crowded, Collector& same_side, Collector& duplicates) {
  const std::vector<Side> sides = sorted_sides(mesh);
  std::vector<Index> in_crowd;
  std::vector<Index> one_sided;
  std::vector<Index> twice;
  const auto sorted_vertices = [&mesh](Index t) {
    auto v = mesh.tets[static_cast<std::size_t>(t)];
    std::sort(v.begin(), v.end());
    return v;
  };
  std::vector<std::pair<std::array<Index, 4>, Index>> there;  // at one face; all tetrahedra may be at one
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].key == sides[i].key) ++end;
    there.clear();
    for (std::size_t j = i; j < end; ++j) there.emplace_back(sorted_vertices(sides[j].tet), sides[j].tet);
    std::sort(there.begin(), there.end());
    for (std::size_t j = 1; j < there.size(); ++j) {
      if (there[j].first == there[j - 1].first && there[j].second != there[j - 1].second)
        twice.push_back(there[j].second);
    }
    if (end - i > 2) {
      for (std::size_t j = i; j < end; ++j) in_crowd.push_back(sides[j].tet);
    } else if (end - i == 2 && sides[i].odd == sides[i + 1].odd) {
      one_sided.push_back(sides[i + 1].tet);
    }
    i = end;
  }
  const auto give = [](std::vector<Index>& ids, Collector& to) {
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    for (const Index id : ids) to.add(id);
  };
  give(twice, duplicates);
  give(in_crowd, crowded);
  give(one_sided, same_side);
}

/// For each tetrahedron whether to turn it, so that neighbours list their common face in opposite senses and each
/// connected part has a positive volume in all. Where no choice does that, neighbours are left as they disagree.
std::vector<std::uint8_t> turns_to_orient(const TetMesh& mesh) {
  const std::vector<Side> sides = sorted_sides(mesh);
  struct Across {
    Index tet = -1;
    bool opposed = false;  ///< the two list the face in opposite senses, as they should
  };
  std::vector<std::array<Across, 4>> across(mesh.tets.size());
  std::vector<std::uint8_t> degree(mesh.tets.size(), 0);
  const auto link = [&](const Side& from, const Side& to) {
    const auto t = static_cast<std::size_t>(from.tet);
    across[t][degree[t]++] = {to.tet, from.odd != to.odd};
  };
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].key == sides[i].key) ++end;
    if (end - i == 2) {
      link(sides[i], sides[i + 1]);
      link(sides[i + 1], sides[i]);
    }
    i = end;
  }
  constexpr std::uint8_t kUnseen = 2;
  std::vector<std::uint8_t> turned(mesh.tets.size(), kUnseen);
  std::vector<Index> part;
  const double scale = unit_scale(mesh);
  for (std::size_t seed = 0; seed < turned.size(); ++seed) {
    if (turned[seed] != kUnseen) continue;
    turned[seed] = 0;
    part.assign(1, static_cast<Index>(seed));
    double volume = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const auto t = static_cast<std::size_t>(part[i]);
      const auto p = [&](std::size_t k) { return scale * vec(mesh.points[static_cast<std::size_t>(mesh.tets[t][k])]); };
      const double v = dot(cross(p(1) - p(0), p(2) - p(0)), p(3) - p(0));
      volume += turned[t] != 0 ? -v : v;
      for (int f = 0; f < degree[t]; ++f) {
        const Across& a = across[t][static_cast<std::size_t>(f)];
        std::uint8_t& there = turned[static_cast<std::size_t>(a.tet)];
        if (there != kUnseen) continue;
        there = a.opposed ? turned[t] : 1 - turned[t];
        part.push_back(a.tet);
      }
    }
    if (volume >= 0) continue;
    for (const Index t : part) turned[static_cast<std::size_t>(t)] ^= 1;
  }
  return turned;
}

}  // namespace

const char* to_string(Defect defect) {
  switch (defect) {
    case Defect::index_out_of_range:
      return "index out of range";
    case Defect::bad_array_length:
      return "array of the wrong length";
    case Defect::not_finite:
      return "coordinate that is not a finite number";
    case Defect::repeated_vertex:
      return "the same vertex twice in one tetrahedron";
    case Defect::inverted_tet:
      return "inverted tetrahedra (negative volume)";
    case Defect::flat_tet:
      return "flat tetrahedra (zero volume)";
    case Defect::tiny_tet:
      return "tetrahedra too small beside the largest coordinate to compute with";
    case Defect::duplicate_tet:
      return "tetrahedra listed twice";
    case Defect::face_on_three_tets:
      return "tetrahedra at a face that three or more share";
    case Defect::same_side_of_face:
      return "tetrahedra on the same side of a face as their neighbour";
  }
  return "unknown";
}

std::string ValidationReport::message(bool one_based) const {
  std::string text = "the mesh is not valid:";
  bool repairable = true;
  for (const Finding& f : findings) {
    text += "\n  " + std::string(to_string(f.defect)) + " in " + f.where + ": " + std::to_string(f.count) +
            first_ids(f.first, one_based);
    if (f.place) {
      const auto number = [](double x) {
        char digits[32];
        std::snprintf(digits, sizeof digits, "%.6g", x);
        return std::string(digits);
      };
      text += ", the first near " + number((*f.place)[0]) + " " + number((*f.place)[1]) + " " + number((*f.place)[2]);
    }
    repairable = repairable && (f.defect == Defect::inverted_tet || f.defect == Defect::flat_tet);
  }
  return text + (repairable
                     ? "\n  untangle them (tetune optimize --untangle), or repair the mesh in the program that made it."
                     : "\n  repair or remove these in the program that made the mesh.");
}

ValidationReport validate_counts(const ArrayCounts& counts) {
  ValidationReport report;
  const auto check = [&report](std::size_t entries, Index most, const std::string& where) {
    if (entries <= static_cast<std::size_t>(most)) return;
    report.findings.push_back({Defect::bad_array_length,
                               static_cast<std::int64_t>(entries),
                               {},
                               where + " (there can be " + std::to_string(most) + ")"});
  };
  check(counts.vertices, kMaxEntries, "vertices");
  check(counts.tets, kMaxTets, "tetrahedra");
  check(counts.triangles, kMaxEntries, "triangles");
  check(counts.edges, kMaxEntries, "edges");
  check(counts.others, kMaxEntries, "elements of other kinds");
  return report;
}

ValidationReport validate_arrays(const TetMesh& mesh) {
  const std::size_t vertices = mesh.points.size();
  ArrayCounts counts{vertices, mesh.tets.size(), mesh.triangles.size(), mesh.edges.size()};
  for (const ElementBlock& block : mesh.others) counts.others += block.tags.size();
  ValidationReport report = validate_counts(counts);
  if (!report.ok()) return report;
  check_length(mesh.point_tags.size(), vertices, "vertex tags", report);
  check_length(mesh.tet_tags.size(), mesh.tets.size(), "tetrahedron tags", report);
  check_length(mesh.triangle_tags.size(), mesh.triangles.size(), "triangle tags", report);
  check_length(mesh.edge_tags.size(), mesh.edges.size(), "edge tags", report);
  check_elements(mesh.tets, vertices, "tetrahedra", report);
  check_elements(mesh.triangles, vertices, "triangles", report);
  check_elements(mesh.edges, vertices, "edges", report);
  check_indices(mesh.corners, vertices, 1, "corners", report);
  check_indices(mesh.required_vertices, vertices, 1, "required vertices", report);
  check_indices(mesh.ridges, mesh.edges.size(), 1, "ridges", report);
  check_indices(mesh.required_edges, mesh.edges.size(), 1, "required edges", report);
  check_indices(mesh.required_triangles, mesh.triangles.size(), 1, "required triangles", report);
  check_indices(mesh.required_tets, mesh.tets.size(), 1, "required tetrahedra", report);
  for (const ElementBlock& block : mesh.others) {
    const auto each = static_cast<std::size_t>(std::max(1, block.vertices_per_element));
    if (block.vertices_per_element < 1) {
      report.findings.push_back(
          {Defect::bad_array_length, block.vertices_per_element, {}, "vertices of " + block.kind});
    }
    check_length(block.tags.size() * each, block.element2vertex.size(), block.kind, report);
    check_indices(block.element2vertex, vertices, each, block.kind, report);
    check_indices(block.required, block.tags.size(), 1, "required " + block.kind, report);
    check_data(block.data, block.tags.size(), block.kind, report);
  }
  check_data(mesh.point_data, vertices, "vertices", report);
  check_data(mesh.tet_data, mesh.tets.size(), "tetrahedra", report);
  check_data(mesh.triangle_data, mesh.triangles.size(), "triangles", report);
  check_data(mesh.edge_data, mesh.edges.size(), "edges", report);
  // Zero times what is not finite is not a number.
  double zero = 0;
  for (const Point3& p : mesh.points) zero += 0 * p[0] + 0 * p[1] + 0 * p[2];
  if (zero == 0) return report;
  Collector not_finite(Defect::not_finite, "vertices");
  for (std::size_t v = 0; v < vertices; ++v) {
    const Point3& p = mesh.points[v];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
      not_finite.add(static_cast<std::int64_t>(v));
    }
  }
  not_finite.finish(report);
  return report;
}

ValidationReport validate(const TetMesh& mesh, int threads) {
  ValidationReport report = validate_arrays(mesh);
  if (!report.ok()) return report;

  Collector repeated(Defect::repeated_vertex, "tetrahedra");
  Collector inverted(Defect::inverted_tet, "tetrahedra");
  Collector flat(Defect::flat_tet, "tetrahedra");
  Collector tiny(Defect::tiny_tet, "tetrahedra");
  const std::vector<std::int8_t> sign = orient_all(mesh, threads);
  for (std::size_t t = 0; t < sign.size(); ++t) {
    if (sign[t] == 1) continue;
    const auto& v = mesh.tets[t];
    const bool twice = v[0] == v[1] || v[0] == v[2] || v[0] == v[3] || v[1] == v[2] || v[1] == v[3] || v[2] == v[3];
    (twice ? repeated : sign[t] < 0 ? inverted : sign[t] == 0 ? flat : tiny).add(static_cast<std::int64_t>(t));
  }
  repeated.finish(report);
  inverted.finish(report);
  flat.finish(report);
  tiny.finish(report);

  const par::Cpu cpu(threads);
  WorkMesh<par::Cpu> work = upload_mesh<par::Cpu>(mesh);
  const AdjacencyReport adjacency = build_adjacency(cpu, work);
  if (adjacency.crowded_faces + adjacency.same_side_faces > 0) {
    Collector duplicates(Defect::duplicate_tet, "tetrahedra");
    Collector crowded(Defect::face_on_three_tets, "tetrahedra");
    Collector same_side(Defect::same_side_of_face, "tetrahedra");
    find_bad_faces(mesh, crowded, same_side, duplicates);
    duplicates.finish(report);
    crowded.finish(report);
    same_side.finish(report);
  }
  for (Finding& f : report.findings) {
    Point3 centre{};
    for (const Index v : mesh.tets[static_cast<std::size_t>(f.first[0])]) {
      for (std::size_t k = 0; k < 3; ++k) centre[k] += 0.25 * mesh.points[static_cast<std::size_t>(v)][k];
    }
    f.place = centre;
  }
  return report;
}

std::int64_t orient_uniformly(TetMesh& mesh, int threads) {
  if (mesh.tets.empty() || !validate_arrays(mesh).ok()) return 0;
  const std::vector<std::int8_t> sign = orient_all(mesh, threads);
  if (std::find(sign.begin(), sign.end(), -1) == sign.end()) return 0;
  const bool all = *std::max_element(sign.begin(), sign.end()) < 0;
  const std::vector<std::uint8_t> turned = all ? std::vector<std::uint8_t>(mesh.tets.size(), 1) : turns_to_orient(mesh);
  const std::int64_t count = std::count(turned.begin(), turned.end(), 1);
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (turned[t] != 0) std::swap(mesh.tets[t][2], mesh.tets[t][3]);
  }
  if (count == static_cast<std::int64_t>(turned.size())) mesh.listed_inside_out = !mesh.listed_inside_out;
  return count;
}

}  // namespace tetune

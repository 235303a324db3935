// SPDX-License-Identifier: Apache-2.0
#include "tetune/validate.hpp"

#include <algorithm>
#include <cstdio>

#include "backend/cpu.hpp"
#include "mesh/connect.hpp"
#include "mesh/finding_collector.hpp"
#include "mesh/tet_mesh_view.hpp"
#include "mesh/tet_orientation.hpp"
#include "mesh/upload.hpp"
#include "mesh/validate_arrays.hpp"

namespace tetune {
namespace {

using Tet4 = std::array<Index, 4>;

bool has_repeated_vertex(const Tet4& v) {
  return v[0] == v[1] || v[0] == v[2] || v[0] == v[3] || v[1] == v[2] || v[1] == v[3] || v[2] == v[3];
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
  std::sort(tets.begin(), tets.end());
  tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
  FindingCollector finding(defect, "tetrahedra");
  for (const Index t : tets) finding.add(t);
  finding.finish(report);
}

/// Reports the tetrahedra at non-manifold and misoriented faces, and duplicate tetrahedra.
void find_bad_faces(const TetMesh& mesh, ValidationReport& report) {
  std::vector<Index> duplicate;
  std::vector<Index> non_manifold;
  std::vector<Index> misoriented;
  const TetMeshView view(mesh);
  std::vector<std::pair<Tet4, Index>> at_face;  // sorted vertices and id of the tetrahedra at one face
  for_each_face(sorted_half_faces(mesh), [&](auto begin, auto end) {
    at_face.clear();
    for (auto half_face = begin; half_face != end; ++half_face) {
      Tet4 vertices = view.tets[half_face->tet];
      std::sort(vertices.begin(), vertices.end());
      at_face.emplace_back(vertices, half_face->tet);
    }
    std::sort(at_face.begin(), at_face.end());
    for (std::size_t j = 1; j < at_face.size(); ++j) {
      const auto& [vertices, tet] = at_face[j];
      if (vertices == at_face[j - 1].first && tet != at_face[j - 1].second) duplicate.push_back(tet);
    }
    if (end - begin > 2) {
      for (auto half_face = begin; half_face != end; ++half_face) non_manifold.push_back(half_face->tet);
    } else if (end - begin == 2 && begin[0].odd == begin[1].odd) {
      misoriented.push_back(begin[1].tet);
    }
  });
  add_tets(duplicate, Defect::duplicate_tet, report);
  add_tets(non_manifold, Defect::face_on_three_tets, report);
  add_tets(misoriented, Defect::same_side_of_face, report);
}

std::string format_coordinate(double x) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.6g", x);
  return digits;
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
      return "tetrahedra too small for arithmetic at the scale of the largest coordinate";
    case Defect::duplicate_tet:
      return "tetrahedra listed twice";
    case Defect::face_on_three_tets:
      return "tetrahedra at a non-manifold face, which three or more share";
    case Defect::same_side_of_face:
      return "misoriented tetrahedra, on the same side of a face as their neighbor";
  }
  return "unknown";
}

std::string ValidationReport::message(bool one_based) const {
  std::string text = "the mesh is not valid:";
  bool can_be_untangled = true;
  for (const Finding& f : findings) {
    text += "\n  " + std::string(to_string(f.defect)) + " in " + f.where + ": " + std::to_string(f.count) +
            first_ids(f.first, one_based);
    if (f.place) {
      const Point3& p = *f.place;
      text +=
          ", the first near " + format_coordinate(p[0]) + " " + format_coordinate(p[1]) + " " + format_coordinate(p[2]);
    }
    can_be_untangled = can_be_untangled && (f.defect == Defect::inverted_tet || f.defect == Defect::flat_tet);
  }
  return text + (can_be_untangled ? "\n  untangle them (untangle=true), or repair the mesh in the program that made it."
                                  : "\n  repair or remove these in the program that made the mesh.");
}

ValidationReport validate(const TetMesh& mesh, int threads) {
  ValidationReport report = validate_arrays(mesh);
  if (!report.ok()) return report;
  check_volumes(mesh, threads, report);
  const backend::Cpu cpu(threads);
  WorkMesh<backend::Cpu> work = upload_mesh(cpu, mesh);
  if (!build_adjacency(cpu, work).ok()) find_bad_faces(mesh, report);
  for (Finding& f : report.findings) f.place = TetMeshView(mesh).centroid(f.first[0]);
  return report;
}

}  // namespace tetune

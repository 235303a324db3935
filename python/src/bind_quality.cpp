// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <map>
#include <string>

#include "arrays.hpp"
#include "bindings.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {

using namespace nb::literals;
namespace {

template <class T>
std::map<std::string, T> by_measure(const std::array<T, kMeasures>& values) {
  std::map<std::string, T> named;
  for (std::size_t k = 0; k < kMeasures; ++k) named.emplace(to_string(static_cast<Measure>(k)), values[k]);
  return named;
}

void bind_comparison(nb::module_& m) {
  nb::class_<PatchChange>(m, "PatchChange", "Change of the area of the listed triangles of one tag.")
      .def_ro("tag", &PatchChange::tag)
      .def_ro("area_before", &PatchChange::area_before)
      .def_ro("area_change", &PatchChange::area_change, "Relative.");
  nb::class_<Comparison>(
      m, "Comparison",
      "Differences between two meshes of the same shape. Changes are relative, distances in mean edge lengths of the "
      "old boundary.")
      .def_ro("volume_change", &Comparison::volume_change)
      .def_ro("area_change", &Comparison::area_change)
      .def_ro("vertices_to_old", &Comparison::vertices_to_old)
      .def_ro("new_to_old", &Comparison::new_to_old)
      .def_ro("sample_stride", &Comparison::sample_stride)
      .def_ro("mean_edge", &Comparison::mean_edge)
      .def_ro("old_to_new", &Comparison::old_to_new)
      .def_ro("vertex_tags_kept", &Comparison::vertex_tags_kept)
      .def_ro("tet_tags_kept", &Comparison::tet_tags_kept)
      .def_ro("triangle_tags_kept", &Comparison::triangle_tags_kept)
      .def_ro("edge_tags_kept", &Comparison::edge_tags_kept)
      .def_ro("region_volume_change", &Comparison::region_volume_change)
      .def_ro("patch_area_change", &Comparison::patch_area_change)
      .def_ro("patches", &Comparison::patches)
      .def_ro("required_moved", &Comparison::required_moved)
      .def_ro("corners_moved", &Comparison::corners_moved);
}

void bind_curved(nb::module_& m) {
  nb::class_<CurvedTet>(m, "CurvedTet",
                        "Measures of a second-order tetrahedron with a curved edge. Determinants of the Jacobian "
                        "matrix are relative to that of the straight tetrahedron with the same vertices.")
      .def_ro("tet", &CurvedTet::tet)
      .def_prop_ro(
          "validity", [](const CurvedTet& t) { return to_string(t.validity); },
          "\"valid\" or \"inverted\", both proved, or \"undecided\".")
      .def_ro("min_lower", &CurvedTet::min_lower, "Certified lower bound of the smallest determinant.")
      .def_ro("min_upper", &CurvedTet::min_upper, "Certified upper bound of the smallest determinant.")
      .def_ro("max_lower", &CurvedTet::max_lower, "Certified lower bound of the largest determinant.")
      .def_ro("max_upper", &CurvedTet::max_upper, "Certified upper bound of the largest determinant.")
      .def_prop_ro("scaled_jacobian", &CurvedTet::scaled_jacobian, "The smallest one: min_lower.")
      .def_ro("corner_ratio", &CurvedTet::corner_ratio, "Largest determinant over smallest one at the four vertices.")
      .def_ro("integration_ratio", &CurvedTet::integration_ratio,
              "Smallest determinant over largest one at the integration points of C3D10.")
      .def_ro("middle_offset", &CurvedTet::middle_offset,
              "Largest distance of a mid-side node from the midpoint, relative to the edge.")
      .def_ro("centroid", &CurvedTet::centroid);
  nb::class_<CurvedQuality>(m, "CurvedQuality", "The second-order tetrahedra with curved edges of a mesh.")
      .def_ro("curved_edges", &CurvedQuality::curved_edges)
      .def_ro("tets", &CurvedQuality::tets, "Number of tetrahedra with a curved edge.")
      .def_ro("valid", &CurvedQuality::valid)
      .def_ro("inverted", &CurvedQuality::inverted)
      .def_ro("undecided", &CurvedQuality::undecided)
      .def_ro("bad_integration", &CurvedQuality::bad_integration,
              "Number of tetrahedra whose determinant is not positive at an integration point of C3D10.")
      .def_ro("min_scaled_jacobian", &CurvedQuality::min_scaled_jacobian)
      .def_ro("max_corner_ratio", &CurvedQuality::max_corner_ratio)
      .def_ro("max_middle_offset", &CurvedQuality::max_middle_offset)
      .def_prop_ro("all_valid", &CurvedQuality::all_valid)
      .def_ro("worst", &CurvedQuality::worst, "Those of the smallest scaled Jacobian, the smallest first.");
  nb::class_<CurveReport>(m, "CurveReport", "The account of curve().")
      .def_ro("curved_edges", &CurveReport::curved_edges)
      .def_ro("curved_tets", &CurveReport::curved_tets)
      .def_ro("not_valid_before", &CurveReport::not_valid_before,
              "Number of tetrahedra that the curved surface alone makes not valid.")
      .def_ro("vertices_moved", &CurveReport::vertices_moved, "Number of inner vertices that moved for that.")
      .def_ro("min_scaled_jacobian", &CurveReport::min_scaled_jacobian)
      .def_ro(
          "edges_off_geometry", &CurveReport::edges_off_geometry,
          "With geometry: number of edges of the surface that stay straight, because it is not clear what they are on.")
      .def_ro("straightened", &CurveReport::straightened);
  m.def(
      "curve",
      [](TetMesh& mesh, double feature_angle, int threads, const TetMesh* surface, const Geometry* geometry) {
        return curve(mesh, CurveOptions{feature_angle, threads, surface, geometry, {}});
      },
      "mesh"_a, nb::kw_only(), "feature_angle"_a = 45.0, "threads"_a = 0, "surface"_a.none() = nb::none(),
      "geometry"_a.none() = nb::none(), nb::call_guard<nb::gil_scoped_release>());
  m.def("measure_curved_each", &measure_curved_each, "mesh"_a, nb::kw_only(), "threads"_a = 0,
        nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace

void bind_quality(nb::module_& m) {
  bind_curved(m);
  nb::class_<MeasureSummary>(m, "MeasureSummary", "One measure over a mesh.")
      .def_ro("min", &MeasureSummary::min)
      .def_ro("p1", &MeasureSummary::p1, "1 % of the tetrahedra are as bad as this or worse.")
      .def_ro("p5", &MeasureSummary::p5, "5 % of the tetrahedra are as bad as this or worse.")
      .def_ro("mean", &MeasureSummary::mean)
      .def_ro("max", &MeasureSummary::max);
  nb::class_<WorstTet>(m, "WorstTet", "One of the worst tetrahedra.")
      .def_ro("tet", &WorstTet::tet)
      .def_ro("dihedral", &WorstTet::dihedral, "Its smallest dihedral angle, degrees.")
      .def_ro("harmonic", &WorstTet::harmonic, "Its q_h.")
      .def_ro("centroid", &WorstTet::centroid);
  nb::class_<Quality>(m, "Quality", "Element quality of a whole mesh. Angles in degrees.")
      .def_ro("tets", &Quality::tets, "Number of tetrahedra.")
      .def_ro("dihedral_min", &Quality::dihedral_min, "Smallest dihedral angle.")
      .def_ro("dihedral_p1", &Quality::dihedral_p1, "1 % of all dihedral angles are smaller.")
      .def_ro("dihedral_p5", &Quality::dihedral_p5, "5 % of all dihedral angles are smaller.")
      .def_ro("dihedral_1", &Quality::dihedral_p1, "The former name of dihedral_p1, until version 0.3.")
      .def_ro("dihedral_5", &Quality::dihedral_p5, "The former name of dihedral_p5, until version 0.3.")
      .def_ro("dihedral_mean", &Quality::dihedral_mean)
      .def_ro("dihedral_max", &Quality::dihedral_max)
      .def_ro("eta_max", &Quality::eta_max)
      .def_ro("eta_95", &Quality::eta_95)
      .def_ro("eta_sum", &Quality::eta_sum, "Sum of the harmonic index, a length.")
      .def_ro("shape_sum", &Quality::shape_sum, "Sum of the shape energy: the number of tetrahedra if all are regular.")
      .def_ro("mean_ratio", &Quality::mean_ratio, "Mean of the mean ratio: 1 if all are regular.")
      .def_ro("mean_ratio_min", &Quality::mean_ratio_min)
      .def_ro("volume", &Quality::volume)
      .def_ro("histogram", &Quality::histogram, "Share of dihedral angles in each of 18 bins of 10 degrees.")
      .def_prop_ro(
          "measures", [](const Quality& q) { return by_measure(q.measures); }, "Each measure by its name.")
      .def_ro("curved", &Quality::curved, "The second-order tetrahedra with curved edges.")
      .def_ro("worst", &Quality::worst, "The tetrahedra of smallest dihedral angle, the worst first.")
      .def("__repr__", [](const Quality& q) {
        char text[160];
        std::snprintf(text, sizeof text,
                      "<tetune.Quality: %lld tetrahedra, dihedral angles %.2f to %.2f degrees, mean ratio %.4f>",
                      static_cast<long long>(q.tets), q.dihedral_min, q.dihedral_max, q.mean_ratio);
        return std::string(text);
      });
  bind_comparison(m);
}

}  // namespace tetune::python

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

}  // namespace

void bind_quality(nb::module_& m) {
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

// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <utility>

#include "arrays.hpp"
#include "bindings.hpp"
#include "options.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {
namespace {

/// A numpy array of f(entity) per vertex.
template <class F>
nb::object per_vertex(const GeometryMatch& match, const F& f) {
  auto* values = new std::vector<std::int32_t>;
  for (const GeometryEntity& entity : match.vertices) values->push_back(f(entity));
  return nb::cast(view(*values, owner_of(values)));
}

GeometryReport improve_on_geometry(TetMesh& mesh, const Geometry& geometry, const nb::dict& options, bool snap,
                                   nb::object progress) {
  const Options parsed = parse_options(options);
  const Context context = context_of(std::move(progress));
  GeometryReport report =
      without_gil([&] { return optimize_on_geometry(mesh, geometry, parsed, {.snap = snap}, context); });
  warn(report.optimization.warnings);
  return report;
}

void load_geometry(Geometry* place, const std::filesystem::path& file, double unit, int threads) {
  const nb::gil_scoped_release release;
  new (place) Geometry(file_name(file), unit, threads);
}

constexpr const char* kGeometry = R"(The exact surface of a part: a STEP, IGES or BREP file, read by OpenCASCADE.

`file`: its name (.step, .stp, .iges, .igs, .brep, .brp); `unit`: the length of the mesh's unit in mm; `threads`: 0 for
all cores. Raises FileError where the file cannot be read, or tetune was built without OpenCASCADE, and OptionError
where the unit or the number of threads is out of its range.)";

void bind_match(nb::module_& m) {
  nb::class_<GeometryMatch>(m, "GeometryMatch", "How the surface of a mesh corresponds to a CAD model.")
      .def_prop_ro(
          "dimensions",
          [](const GeometryMatch& match) {
            return per_vertex(match, [](const GeometryEntity& e) { return std::int32_t{e.dimension}; });
          },
          nb::sig("def dimensions(self) -> NDArray[numpy.int32]"),
          "Per vertex of the mesh: 0, 1 or 2 at a vertex, edge or face of the model; 3 inside; -1 where it is not "
          "clear.")
      .def_prop_ro(
          "numbers",
          [](const GeometryMatch& match) {
            return per_vertex(match, [](const GeometryEntity& e) { return e.number; });
          },
          nb::sig("def numbers(self) -> NDArray[numpy.int32]"),
          "Per vertex: the number of that vertex, edge or face, from 1 in the order of the model; else 0.")
      .def_prop_ro(
          "distances", [](nb::handle_t<GeometryMatch> s) { return view(nb::cast<GeometryMatch&>(s).distances, s); },
          nb::sig("def distances(self) -> NDArray[numpy.float64]"),
          "Per vertex: its distance from its entity, or from the nearest face; 0 inside.")
      .def_prop_ro(
          "triangles", [](nb::handle_t<GeometryMatch> s) { return view(nb::cast<GeometryMatch&>(s).triangles, s); },
          nb::sig("def triangles(self) -> NDArray[numpy.int32]"), "The triangles of the surface, of shape (n, 3).")
      .def_prop_ro(
          "faces", [](nb::handle_t<GeometryMatch> s) { return view(nb::cast<GeometryMatch&>(s).faces, s); },
          nb::sig("def faces(self) -> NDArray[numpy.int32]"),
          "Per triangle: the number of its face, 0 where it is not clear or there is none.")
      .def_ro("on_entities", &GeometryMatch::on_entities, "Numbers of vertices at vertices, edges and faces.")
      .def_ro("without_entity", &GeometryMatch::without_entity, "Number of vertices of the surface without an entity.")
      .def_ro("ambiguous_triangles", &GeometryMatch::ambiguous_triangles,
              "Number of triangles of which it is not clear which face they are on.")
      .def_ro("file_surfaces", &GeometryMatch::file_surfaces, "Number of surfaces of an .msh file.")
      .def_ro("file_surfaces_differing", &GeometryMatch::file_surfaces_differing,
              "Number of surfaces of an .msh file that are not on the face of the same number.")
      .def_ro("unmatched_vertices", &GeometryMatch::unmatched_vertices,
              "Number of the model's vertices at which the mesh has no vertex.");
}

void bind_deviation(nb::module_& m) {
  nb::class_<DistanceSummary>(m, "DistanceSummary", "Distances of a set of points from the geometry.")
      .def_ro("points", &DistanceSummary::points, "Their number.")
      .def_ro("largest", &DistanceSummary::largest)
      .def_ro("mean", &DistanceSummary::mean);
  nb::class_<GeometryDeviation::Face>(m, "FaceDeviation", "Distances of the triangles of one face of a CAD model.")
      .def_ro("number", &GeometryDeviation::Face::number, "From 1, in the order of the model.")
      .def_ro("vertices", &GeometryDeviation::Face::vertices)
      .def_ro("midpoints", &GeometryDeviation::Face::midpoints, "Of edges.")
      .def_ro("centers", &GeometryDeviation::Face::centers, "Of triangles.");
  nb::class_<GeometryDeviation>(m, "GeometryDeviation", "Distances of a mesh's surface from a CAD model.")
      .def_ro("vertices", &GeometryDeviation::vertices)
      .def_ro("midpoints", &GeometryDeviation::midpoints, "Of edges.")
      .def_ro("centers", &GeometryDeviation::centers, "Of triangles.")
      .def_ro("faces", &GeometryDeviation::faces, "Those with triangles, in increasing order.");
}

void bind_report_of_geometry(nb::module_& m) {
  nb::class_<GeometryReport>(m, "GeometryReport", "The account of a run of optimize() on a CAD model.")
      .def_ro("optimization", &GeometryReport::optimization, "The account of the whole run.")
      .def_ro("before", &GeometryReport::before, "Of the input.")
      .def_ro("after", &GeometryReport::after, "Of the result.")
      .def_ro("deviation_before", &GeometryReport::deviation_before)
      .def_ro("deviation_after", &GeometryReport::deviation_after)
      .def_ro("snapped", &GeometryReport::snapped,
              "The part of the way onto the geometry that the vertices of the input were moved first.")
      .def_ro("vertices_snapped", &GeometryReport::vertices_snapped,
              "Number of vertices that were not on the geometry.")
      .def_ro("rounds", &GeometryReport::rounds, "Number of rounds of sliding whose result was taken.")
      .def_ro("vertices_held", &GeometryReport::vertices_held,
              "Number of vertices that stayed where they were, because elements would be inverted or worse otherwise.")
      .def_ro("vertices_left_off", &GeometryReport::vertices_left_off,
              "Number of vertices off the geometry that required entities, frozen parts or other elements held there.")
      .def_ro("largest_left_off", &GeometryReport::largest_left_off, "The largest distance of these.");
}

}  // namespace

void bind_geometry(nb::module_& m) {
  bind_match(m);
  bind_deviation(m);
  nb::class_<Geometry>(m, "Geometry", kGeometry)
      .def("__init__", &load_geometry, "file"_a, "unit"_a = 1.0, "threads"_a = 0,
           nb::sig("def __init__(self, file: str | os.PathLike[str], unit: float = 1.0, threads: int = 0) -> None"))
      .def_prop_ro("file", &Geometry::file)
      .def_prop_ro("counts", &Geometry::counts, "Numbers of vertices, edges, faces and solids.")
      .def_prop_ro("low", &Geometry::low, "Of the bounding box, in the mesh's unit.")
      .def_prop_ro("high", &Geometry::high, "Likewise.")
      .def("match", &Geometry::match, "mesh"_a, "tolerance"_a = Geometry::kGeometryTolerance,
           nb::call_guard<nb::gil_scoped_release>(),
           "Finds the vertex, edge or face of the model that each vertex of a TetMesh's surface is on, by distances up "
           "to `tolerance` times the mean length of the edges there. Raises MeshError where mesh and geometry do not "
           "belong together.");
  bind_report_of_geometry(m);
  m.def(
      "improve_on_geometry", &improve_on_geometry, "mesh"_a, "geometry"_a, "options"_a, "snap"_a = true,
      "progress"_a = nb::none(),
      nb::sig("def improve_on_geometry(mesh: TetMesh, geometry: Geometry, options: dict[str, Any], snap: bool = True, "
              "progress: Callable[[Progress], object] | None = None) -> GeometryReport"),
      "Improves a mesh in place on a CAD model, which invalidates views of its arrays.");
}

}  // namespace tetune::python

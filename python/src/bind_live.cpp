// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <utility>

#include "arrays.hpp"
#include "bindings.hpp"
#include "options.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {
namespace {

using namespace nb::literals;

void set_points(LiveMesh& live, const std::vector<Index>& vertices, nb::object points) {
  std::vector<Point3> positions;
  assign("points", std::move(points), positions);
  live.set_points(vertices, positions);
}

Report optimize_live(LiveMesh& live, bool all, nb::object progress) {
  const Context context = context_of(std::move(progress));
  Report report = without_gil([&] { return all ? live.optimize_all(context) : live.optimize(context); });
  warn(report.warnings);
  return report;
}

MoveReport move_live(LiveMesh& live, nb::object target, nb::object progress) {
  VertexTargets parsed;
  assign("to", std::move(target), parsed);
  const Context context = context_of(std::move(progress));
  MoveReport report = without_gil([&] { return live.move(parsed, context); });
  warn(report.optimization.warnings);
  return report;
}

/// A copy of an array of the mesh: the next step may move that in memory.
template <class T>
nb::object copy_of(const std::vector<T>& values) {
  auto* copy = new std::vector<T>(values);
  return nb::cast(view(*copy, owner_of(copy)));
}

}  // namespace

void bind_live(nb::module_& m) {
  nb::class_<LiveMesh>(m, "LiveMesh")
      .def(
          "__init__",
          [](LiveMesh* place, const TetMesh& mesh, const nb::dict& options, int neighborhood) {
            new (place) LiveMesh(mesh, parse_options(options), neighborhood);
          },
          "mesh"_a, "options"_a, "neighborhood"_a,
          nb::sig("def __init__(self, mesh: TetMesh, options: dict[str, Any], neighborhood: int) -> None"))
      .def("set_points", &set_points, "vertices"_a, "points"_a)
      .def("optimize", &optimize_live, "all"_a, "progress"_a.none())
      .def("move", &move_live, "to"_a, "progress"_a.none())
      .def_prop_ro("mesh", [](const LiveMesh& live) { return TetMesh(live.mesh()); })
      .def_prop_ro(
          "points", [](const LiveMesh& live) { return copy_of(live.mesh().points); },
          nb::sig("def points(self) -> NDArray[numpy.float64]"))
      .def_prop_ro(
          "tets", [](const LiveMesh& live) { return copy_of(live.mesh().tets); },
          nb::sig("def tets(self) -> NDArray[numpy.int32]"))
      .def_prop_ro("disturbed", &LiveMesh::disturbed);
}

}  // namespace tetune::python

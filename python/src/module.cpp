// SPDX-License-Identifier: Apache-2.0
// tetune._core: the library's types and functions. The public package is in python/tetune/*.py.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <exception>
#include <map>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "options.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {

void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw nb::python_error();
}

void warn(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) warn(text);
}

Context context_of(nb::object progress) {
  Context context;
  context.progress = [progress](const Progress& p) {
    const nb::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (progress.is_none()) return true;
    const nb::object answer = progress(p);
    return answer.is_none() || nb::cast<bool>(nb::bool_(answer));
  };
  // Passes over a large mesh take seconds: signals are handled at safe points too.
  context.stop = [] {
    const nb::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    return false;
  };
  return context;
}

namespace {

Report improve(TetMesh& mesh, const nb::dict& options, nb::object progress) {
  const Options parsed = parse_options(options);
  const Context context = context_of(std::move(progress));
  Report report = without_gil([&] { return optimize(mesh, parsed, context); });
  warn(report.warnings);
  return report;
}

MoveReport move_mesh(TetMesh& mesh, const nb::list& targets, const nb::dict& options, nb::object progress) {
  std::vector<VertexTargets> parsed;
  for (const nb::handle target : targets) assign("targets", target, parsed.emplace_back());
  const Options parsed_options = parse_options(options);
  const Context context = context_of(std::move(progress));
  MoveReport report = without_gil([&] { return move(mesh, parsed, parsed_options, context); });
  warn(report.optimization.warnings);
  return report;
}

nb::object surface_targets_of(const TetMesh& mesh, nb::object points, const std::vector<int>& patches) {
  std::vector<Point3> positions;
  assign("points", std::move(points), positions);
  auto* targets = new VertexTargets(without_gil([&] { return surface_targets(mesh, positions, patches); }));
  return nb::cast(view(*targets, owner_of(targets)));
}

nb::dict measures_by_name(const TetMesh& mesh, int threads) {
  std::array<std::vector<double>, kMeasures> columns;
  {
    const nb::gil_scoped_release release;
    const std::vector<Measures> each = measure_each(mesh, threads);
    for (std::size_t k = 0; k < kMeasures; ++k) {
      columns[k].resize(each.size());
      for (std::size_t t = 0; t < each.size(); ++t) columns[k][t] = each[t][k];
    }
  }
  nb::dict result;
  for (std::size_t k = 0; k < kMeasures; ++k) {
    auto* column = new std::vector<double>(std::move(columns[k]));
    const nb::capsule owner = owner_of(column);
    result[to_string(static_cast<Measure>(k))] = nb::cast(view(*column, owner));
  }
  return result;
}

/// One row per entry.
using Entries = nb::ndarray<nb::ro, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

DataArray data_array(const Entries& from) {
  DataArray array{"", static_cast<int>(from.shape(1)), {}};
  const auto copy = [&]<class T>(T) {
    const T* data = static_cast<const T*>(from.data());
    array.values = std::vector<T>(data, data + from.size());
  };
  if (from.dtype() == nb::dtype<double>()) {
    copy(double{});
  } else if (from.dtype() == nb::dtype<float>()) {
    copy(float{});
  } else if (from.dtype() == nb::dtype<std::int32_t>()) {
    copy(std::int32_t{});
  } else {
    throw nb::type_error("data must be float64, float32 or int32");
  }
  return array;
}

/// A numpy array of the shape (entries, components) that takes over the values.
nb::object numpy_array(DataArray&& array) {
  return std::visit(
      [&array]<class T>(std::vector<T>& values) {
        auto* kept = new std::vector<T>(std::move(values));
        const nb::capsule owner = owner_of(kept);
        const auto components = static_cast<std::size_t>(array.components);
        return nb::cast(
            nb::ndarray<nb::numpy, T, nb::ndim<2>>(kept->data(), {kept->size() / components, components}, owner));
      },
      array.values);
}

/// The arrays as data of a mesh.
std::vector<DataArray> data_arrays(const std::vector<Entries>& data) {
  std::vector<DataArray> arrays;
  for (const Entries& entries : data) arrays.push_back(data_array(entries));
  return arrays;
}

nb::list numpy_arrays(std::vector<DataArray>&& data) {
  nb::list result;
  for (DataArray& array : data) result.append(numpy_array(std::move(array)));
  return result;
}

nb::list carry(const TetMesh& mesh, nb::object vertex2original, const std::vector<Entries>& data) {
  std::vector<Index> original;
  assign("vertex2original", vertex2original, original);
  std::vector<DataArray> arrays = data_arrays(data);
  arrays = without_gil([&] { return carry_point_data(arrays, original, mesh.points, mesh.tets); });
  return numpy_arrays(std::move(arrays));
}

nb::tuple conserve(const TetMesh& before, const TetMesh& after, const Report& report,
                   const std::vector<Entries>& point_data, const std::vector<Entries>& tet_data, int threads) {
  TetMesh input;
  input.point_data = data_arrays(point_data);
  input.tet_data = data_arrays(tet_data);
  ConservedData data;
  {
    const nb::gil_scoped_release release;
    input.points = before.points;
    input.tets = before.tets;
    input.tet_tags = before.tet_tags;
    data = conserve_data(input, after.tets, report.tet2original, report.places, threads);
  }
  return nb::make_tuple(numpy_arrays(std::move(data.point_data)), numpy_arrays(std::move(data.tet_data)));
}

void bind_errors(nb::module_& m) {
  const nb::exception<Error> error(m, "Error");
  error.doc() = "Base of all exceptions of tetune. The message says what is wrong, where, and what to do.";
  nb::exception<FileError>(m, "FileError", error).doc() = "A file cannot be read or written.";
  const nb::exception<MeshError> mesh_error(m, "MeshError", error);
  mesh_error.doc() = "A mesh breaks the contract of validate().";
  nb::exception<UntangleError>(m, "UntangleError", mesh_error).doc() =
      "The option untangle could not make every volume positive, or every second-order element valid.";
  const nb::exception<CurvedError> curved_error(m, "CurvedError", mesh_error);
  curved_error.doc() = "Second-order elements are not proved valid, and the option untangle is not set.";
  nb::exception<OverlapError>(m, "OverlapError", mesh_error).doc() =
      "The mesh overlaps itself, and flips there would make faces that three or more tetrahedra share.";
  nb::exception<OptionError>(m, "OptionError", error).doc() =
      "An option is out of its range, or names a tag that no element has.";
  nb::exception<DeviceError>(m, "DeviceError", error).doc() = "A device is absent, unusable or out of memory.";
  // The message names the function of Python.
  nb::register_exception_translator(
      [](const std::exception_ptr& thrown, void* type) {
        try {
          std::rethrow_exception(thrown);
        } catch (const CurvedError& e) {
          const std::string text = e.message(false) + " measure_curved_each() measures them.";
          PyErr_SetString(static_cast<PyObject*>(type), text.c_str());
        }
      },
      curved_error.ptr());
}

void bind_functions(nb::module_& m) {
  m.def("improve", &improve, "mesh"_a, "options"_a, "progress"_a = nb::none(),
        nb::sig("def improve(mesh: TetMesh, options: dict[str, Any], progress: Callable[[Progress], object] | None = "
                "None) -> Report"),
        "Improves a mesh in place, which invalidates views of its arrays.");
  m.def("move", &move_mesh, "mesh"_a, "targets"_a, "options"_a, "progress"_a = nb::none(),
        nb::sig("def move(mesh: TetMesh, targets: list[NDArray[numpy.float64]], options: dict[str, Any], progress: "
                "Callable[[Progress], object] | None = None) -> MoveReport"),
        "Moves a mesh in place, which invalidates views of its arrays.");
  m.def("surface_targets", &surface_targets_of, "mesh"_a, "points"_a, "patches"_a = std::vector<int>(),
        nb::sig("def surface_targets(mesh: TetMesh, points: NDArray[numpy.float64], patches: Sequence[int] = ...) -> "
                "NDArray[numpy.float64]"),
        "The positions `points` for the vertices of the surface and those that lists hold, or of listed triangles with "
        "one of the tags `patches`; NaN for the others.");
  m.def(
      "measure_all", [](const TetMesh& mesh, int threads, int worst) { return measure_all(mesh, threads, worst); },
      "mesh"_a, nb::kw_only(), "threads"_a = 0, "worst"_a = 10, nb::call_guard<nb::gil_scoped_release>());
  m.def(
      "carry_point_data", &carry, "mesh"_a, "vertex2original"_a, "data"_a,
      nb::sig("def carry_point_data(mesh: TetMesh, vertex2original: NDArray[numpy.int32], "
              "data: Sequence[NDArray[Any]]) -> list[NDArray[Any]]"),
      "Transfers data of vertices to a mesh with inserted ones, which get means of float64 and float32, and the values "
      "of the nearest vertex of int32. Each array has two dimensions.");
  m.def(
      "conserve_data", &conserve, "before"_a, "after"_a, "report"_a, "point_data"_a, "tet_data"_a, "threads"_a = 0,
      nb::sig("def conserve_data(before: TetMesh, after: TetMesh, report: Report, point_data: Sequence[NDArray[Any]], "
              "tet_data: Sequence[NDArray[Any]], threads: int = 0) -> tuple[list[NDArray[Any]], list[NDArray[Any]]]"),
      "Transfers data of vertices and tetrahedra to the result of a run with data='conserve': float64 and float32 keep "
      "their integrals. Each array has two dimensions.");
  m.def("measure_each", &measures_by_name, "mesh"_a, nb::kw_only(), "threads"_a = 0,
        nb::sig("def measure_each(mesh: TetMesh, *, threads: int = 0) -> dict[str, NDArray[numpy.float64]]"));
  m.def(
      "compare",
      [](const TetMesh& before, const TetMesh& after, int threads, std::int64_t max_samples) {
        return compare(before, after, threads, max_samples);
      },
      "before"_a, "after"_a, nb::kw_only(), "threads"_a = 0, "max_samples"_a = 0,
      nb::call_guard<nb::gil_scoped_release>(),
      "Compares two meshes of the same shape: volume, surface, tags. Distances between the surfaces are measured at "
      "about `max_samples` points of each, or with 0 at all vertices, midpoints and centroids.");
  m.def(
      "validate",
      [](const TetMesh& mesh, int threads) {
        const nb::gil_scoped_release release;
        const ValidationReport report = validate(mesh, threads);
        return report.ok() ? std::string() : report.message(false);
      },
      "mesh"_a, nb::kw_only(), "threads"_a = 0,
      "The defects of a mesh, in words: one line per kind, with the first offenders. Empty for a mesh that optimize() "
      "accepts.");
}

}  // namespace

NB_MODULE(_core, m) {
  nb::set_leak_warnings(false);  // VTK releases arrays, and with them meshes, after the interpreter has ended
  bind_errors(m);
  bind_live(m);
  bind_mesh(m);
  bind_quality(m);
  bind_criteria(m);
  bind_report(m);
  bind_geometry(m);
  bind_functions(m);
  bind_files(m);
}

}  // namespace tetune::python

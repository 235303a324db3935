// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {

namespace nb = nanobind;
using namespace nb::literals;
namespace {

TetMesh read_file(const std::filesystem::path& path, int threads) {
  std::vector<std::string> warnings;
  TetMesh mesh = without_gil([&] { return read_mesh(file_name(path), &warnings, threads); });
  warn(warnings);
  return mesh;
}

void write_file(const std::filesystem::path& path, const TetMesh& mesh, int threads) {
  std::vector<std::string> warnings;
  without_gil([&] { write_mesh(file_name(path), mesh, threads, &warnings); });
  warn(warnings);
}

std::vector<std::pair<double, std::string>> read_times(const std::filesystem::path& path) {
  const std::string name = file_name(path);
  if (has_times(name)) {
    throw FileError(name + ": this is not a .pvd file; `tetune move` reads the times of Exodus files");
  }
  std::vector<std::pair<double, std::string>> steps;
  for (SeriesStep& step : read_series(name)) steps.emplace_back(step.time, std::move(step.path));
  return steps;
}

void write_times(const std::filesystem::path& path,
                 const std::vector<std::pair<double, std::filesystem::path>>& steps) {
  std::vector<SeriesStep> listed;
  for (const auto& [time, file] : steps) listed.push_back({time, file_name(file)});
  write_series(file_name(path), listed);
}

constexpr const char* kReadMesh = R"(Reads a mesh in the format that the ending of the name says (docs/formats.md).

MEDIT (.mesh, .meshb), Gmsh (.msh), TetGen (.ele, .node, .face), decks of Abaqus and CalculiX (.inp), SU2 (.su2),
Netgen (.vol, .vol.gz), Nastran (.bdf, .nas) and universal files of I-deas (.unv) are built in. VTK (.vtu, .pvtu, .vtk)
and Exodus (.e, .ex2, .exo) need a tetune that was built with VTK, or, for the files of VTK, pyvista or meshio; MED and
CGNS (.med, .cgns) need one that was built with Gmsh.

`threads`: 0 for all cores. Warns of each part of the file that is not kept, and where tetrahedra were reversed. Raises
FileError where the file cannot be read, or is damaged; the message says where, and what to do.)";

constexpr const char* kWriteMesh = R"(Writes a mesh in the format that the ending of the name says: those of read_mesh()
except .pvtu.

The file is written under a temporary name and renamed once complete: where that fails, an old file is unchanged.

`path`: for TetGen the name of one of its files; `threads`: 0 for all cores. Warns of each part of the mesh that the
format cannot hold. Raises FileError where the format is unknown or cannot hold the elements, the mesh has indices that
do not exist, or the file cannot be written.)";

constexpr const char* kReadSeries =
    R"(Reads a time series of VTK (.pvd): the times, which increase, and a file for each.
The meshes themselves are not read; their names are relative to the current folder.

Raises FileError where the file cannot be read, is not such a series, lists no file, or several for one time.)";

constexpr const char* kWriteSeries =
    R"(Writes a time series of VTK (.pvd): times and the file of each, by names from the
current folder. The series appears as a whole or not at all.

Raises FileError where the file cannot be written, the list is empty, or the times do not increase.)";

}  // namespace

void bind_files(nb::module_& m) {
  m.def("read_series", &read_times, "path"_a,
        nb::sig("def read_series(path: str | os.PathLike[str]) -> list[tuple[float, str]]"), kReadSeries);
  m.def("write_series", &write_times, "path"_a, "steps"_a,
        nb::sig("def write_series(path: str | os.PathLike[str], steps: Sequence[tuple[float, str | os.PathLike[str]]]) "
                "-> None"),
        kWriteSeries);
  m.def("read_mesh", &read_file, "path"_a, nb::kw_only(), "threads"_a = 0,
        nb::sig("def read_mesh(path: str | os.PathLike[str], *, threads: int = 0) -> TetMesh"), kReadMesh);
  m.def("write_mesh", &write_file, "path"_a, "mesh"_a, nb::kw_only(), "threads"_a = 0,
        nb::sig("def write_mesh(path: str | os.PathLike[str], mesh: TetMesh, *, threads: int = 0) -> None"),
        kWriteMesh);
}

}  // namespace tetune::python

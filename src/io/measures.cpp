// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <iterator>

#include "io/registry.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"
#include "tetune/quality.hpp"

namespace tetune {
namespace {

/// Returns the mesh with its measures as data on tetrahedra.
TetMesh with_measures(TetMesh mesh, const std::vector<Measures>& measures) {
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const std::string name = to_string(Measure(k));
    std::erase_if(mesh.tet_data, [&name](const DataArray& array) { return array.name == name; });
    std::vector<double> values(measures.size());
    for (std::size_t t = 0; t < values.size(); ++t) values[t] = measures[t][k];
    mesh.tet_data.push_back({name, 1, std::move(values)});
  }
  return mesh;
}

}  // namespace

void write_measures(const std::string& path, const TetMesh& mesh, int threads, std::vector<std::string>* warnings) {
  constexpr const char* kWithData[] = {".vtu", ".vtk", ".e", ".ex2", ".exo", ".msh"};
  const std::string ending = std::filesystem::path(path).extension().string();
  const bool with_mesh = std::find(std::begin(kWithData), std::end(kWithData), ending) != std::end(kWithData);
  if (!with_mesh && ending != ".sol") {
    throw FileError(path +
                    ": measures are written as a MEDIT solution (.sol), or with the mesh as .vtu, .vtk, .e or .msh");
  }
  if (with_mesh) {
    check_writable(path);
    return write_mesh(path, with_measures(mesh, measure_each(mesh, threads)), threads, warnings);
  }
  check_place(path);
  const std::vector<Measures> measures = measure_each(mesh, threads);
  FileWriter file(path);
  write_medit_solution(file, measures, threads);
  file.commit();
}

}  // namespace tetune

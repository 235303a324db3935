// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tetune/context.hpp"
#include "tetune/mesh.hpp"
#include "tetune/move.hpp"
#include "tetune/report.hpp"
#include "tetune/targets.hpp"

/// The parts of the module tetune._core.
namespace tetune::python {

/// Issues a UserWarning.
void warn(const std::string& text);
/// Issues a UserWarning for each text.
void warn(const std::vector<std::string>& texts);

/// Returns f(), which is called without the GIL.
template <class F>
auto without_gil(const F& f) {
  const nanobind::gil_scoped_release release;
  return f();
}

/// The name of a file for the library, of an argument that is a str or os.PathLike.
inline std::string file_name(const std::filesystem::path& path) {
  const auto name = path.u8string();
  return {name.begin(), name.end()};
}

/// The hooks of a run: calls `progress`, a function or None, with the GIL held, after Python's handlers of signals
/// (Ctrl-C).
Context context_of(nanobind::object progress);

/// The numbers of elements that constraints hold, by their names; without zeros.
std::map<std::string, std::int64_t> by_constraint(const std::array<std::int64_t, kLimitingConstraints>& held_by);

/// Makes objects of a class picklable, for the same version.
void bind_state(nanobind::class_<TetMesh>& type);
void bind_state(nanobind::class_<Report>& type);
void bind_state(nanobind::class_<MoveReport>& type);

void bind_criteria(nanobind::module_& m);
void bind_files(nanobind::module_& m);
void bind_geometry(nanobind::module_& m);
void bind_live(nanobind::module_& m);
void bind_mesh(nanobind::module_& m);
void bind_quality(nanobind::module_& m);
void bind_report(nanobind::module_& m);

}  // namespace tetune::python

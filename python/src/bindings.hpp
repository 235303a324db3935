// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "tetune/context.hpp"

/// The parts of the module tetune._core.
namespace tetune::python {

/// Issues a UserWarning.
void warn(const std::string& text);

/// The hooks of a run: calls `progress`, a function or None, with the GIL held, after Python's handlers of signals
/// (Ctrl-C).
Context context_of(nanobind::object progress);

void bind_criteria(nanobind::module_& m);
void bind_live(nanobind::module_& m);
void bind_mesh(nanobind::module_& m);
void bind_quality(nanobind::module_& m);
void bind_report(nanobind::module_& m);

}  // namespace tetune::python

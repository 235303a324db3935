// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <string>

/// The parts of the module tetune._core.
namespace tetune::python {

/// Issues a UserWarning.
void warn(const std::string& text);

void bind_mesh(nanobind::module_& m);
void bind_quality(nanobind::module_& m);
void bind_report(nanobind::module_& m);

}  // namespace tetune::python

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include "tetune/optimize.hpp"

namespace tetune::python {

namespace nb = nanobind;
using namespace nb::literals;

/// Parses options by their names in C++, and choices by their names as strings. Raises TypeError for an unknown name,
/// and OptionError for an invalid value.
Options parse_options(const nb::dict& given);

}  // namespace tetune::python

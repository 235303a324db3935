// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include "tetune/optimize.hpp"

namespace tetune::python {

namespace nb = nanobind;
using namespace nb::literals;

/// Options by their C++ names; names of values as strings. Throws TypeError for a name that is none, OptionError for a
/// value that is none.
Options parse_options(const nb::dict& given);

}  // namespace tetune::python

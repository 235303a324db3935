// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace tetune::cli {

/// Throws OptionError: `feature` is a part of the Python package, whose `tetune` handles it before it runs this
/// program.
[[noreturn]] void need_python(const std::string& feature);

}  // namespace tetune::cli

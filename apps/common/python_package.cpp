// SPDX-License-Identifier: Apache-2.0
#include "python_package.hpp"

#include "tetune/error.hpp"

namespace tetune::cli {

void need_python(const std::string& feature) {
  throw OptionError(
      feature +
      " is part of the Python package: pip install '.[report]' in a clone of tetune, then run the tetune that this "
      "installs, or python -m tetune");
}

}  // namespace tetune::cli

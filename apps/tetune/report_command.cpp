// SPDX-License-Identifier: Apache-2.0
// The page is made by the Python package, whose `tetune` catches `report` and `--report-html` before this program sees
// them: here stands what there is, and how to get it.
#include "commands.hpp"
#include "tetune/error.hpp"

namespace tetune::cli {

void need_python(const std::string& what) {
  throw OptionError(
      what +
      " is part of the Python package: pip install 'tetune[report]' (in a clone: pip install '.[report]'), "
      "then run the tetune that this installs, or python -m tetune");
}

void add_report(CLI::App& app) {
  CLI::App* c = app.add_subcommand(
      "report",
      "One HTML page that shows a mesh before and after, in figures and in 3D: tetune report IN OUT -o FILE.html "
      "(needs the Python package).");
  c->prefix_command();
  c->callback([] { need_python("report"); });
}

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#include "commands.hpp"
#include "python_package.hpp"

namespace tetune::cli {

void add_report(CLI::App& app) {
  CLI::App* c = app.add_subcommand(
      "report",
      "One HTML page that shows a mesh before and after, in figures and in 3D: tetune report IN OUT -o FILE.html "
      "(needs the Python package).");
  c->prefix_command();
  c->callback([] { need_python("report"); });
}

}  // namespace tetune::cli

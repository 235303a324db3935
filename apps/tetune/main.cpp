// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <algorithm>
#include <exception>
#include <new>

#include "commands.hpp"
#include "option_values.hpp"
#include "tetune/error.hpp"
#include "tetune/version.hpp"

int main(int argc, char** argv) {
  using namespace tetune::cli;
  CLI::App app{"tetune makes a tetrahedral mesh better: harmonic flips and vertex relocation, boundary kept.",
               "tetune"};
  app.set_version_flag("--version", "tetune " TETUNE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done; 1 stopped early or a target was missed, a valid mesh was written (of info and compare: the "
      "mesh is not valid); 2 nothing was written.");
  int exit_code = kDone;
  add_optimize(app, exit_code);
  add_info(app, exit_code);
  add_compare(app, exit_code);
  try {
    std::vector<std::string> words = without_aliases(argc, argv);
    std::reverse(words.begin(), words.end());  // as CLI11 wants them
    app.parse(std::move(words));
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kDone : kNothingWritten;
  } catch (const tetune::Error& e) {
    fmt::print(stderr, "tetune: {}\n", e.what());
    return kNothingWritten;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "tetune: out of memory\n");
    return kNothingWritten;
  } catch (const std::exception& e) {
    fmt::print(stderr, "tetune: {}\n", e.what());
    return kNothingWritten;
  }
  return exit_code;
}

// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include "aliases.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "tetune/error.hpp"
#include "tetune/version.hpp"

namespace {

/// What CLI11 says of a command line, as the other messages are.
std::string failure(const CLI::App* app, const CLI::Error& e) {
  const std::vector<CLI::App*> command = app->get_subcommands();
  return fmt::format("tetune: {}; see tetune{} --help\n", e.what(),
                     command.empty() ? "" : " " + command[0]->get_name());
}

/// Options of optimize with which it writes no mesh.
constexpr std::array kSays{"--help", "--print-options", "--dry-run"};

/// Where a standard stream is closed, a file would get its number, and what is said would get into the file.
void occupy_standard_streams() {
  int descriptor = 0;
  while (descriptor >= 0 && descriptor <= STDERR_FILENO) descriptor = ::open("/dev/null", O_RDONLY);
  ::close(descriptor);
}

int run(int argc, char** argv) {
  using namespace tetune::cli;
  CLI::App app{"tetune makes a tetrahedral mesh better: harmonic flips and vertex relocation, boundary kept.",
               "tetune"};
  app.set_version_flag("--version", "tetune " TETUNE_VERSION);
  app.require_subcommand(1);
  app.failure_message(failure);
  app.footer(
      "Exit codes: 0 done; 1 stopped early or a target was missed, a valid mesh was written (of info and compare: the "
      "mesh has no tetrahedron, is not valid, or not of the quality asked for; --untangle could not repair all: no "
      "mesh "
      "was written); 2 "
      "nothing was written. Of several meshes, the largest.");
  int exit_code = kDone;
  add_optimize(app, exit_code);
  add_info(app, exit_code);
  add_compare(app, exit_code);
  add_report(app);
  add_completion(app);
  add_man(app);
  try {
    std::vector<std::string> words = without_aliases(app, argc, argv);
    std::reverse(words.begin(), words.end());  // as CLI11 wants them
    app.parse(std::move(words));
  } catch (const CLI::ParseError& e) {
    exit_code = app.exit(e) == 0 ? kDone : kNothingWritten;
  } catch (const tetune::Error& e) {
    say(stderr, fmt::format("tetune: {}\n", e.what()));
    return kNothingWritten;
  } catch (const std::bad_alloc&) {
    say(stderr, "tetune: out of memory\n");
    return kNothingWritten;
  } catch (const std::exception& e) {
    say(stderr, fmt::format("tetune: {}\n", e.what()));
    return kNothingWritten;
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    say(stderr, fmt::format("tetune: cannot write standard output: {}\n", std::strerror(errno)));
    // Of optimize the mesh counts, where one was written.
    const CLI::App* optimize = app.get_subcommand("optimize");
    const bool only_said = !optimize->parsed() || std::any_of(kSays.begin(), kSays.end(), [&](const char* name) {
      return optimize->count(name) > 0;
    });
    if (only_said) exit_code = kNothingWritten;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  occupy_standard_streams();
  try {
    return run(argc, argv);
  } catch (...) {  // no memory, not even to say so
    return tetune::cli::kNothingWritten;
  }
}

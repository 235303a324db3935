// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include "aliases.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "exit_code.hpp"
#include "system/process.hpp"
#include "tetune/version.hpp"

namespace {

/// Whether `--progress json` is among the arguments, which may not be valid otherwise.
bool wants_json(const std::vector<std::string>& arguments) {
  const auto option = std::find(arguments.begin(), arguments.end(), "--progress");
  return std::find(arguments.begin(), arguments.end(), "--progress=json") != arguments.end() ||
         (option != arguments.end() && option + 1 != arguments.end() && option[1] == "json");
}

/// An error of CLI11 in the words of the other messages.
std::string message_of(const CLI::App& app, const CLI::Error& e) {
  std::string text = e.what();
  const std::string subject = text.substr(0, text.find(':'));
  const auto says = [&text](const char* words) { return text.find(words) != std::string::npos; };
  if (says(" required ") && says(" missing")) text = subject + ": the value is missing";
  if (says("At Most 1 required")) text = subject + " is given more than once";
  if (says("not expected: ")) text = "too many arguments" + text.substr(subject.size());
  const std::vector<CLI::App*> command = app.get_subcommands();
  return fmt::format("{}; see tetune{} --help", text, command.empty() ? "" : " " + command[0]->get_name());
}

/// Options of optimize and move with which they only print.
constexpr std::array kPrintOnly{"--help", "--print-options", "--dry-run"};

int run(const std::vector<std::string>& arguments) {
  using namespace tetune::cli;
  CLI::App app{"tetune improves a tetrahedral mesh by harmonic flips and vertex relocation, and keeps its boundary.",
               "tetune"};
  app.set_version_flag("--version", "tetune " TETUNE_VERSION);
  app.allow_windows_style_options(false);  // a name may start with /
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0: success. 1: a valid mesh was written, but the run stopped early, missed a target or a criterion, "
      "or could not write a report, trace or map. 1 also: --untangle failed, and no mesh was written; info, compare: "
      "the mesh is empty or not valid, or misses --min-quality or a criterion. 2: nothing was written. Of several "
      "meshes, the largest.");
  Console errors(wants_json(arguments) ? ProgressMode::json : ProgressMode::none, 0, nullptr);
  const auto fail = [&errors, start = std::chrono::steady_clock::now()](const std::string& text) {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    errors.error(text);
    errors.event(end_event("", "failed", kNothingWritten, seconds.count()));
    return int(kNothingWritten);
  };
  int exit_code = kDone;
  add_optimize(app, exit_code);
  add_convert(app, exit_code);
  add_move(app, exit_code);
  add_info(app, exit_code);
  add_compare(app, exit_code);
  add_report(app);
  add_completion(app);
  add_man(app);
  try {
    std::vector<std::string> words = expand_aliases(app, arguments);
    std::reverse(words.begin(), words.end());  // CLI11 expects them in reverse
    app.parse(std::move(words));
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) {
      return fail(message_of(app, e));
    }
    exit_code = app.exit(e);  // prints the help or the version
  } catch (const std::bad_alloc&) {
    return fail("out of memory");
  } catch (const std::exception& e) {
    return fail(e.what());
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    print_to(stderr, fmt::format("tetune: cannot write standard output: {}\n", std::strerror(errno)));
    // A mesh that was written is a success.
    const auto wrote_mesh = [&app](const char* name) {
      const CLI::App* c = app.get_subcommand(name);
      return c->parsed() && std::none_of(kPrintOnly.begin(), kPrintOnly.end(),
                                         [c](const char* option) { return c->count(option) > 0; });
    };
    const bool only_printed = !wrote_mesh("optimize") && !wrote_mesh("move");
    if (only_printed) exit_code = kNothingWritten;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  tetune::process::prepare_standard_streams();
  try {
    return run(tetune::process::arguments(argc, argv));
  } catch (...) {  // not enough memory even for a message
    return tetune::cli::kNothingWritten;
  }
}

// SPDX-License-Identifier: Apache-2.0
// The command line of `tetune optimize`, one word per line: it is accepted, or refused with a message. No mesh is read.
#include <algorithm>
#include <string>
#include <vector>

#include "aliases.hpp"
#include "fuzz.hpp"
#include "optimize_arguments.hpp"
#include "option_flags.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tetune;
  const std::string_view text = fuzz::text(data, size);
  if (text.find('\0') != std::string_view::npos) return 0;  // words of a command line end at one
  std::vector<std::string> lines{"tetune", "optimize"};
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.emplace_back(text.substr(at, end - at));
    at = end + 1;
  }
  std::vector<const char*> argv;
  for (const std::string& line : lines) argv.push_back(line.c_str());

  CLI::App app;
  cli::OptimizeArguments arguments;
  CLI::App* command = app.add_subcommand("optimize");
  cli::define_arguments(*command, arguments);
  try {
    std::vector<std::string> words = cli::expand_aliases(app, static_cast<int>(argv.size()), argv.data());
    std::reverse(words.begin(), words.end());
    app.parse(std::move(words));
    cli::resolve_jobs(*command, arguments);
    cli::to_json(arguments.options);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0 && std::string_view(e.what()).empty()) std::abort();
  } catch (const Error& e) {
    if (std::string_view(e.what()).empty()) std::abort();
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "aliases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <numeric>
#include <utility>

#include "definitions.hpp"
#include "tetune/error.hpp"

namespace tetune::cli {
namespace {

struct Alias {
  const char* name;
  const char* value;  ///< what follows it, for the manual
  std::vector<std::string> ours;
};

const std::vector<Alias>& aliases() {
  static const std::vector<Alias> list{
      {"-ar", " A", {"--feature-angle"}},
      {"-nr", "", {"--feature-angle", "180"}},
      {"-hausd", " D", {"--max-deviation"}},
      {"-nosurf", "", {"--boundary", "fixed"}},
      {"-noswap", "", {"--no-flips"}},
      {"-nomove", "", {"--max-iterations", "0"}},
      {"-noinsert", "", {"--keep-vertices"}},
      {"-opnbdy", "", {"--open-boundaries"}},
      {"-nt", " N", {"--threads"}},
      {"-val", "", {"--print-options"}},
      {"-out", " FILE", {"--output"}},
      {"-in", " FILE", {}},
      {"-optim", "", {}},
  };
  return list;
}

/// Mmg's that say how it works inside, or what it does beside optimising: nothing here corresponds.
constexpr const char* kForeign[] = {"-octree", "-lag", "-nreg", "-xreg", "-rmc", "-nsd", "-3dMedit"};

/// Mmg's that change sizes or shape.
constexpr const char* kSizes[] = {"-hmax", "-hmin",     "-hsiz", "-hgrad", "-hgradreq", "-sol",
                                  "-met",  "-optimLES", "-A",    "-ls",    "-lssurf",   "-nosizreq"};

bool is_integer(const std::string& word) {
  const std::size_t sign = !word.empty() && word[0] == '-' ? 1 : 0;
  return word.size() > sign && std::all_of(word.begin() + static_cast<std::ptrdiff_t>(sign), word.end(),
                                           [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// "-effort=best" as "--effort=best", where there is such an option.
std::string with_two_dashes(const CLI::App& command, const std::string& word) {
  if (word.size() < 3 || word[0] != '-' || std::isalpha(static_cast<unsigned char>(word[1])) == 0) return word;
  const std::string longer = "-" + word;
  return command.get_option_no_throw(longer.substr(0, longer.find('='))) != nullptr ? longer : word;
}

/// The number of characters to change, add or leave out.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t other = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, other}));
    }
  }
  return row.back();
}

/// Refuses an option that is none, and says which one may be meant.
void check_name(const CLI::App& command, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  const std::size_t typos = std::min<std::size_t>(3, name.size() / 3);
  if (!word.starts_with("--") || word == "--" || command.get_option_no_throw(name) != nullptr) return;
  std::string nearest;
  std::size_t least = typos + 1;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& known : names_of(*option)) {
      const std::size_t d = distance(name, known);
      if (d >= least || !known.starts_with("--")) continue;
      least = d;
      nearest = known;
    }
  }
  throw OptionError(fmt::format("{}: there is no such option{}; see tetune{}{} --help", name,
                                nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest),
                                command.get_name() == "tetune" ? "" : " ",
                                command.get_name() == "tetune" ? "" : command.get_name()));
}

}  // namespace

std::vector<std::string> without_aliases(const CLI::App& app, int argc, const char* const* argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  const std::vector<const CLI::App*> commands = commands_of(app);
  const auto at = std::find_if(commands.begin(), commands.end(),
                               [&](const CLI::App* c) { return !words.empty() && words[0] == c->get_name(); });
  if (at == commands.end()) {
    if (!words.empty() && words[0].starts_with("-")) {
      check_name(app, words[0]);
      return words;
    }
    std::string known;
    for (const CLI::App* c : commands) known += (known.empty() ? "" : ", ") + c->get_name();
    throw OptionError(fmt::format("{}; there are {}: to improve a mesh, tetune optimize IN OUT",
                                  words.empty() ? "no command" : "'" + words[0] + "' is not a command", known));
  }
  const CLI::App* command = *at;
  std::vector<std::string> ours{words[0]};
  bool is_value = false;  // of the option before it
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (std::exchange(is_value, false)) {
      ours.push_back(word);
      continue;
    }
    if (word == "--") {  // no options after it
      ours.insert(ours.end(), words.begin() + static_cast<std::ptrdiff_t>(i), words.end());
      break;
    }
    if (words[0] == "optimize") {
      const auto known =
          std::find_if(aliases().begin(), aliases().end(), [&](const Alias& a) { return word == a.name; });
      if (known != aliases().end()) {
        ours.insert(ours.end(), known->ours.begin(), known->ours.end());
        is_value = *known->value != '\0';
        continue;
      }
      const auto is_one_of = [&word](const auto& names) {
        return std::any_of(std::begin(names), std::end(names),
                           [&](const char* name) { return word == name || word == std::string("-") + name; });
      };
      if (is_one_of(kForeign))
        throw OptionError(word + ": nothing in tetune corresponds to this option of Mmg; drop it");
      if (is_one_of(kSizes)) {
        throw OptionError(word +
                          ": tetune keeps the sizes of the elements that it is given, and has no control of sizes, "
                          "metrics or level sets; drop the option, or have Mmg make the sizes first");
      }
    }
    ours.push_back(with_two_dashes(*command, word));
    // Those of the Python package are not known here.
    if (!command->get_prefix_command()) check_name(*command, ours.back());
    if (ours.back().size() > 2 && ours.back().starts_with("-h")) {
      throw OptionError(word + ": there is no such option; see tetune " + words[0] + " --help");
    }
    const CLI::Option* option = word[0] == '-' ? command->get_option_no_throw(ours.back()) : nullptr;
    is_value = option != nullptr && takes_value(*option);
    // Mmg's -v alone.
    if (word == "-v" && (i + 1 == words.size() || !is_integer(words[i + 1]))) {
      ours.emplace_back("5");
      is_value = false;
    }
  }
  return ours;
}

std::vector<std::pair<std::string, std::string>> alias_table() {
  std::vector<std::pair<std::string, std::string>> table;
  for (const Alias& a : aliases()) {
    std::string text;
    for (const std::string& word : a.ours) text += (text.empty() ? "" : " ") + word;
    table.emplace_back(std::string(a.name) + a.value, (text.empty() ? "nothing: so it is anyway" : text + a.value));
  }
  return table;
}

}  // namespace tetune::cli

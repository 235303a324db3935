// SPDX-License-Identifier: Apache-2.0
#include "aliases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "definitions.hpp"
#include "tetune/error.hpp"

namespace tetune::cli {
namespace {

/// An option of Mmg.
struct Alias {
  const char* name;
  const char* value;               ///< placeholder, for the manual; empty: it has none
  std::vector<std::string> words;  ///< of tetune
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

/// Options of Mmg about its algorithms or tasks other than optimization.
constexpr std::array kForeign{"-octree", "-lag", "-nreg", "-xreg", "-rmc", "-nsd", "-3dMedit"};

/// Options of Mmg that change sizes or shape.
constexpr std::array kSizes{"-hmax", "-hmin",     "-hsiz", "-hgrad", "-hgradreq", "-sol",
                            "-met",  "-optimLES", "-A",    "-ls",    "-lssurf",   "-nosizreq"};

bool is_integer(const std::string& word) {
  const std::string_view digits = std::string_view(word).substr(word.starts_with('-') ? 1 : 0);
  return !digits.empty() && digits.find_first_not_of("0123456789") == std::string_view::npos;
}

bool is_number(const std::string& word) {
  double value = 0;
  return CLI::detail::lexical_cast(word, value);
}

/// Adds the second dash to "-effort=best", if the command has such an option.
std::string with_two_dashes(const CLI::App& command, const std::string& word) {
  if (word.size() < 3 || word[0] != '-' || std::isalpha(static_cast<unsigned char>(word[1])) == 0) return word;
  const std::string longer = "-" + word;
  return command.get_option_no_throw(longer.substr(0, longer.find('='))) != nullptr ? longer : word;
}

/// The command that the first word names; null if that is an option of the program itself. Throws OptionError.
const CLI::App* find_command(const CLI::App& app, const std::vector<std::string>& words) {
  const std::vector<const CLI::App*> commands = commands_of(app);
  std::string known;
  for (const CLI::App* c : commands) {
    if (!words.empty() && words[0] == c->get_name()) return c;
    known += (known.empty() ? "" : ", ") + c->get_name();
  }
  if (!words.empty() && words[0].starts_with("-")) {
    check_name(app, words[0], app.get_name());
    return nullptr;
  }
  throw OptionError(fmt::format("{}; the commands are {}. To improve a mesh: tetune optimize IN OUT",
                                words.empty() ? "no command" : "'" + words[0] + "' is not a command", known));
}

/// Throws OptionError for options of Mmg that tetune does not have.
void refuse_foreign(const std::string& word) {
  const auto is_one_of = [&word](const auto& names) {
    return std::any_of(names.begin(), names.end(),
                       [&](const char* name) { return word == name || word == std::string("-") + name; });
  };
  if (is_one_of(kForeign)) {
    throw OptionError(word + ": nothing in tetune corresponds to this option of Mmg; remove it");
  }
  if (is_one_of(kSizes)) {
    throw OptionError(word +
                      ": tetune keeps the sizes of the elements of the input, and has no control of sizes, metrics or "
                      "level sets; remove the option, or let Mmg change the sizes first");
  }
}

}  // namespace

std::vector<std::string> expand_aliases(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* command = find_command(app, words);
  if (command == nullptr) return words;
  std::vector<std::string> expanded{words[0]};
  bool is_value = false;  // of the option before it
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (std::exchange(is_value, false)) {
      expanded.push_back(word);
      continue;
    }
    if (word == "--") {  // no options after it
      while (i < words.size()) expanded.push_back(words[i++]);
      break;
    }
    if (words[0] == "optimize") {
      const auto alias =
          std::find_if(aliases().begin(), aliases().end(), [&](const Alias& a) { return word == a.name; });
      if (alias != aliases().end()) {
        expanded.insert(expanded.end(), alias->words.begin(), alias->words.end());
        is_value = *alias->value != '\0';
        continue;
      }
      refuse_foreign(word);
    }
    if (word == "--target-quality" && i + 2 < words.size() && is_number(words[i + 1])) {
      // The former notation, `--target-quality 0.2 mean_ratio`, accepted until version 0.3.
      expanded.insert(expanded.end(), {word, words[i + 2] + "=" + words[i + 1]});
      i += 2;
      continue;
    }
    expanded.push_back(with_two_dashes(*command, word));
    const std::string& last = expanded.back();
    // Options of the Python package are not known here.
    if (!command->get_prefix_command()) check_name(*command, last, "tetune " + words[0]);
    if (last.size() > 2 && last.starts_with("-h")) {  // CLI11 would print the help
      throw OptionError(word + ": there is no such option; see tetune " + words[0] + " --help");
    }
    const CLI::Option* option = word[0] == '-' ? command->get_option_no_throw(last) : nullptr;
    is_value = option != nullptr && takes_value(*option);
    // Mmg's -v without a value.
    if (word == "-v" && (i + 1 == words.size() || !is_integer(words[i + 1]))) {
      expanded.emplace_back("5");
      is_value = false;
    }
  }
  return expanded;
}

std::vector<std::pair<std::string, std::string>> alias_table() {
  std::vector<std::pair<std::string, std::string>> table;
  for (const Alias& a : aliases()) {
    std::string text;
    for (const std::string& word : a.words) text += (text.empty() ? "" : " ") + word;
    table.emplace_back(std::string(a.name) + a.value, (text.empty() ? "no option: it is the default" : text + a.value));
  }
  return table;
}

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
// Completion scripts for shells, generated from the definitions of the options.
#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "definitions.hpp"
#include "tetune/criteria.hpp"
#include "tetune/geometry.hpp"
#include "tetune/quality.hpp"

namespace tetune::cli {
namespace {

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

/// The text as a single-quoted word of a shell.
std::string in_quotes(const std::string& text) { return "'" + replaced(text, "'", R"('\'')") + "'"; }

/// The first clause of a help text.
std::string short_text(const std::string& text) { return text.substr(0, text.find_first_of(".;:")); }

/// Words that complete the value of an option.
struct Words {
  std::string list;           ///< with blanks between them
  bool has_more = false;      ///< a number follows each, after the = at its end
  bool are_examples = false;  ///< names of files are values too
};

/// The choices of an option, or what its placeholder stands for.
Words words_of(const CLI::Option& option) {
  if (const auto choices = choices_of(option); !choices.empty()) return {CLI::detail::join(choices, " ")};
  const std::string placeholder = option.get_option_text();
  Words words;
  const auto add = [&words](const std::string& word) { words.list += (words.list.empty() ? "" : " ") + word; };
  if (placeholder.ends_with("MEASURE=Q")) {
    words.has_more = true;
    for (std::size_t k = 0; k < kMeasures; ++k) add(std::string(to_string(Measure(k))) + "=");
  } else if (placeholder == "NAME|FILE") {
    words.are_examples = true;
    for (const AcceptanceCriteria& preset : preset_criteria()) add(preset.name);
  } else if (placeholder == "UNIT") {
    for (const LengthUnit& unit : kLengthUnits) add(unit.name);
  }
  return words;
}

std::string names_of(const CLI::App& app) {
  std::string names;
  for (const CLI::App* c : commands_of(app)) names += (names.empty() ? "" : " ") + c->get_name();
  return names;
}

std::string bash(const CLI::App& app) {
  std::string text = fmt::format(
      "# bash completion of tetune; made by: tetune completion bash\n"
      "_tetune() {{\n"
      "  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} choices= files=\n"
      "  COMPREPLY=()\n"
      "  if [[ $COMP_CWORD -eq 1 ]]; then\n"
      "    COMPREPLY=($(compgen -W '{} --help --version' -- \"$word\"))\n"
      "    return\n"
      "  fi\n"
      "  case ${{COMP_WORDS[1]}} in\n",
      names_of(app));
  for (const CLI::App* c : commands_of(app)) {
    std::string all, values;
    std::string positional;
    for (const CLI::Option* o : c->get_options()) {
      const Words words = words_of(*o);
      if (is_positional(*o)) {
        positional = words.list;
        continue;
      }
      const std::vector<std::string> names = cli::names_of(*o);
      all += (all.empty() ? "" : " ") + CLI::detail::join(names, " ");
      if (!words.list.empty()) {
        values += fmt::format("        {}) choices='{}'{} ;;\n", CLI::detail::join(names, "|"), words.list,
                              words.are_examples ? " files=1" : "");
      }
    }
    text += fmt::format(
        "    {})\n      case $before in\n{}        *) [[ $word == -* ]] && choices='{}'{} ;;\n      esac ;;\n",
        c->get_name(), values, all, positional.empty() ? "" : fmt::format(" || choices='{}'", positional));
  }
  return text +
         "  esac\n"
         "  if [[ -n $choices ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$choices\" -- \"$word\"))\n"
         "  fi\n"
         "  [[ -n $choices && -z $files ]] || COMPREPLY+=($(compgen -f -- \"$word\"))\n"
         "  [[ ${COMPREPLY[0]} != *= ]] || compopt -o nospace 2> /dev/null || true\n"
         "}\n"
         "complete -o filenames -F _tetune tetune\n";
}

std::string zsh(const CLI::App& app) {
  std::string commands, cases;
  const auto plain = [](const std::string& text) { return replaced(replaced(text, "[", "("), "]", ")"); };
  for (const CLI::App* c : commands_of(app)) {
    commands += fmt::format("    {}\n", in_quotes(c->get_name() + ":" + short_text(c->get_description())));
    cases += fmt::format("    {})\n      _arguments", c->get_name());
    for (const CLI::Option* o : c->get_options()) {
      const Words words = words_of(*o);
      const std::string action = words.list.empty()   ? "_files"
                                 : words.has_more     ? "{compadd -S \"\" - " + words.list + "}"
                                 : words.are_examples ? "{compadd - " + words.list + "; _files}"
                                                      : "(" + words.list + ")";
      if (is_positional(*o)) {
        cases += " \\\n        " + in_quotes((o->get_expected_max() > 1 ? "*:" : ":") + o->get_name() + ":" + action);
        continue;
      }
      for (const std::string& name : cli::names_of(*o)) {
        std::string spec = "*" + name + "[" + plain(replaced(short_text(o->get_description()), ":", "")) + "]";
        if (takes_value(*o)) spec += ":value:" + action;
        cases += " \\\n        " + in_quotes(spec);
      }
    }
    cases += " ;;\n";
  }
  return "#compdef tetune\n# made by: tetune completion zsh\n"
         "_tetune() {\n"
         "  local -a commands=(\n" +
         commands +
         "  )\n"
         "  if (( CURRENT == 2 )); then\n"
         "    _describe command commands\n"
         "    return\n"
         "  fi\n"
         "  local command=$words[2]\n"
         "  shift words\n"
         "  (( CURRENT-- ))\n"
         "  case $command in\n" +
         cases +
         "  esac\n"
         "}\n"
         "if [[ $funcstack[1] == _tetune ]]; then _tetune \"$@\"; else compdef _tetune tetune; fi\n";
}

std::string fish(const CLI::App& app) {
  std::string text = "# made by: tetune completion fish\n";
  for (const CLI::App* c : commands_of(app)) {
    text += fmt::format("complete -c tetune -n __fish_use_subcommand -f -a {} -d {}\n", c->get_name(),
                        in_quotes(short_text(c->get_description())));
  }
  for (const CLI::App* c : commands_of(app)) {
    const std::string when = fmt::format("complete -c tetune -n '__fish_seen_subcommand_from {}'", c->get_name());
    for (const CLI::Option* o : c->get_options()) {
      const Words words = words_of(*o);
      const std::string no_files = words.are_examples ? "" : " -f";
      const std::string values = words.list.empty() ? "" : no_files + " -a " + in_quotes(words.list);
      if (is_positional(*o)) {
        if (!words.list.empty()) text += when + values + "\n";
        continue;
      }
      text += when;
      for (const std::string& name : o->get_snames()) text += " -s " + name;
      for (const std::string& name : o->get_lnames()) text += " -l " + name;
      if (takes_value(*o)) text += " -r" + values;
      text += " -d " + in_quotes(short_text(o->get_description())) + "\n";
    }
  }
  return text;
}

}  // namespace

void add_completion(CLI::App& app) {
  CLI::App* c = app.add_subcommand("completion", "Print the completion script for a shell.");
  auto shell = std::make_shared<std::string>();
  c->add_option("shell", *shell,
                "bash, zsh or fish. Under share/ of an installation the script is bash-completion/completions/tetune, "
                "zsh/site-functions/_tetune or fish/vendor_completions.d/tetune.fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}))
      ->option_text("bash|zsh|fish");
  c->callback([&app, shell] {
    fmt::print("{}", *shell == "bash" ? bash(app) : *shell == "zsh" ? zsh(app) : fish(app));
  });
}

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/options.hpp"

/// The options of optimize() as data, for programs that offer them to users: command lines, bindings, dialogs.
namespace tetune {

/// A value of an option that is an enumeration.
struct OptionChoice {
  const char* name;  ///< for example "slide"
  int value;         ///< the enumerator
  const char* text;
  const char* old_name = nullptr;  ///< a former name, accepted until version 0.3
};

/// The member of Options that holds an option.
using OptionMember =
    std::variant<bool Options::*, int Options::*, double Options::*, Device Options::*, Boundary Options::*,
                 Energy Options::*, Effort Options::*, Relocation Options::*, Termination Options::*,
                 SurfaceVertices Options::*, DataTransfer Options::*, std::vector<int> Options::*,
                 std::vector<std::uint8_t> Options::*, std::vector<Target> Options::*>;

/// The values that a number may have: at least `min` (or greater, where that is excluded) and at most `max`.
struct OptionRange {
  double min = 0, max = 0;
  bool excludes_min = false;
  const char* unit = "";  ///< for example "degrees"
};

/// A combination of options in which one of them has no effect, or less than it says.
struct OptionCondition {
  bool (*applies)(const Options&);
  const char* text;  ///< the predicate of a sentence: "has no effect with flips=false"
};

/// One option. Texts have no full stop at the end, and write other options as `boundary=slide`.
struct OptionInfo {
  const char* name;  ///< of the member, and of the option in Python and in JSON reports
  OptionMember member;
  const char* group;  ///< heading under which it is listed
  const char* text;
  std::span<const OptionChoice> choices = {};  ///< of an enumeration, in the order in which they are offered
  OptionRange range = {};                      ///< of a number
  std::span<const OptionCondition> ineffective = {};
};

/// All options, in the order in which they are listed.
TETUNE_API std::span<const OptionInfo> option_table();

/// The option of this name, or null.
TETUNE_API const OptionInfo* find_option(std::string_view name);

/// The choice whose name, or former name, is `name`; null if there is none.
TETUNE_API const OptionChoice* find_choice(const OptionInfo& option, std::string_view name);

/// The value of an option as text: "slide", "0.5", "true", "1,2"; targets as "mean_ratio:0.2".
TETUNE_API std::string option_value(const OptionInfo& option, const Options& options);

/// Sets an option to a value in the form of option_value(). Throws OptionError if there is no such option or the text
/// is no value of it; check_options() checks the range.
TETUNE_API void set_option(Options& options, std::string_view name, std::string_view text);

/// The range of a number in words: "3 to 7", "above 0 and at most 180 degrees".
TETUNE_API std::string to_string(const OptionRange& range);

/// Throws OptionError if a value is out of its range or if the options leave nothing to do. optimize() calls it.
TETUNE_API void check_options(const Options& options);

/// One sentence for each option that differs from its default and has no effect, or less than it says, beside the
/// others: "max_ring=5 has no effect with flips=false". optimize() puts them into Report::warnings.
TETUNE_API std::vector<std::string> ineffective_options(const Options& options);

/// The text of the first condition that applies to an option, whatever its value; null if it has its effect.
TETUNE_API const char* why_ineffective(const OptionInfo& option, const Options& options);

}  // namespace tetune

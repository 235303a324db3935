// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <type_traits>

#include "arrays.hpp"
#include "tetune/option_table.hpp"

namespace tetune::python {
namespace {

std::string shown(nb::handle value) { return nb::cast<std::string>(nb::repr(value)); }

[[noreturn]] void refuse(const OptionInfo& option, nb::handle value, const std::string& allowed) {
  throw OptionError(std::string(option.name) + " is " + shown(value) + "; it must be " + allowed);
}

void warn_of_old_name(const OptionInfo& option, const OptionChoice& choice) {
  const std::string text = "'" + std::string(choice.old_name) + "' is the former name of '" + choice.name +
                           "' for the option " + option.name + ", and is accepted until version 0.3";
  if (PyErr_WarnEx(PyExc_DeprecationWarning, text.c_str(), 1) != 0) throw nb::python_error();
}

const OptionChoice& parse_choice(const OptionInfo& option, nb::handle value) {
  if (nb::isinstance<nb::str>(value)) {
    const auto word = nb::cast<std::string>(value);
    if (const OptionChoice* choice = find_choice(option, word)) {
      if (word != choice->name) warn_of_old_name(option, *choice);
      return *choice;
    }
  }
  std::string names;
  for (const OptionChoice& c : option.choices) {
    names += names.empty() ? "'" : ", '";
    names += c.name;
    names += '\'';
  }
  refuse(option, value, "one of " + names);
}

template <class T>
T parse_number(const OptionInfo& option, nb::handle value) {
  T out{};
  if constexpr (std::is_same_v<T, bool>) {
    if (nb::isinstance(value, nb::module_::import_("numpy").attr("bool_"))) return nb::cast<bool>(nb::bool_(value));
  }
  if (nb::try_cast(value, out)) return out;
  refuse(option, value, std::is_same_v<T, bool> ? "a bool" : std::is_integral_v<T> ? "an integer" : "a number");
}

Measure parse_measure(const std::string& name) {
  std::string names;
  for (std::size_t k = 0; k < kMeasures; ++k) {
    const auto measure = static_cast<Measure>(k);
    if (name == to_string(measure)) return measure;
    if (k > 0) names += ", ";
    names += to_string(measure);
  }
  throw OptionError("there is no measure '" + name + "'; the measures are " + names);
}

std::vector<Target> parse_targets(const OptionInfo& option, nb::handle value) {
  if (!nb::isinstance<nb::dict>(value)) refuse(option, value, "a dict, for example {'min_dihedral_deg': 15}");
  std::vector<Target> targets;
  for (const auto& [name, bound] : nb::borrow<nb::dict>(value)) {
    targets.push_back({parse_measure(nb::cast<std::string>(nb::str(name))), parse_number<double>(option, bound)});
  }
  return targets;
}

void set(const OptionInfo& option, Options& options, nb::handle value) {
  const auto parse = [&]<class T>(T Options::*member) {
    T& field = options.*member;
    if constexpr (std::is_enum_v<T>) {
      field = static_cast<T>(parse_choice(option, value).value);
    } else if constexpr (std::is_arithmetic_v<T>) {
      field = parse_number<T>(option, value);
    } else if constexpr (std::is_same_v<T, std::vector<Target>>) {
      field = parse_targets(option, value);
    } else if constexpr (std::is_same_v<T, std::vector<std::uint8_t>>) {  // also of booleans
      const nb::module_ numpy = nb::module_::import_("numpy");
      // Any flag other than 0: 256 and 0.5 as well.
      const nb::object is_set = numpy.attr("not_equal")(numpy.attr("asarray")(value, "dtype"_a = "float64"), 0);
      assign(option.name, is_set.attr("astype")("uint8"), field);
    } else {
      assign(option.name, value, field);
    }
  };
  std::visit(parse, option.member);
}

}  // namespace

Options parse_options(const nb::dict& given) {
  Options options;
  for (const auto& [key, value] : given) {
    const std::string name = nb::cast<std::string>(nb::str(key));
    const OptionInfo* option = find_option(name);
    if (option == nullptr) {
      std::string names;
      for (const OptionInfo& known : option_table()) {
        if (!names.empty()) names += ", ";
        names += known.name;
      }
      throw nb::type_error(("optimize() has no option '" + name + "'; the options are " + names).c_str());
    }
    set(*option, options, value);
  }
  return options;
}

}  // namespace tetune::python

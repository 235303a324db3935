// SPDX-License-Identifier: Apache-2.0
// The parser of criteria files, where toml++ is installed.
#include "criteria_file.hpp"

// Some assertions of toml++ 3.3, which are assumptions of the optimizer without debugging, do not hold for wrong files
// that it refuses a little later.
#define TOML_ENABLE_FORMATTERS 0
// clang-format off
#if __has_include(<toml++/impl/preprocessor.h>)
#include <toml++/impl/preprocessor.h>
#else
#include <toml++/impl/preprocessor.hpp>
#endif
#undef TOML_ASSERT
#undef TOML_ASSERT_ASSUME
#define TOML_ASSERT(expression) static_assert(true)
#define TOML_ASSERT_ASSUME(expression) static_assert(true)
#include <toml++/toml.h>
// clang-format on

#include <algorithm>

#include "nearest_name.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"

namespace tetune::cli {
namespace {

class CriteriaReader {
 public:
  explicit CriteriaReader(std::string path) : path_(std::move(path)) {}

  AcceptanceCriteria read(const std::string& bytes) const {
    const toml::table file = parse(bytes);
    AcceptanceCriteria criteria;
    criteria.name = path_of(path_).filename().string();
    for (const auto& [key, node] : file) {
      const std::string name(key.str());
      const CheckMeasureInfo* measure = find_check_measure(name);
      if (measure == nullptr) {
        refuse(key.source(), "there is no measure '" + name + "'" + measure_suggestion(name));
      }
      if (!node.is_table()) refuse(node.source(), "'" + name + "' must be a table of limits: [" + name + "]");
      criteria.criteria.push_back(criterion(*measure, *node.as_table()));
    }
    if (criteria.criteria.empty()) throw FileError(path_ + ": there is no criterion in this file");
    return criteria;
  }

 private:
  [[noreturn]] void refuse(const toml::source_region& at, const std::string& why) const {
    refuse_line(at.begin.line, why);
  }
  [[noreturn]] void refuse_line(std::ptrdiff_t line, const std::string& why) const {
    throw FileError(path_ + ":" + std::to_string(line) + ": " + why);
  }

  toml::table parse(const std::string& bytes) const {
    // toml++ 3.3 accepts some.
    const auto is_control = [](unsigned char c) {
      return (c < ' ' && c != '\t' && c != '\n' && c != '\r') || c == '\x7f';
    };
    const auto control = std::find_if(bytes.begin(), bytes.end(), is_control);
    if (control != bytes.end()) {
      refuse_line(1 + std::count(bytes.begin(), control, '\n'), "this is not TOML: there is a control character");
    }
    // Names and numbers are ASCII; toml++ 3.3 has undefined behavior at some other characters.
    std::string ascii = bytes;
    std::replace_if(
        ascii.begin(), ascii.end(), [](char c) { return (static_cast<unsigned char>(c) & 0x80U) != 0; }, '?');
    try {
      return toml::parse(ascii, path_);
    } catch (const toml::parse_error& e) {
      refuse(e.source(), "this is not TOML: " + std::string(e.description()));
    }
  }

  AcceptanceCriterion criterion(const CheckMeasureInfo& measure, const toml::table& limits) const {
    AcceptanceCriterion result;
    result.measure = measure.measure;
    result.source = path_;
    for (const auto& [key, node] : limits) {
      const std::string name(key.str());
      const std::optional<double> value = node.value<double>();
      if (name == "source" && node.is_string()) {
        result.source = *node.value<std::string>();
        continue;
      }
      if (name != "warn" && name != "fail" && name != "allowed_percent") {
        refuse(key.source(), "there is no '" + name + "' of a criterion" +
                                 name_suggestion(name, {"warn", "fail", "allowed_percent", "source"}));
      }
      if (!value) refuse(node.source(), "'" + name + "' of " + measure.name + " must be a number");
      if (name == "warn") result.warn = value;
      if (name == "fail") result.fail = value;
      if (name == "allowed_percent") result.allowed_percent = *value;
    }
    try {
      check_criterion(result);
    } catch (const OptionError& e) {
      refuse(limits.source(), e.what());
    }
    return result;
  }

  std::string path_;
};

}  // namespace

AcceptanceCriteria parse_criteria(const std::string& path, const std::string& bytes) {
  return CriteriaReader(path).read(bytes);
}

}  // namespace tetune::cli

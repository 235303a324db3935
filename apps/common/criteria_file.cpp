// SPDX-License-Identifier: Apache-2.0
#include "criteria_file.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "nearest_name.hpp"
#include "system/path.hpp"
#include "tetune/error.hpp"

namespace tetune::cli {
namespace {

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const AcceptanceCriteria& preset : preset_criteria()) names.push_back(preset.name);
  return names;
}

}  // namespace

std::string name_suggestion(const std::string& name, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(name, known);
  std::string list;
  for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
  return (nearest.empty() ? "" : "; did you mean '" + nearest + "'?") + " (known: " + list + ")";
}

std::string measure_suggestion(const std::string& name) {
  std::vector<std::string> names;
  for (const CheckMeasureInfo& measure : check_measures()) names.emplace_back(measure.name);
  return name_suggestion(name, names);
}

std::string criteria_help(const std::string& action) {
  std::string presets;
  for (const std::string& name : preset_names()) presets += (presets.empty() ? "" : ", ") + name;
  return action + " the criteria of a program (" + presets + ") or of a TOML file: exit code 1 if one fails";
}

AcceptanceCriteria read_criteria(const std::string& name) {
  if (const AcceptanceCriteria* preset = find_preset(name)) return *preset;
  std::ifstream file(path_of(name), std::ios::binary);
  std::error_code ignored;
  if (!file || std::filesystem::is_directory(path_of(name), ignored)) {
    throw FileError(name + ": there is no file of this name, and no criteria either" +
                    name_suggestion(name, preset_names()));
  }
  return parse_criteria(name, {std::istreambuf_iterator<char>(file), {}});
}

}  // namespace tetune::cli

// SPDX-License-Identifier: Apache-2.0
#include "limited_names.hpp"

#include <map>
#include <set>
#include <utility>

namespace tetune::plugin {
namespace {

/// The buffers of VTK's legacy reader have 256 characters, with the zero at the end.
constexpr std::size_t kLegacyNames = 255;

/// The number of characters of `text` in a file.
std::size_t written_length(const std::string& text, std::size_t (*length)(char)) {
  std::size_t sum = 0;
  for (const char c : text) sum += length(c);
  return sum;
}

/// The longest start of `text` of at most `most` characters in a file. A character of UTF-8 is not split.
std::string start_of(const std::string& text, std::size_t most, std::size_t (*length)(char)) {
  std::size_t end = 0;
  for (std::size_t used = 0; end < text.size(); ++end) {
    used += length(text[end]);
    if (used > most) break;
  }
  const auto is_inside_character = [&text](std::size_t i) { return i < text.size() && (text[i] & 0xC0) == 0x80; };
  while (end > 0 && is_inside_character(end)) --end;
  return text.substr(0, end);
}

/// VTK's legacy writer replaces blanks, quotation marks, % and bytes that are not ASCII by % and two digits.
std::size_t legacy_length(char c) { return c < 33 || c > 126 || c == '"' || c == '%' ? 3 : 1; }

}  // namespace

void shorten_names(const std::vector<LimitedName>& names, std::size_t (*length)(char), const char* what,
                   Warnings& warnings) {
  std::set<std::string> taken;
  for (const LimitedName& name : names) taken.insert(*name.text);
  std::map<std::pair<std::string, std::size_t>, std::string> long2short;
  for (const LimitedName& name : names) {
    if (written_length(*name.text, length) <= name.most) continue;
    const auto [at, fresh] = long2short.try_emplace({*name.text, name.most});
    if (fresh) {
      std::string& chosen = at->second;
      chosen = start_of(*name.text, name.most, length);
      for (int n = 2; !taken.insert(chosen).second; ++n) {
        const std::string end = "~" + std::to_string(n);
        chosen = start_of(*name.text, name.most - end.size(), length) + end;
      }
      warnings.push_back(std::string("the name of the ") + what + " \"" + *name.text +
                         "\" is longer than the format allows; it is shortened to \"" + chosen + "\"");
    }
    *name.text = at->second;
  }
}

void shorten_names_for_legacy(TetMesh& mesh, Warnings& warnings) {
  std::vector<LimitedName> names{{&mesh.point_tags_name, kLegacyNames}, {&mesh.cell_tags_name, kLegacyNames}};
  const auto add = [&names](std::vector<DataArray>& data) {
    for (DataArray& array : data) names.push_back({&array.name, kLegacyNames});
  };
  for (auto* data : {&mesh.point_data, &mesh.tet_data, &mesh.triangle_data, &mesh.edge_data}) add(*data);
  for (ElementBlock& block : mesh.others) add(block.data);
  shorten_names(names, legacy_length, "data", warnings);
}

}  // namespace tetune::plugin

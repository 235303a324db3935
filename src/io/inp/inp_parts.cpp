// SPDX-License-Identifier: Apache-2.0
#include "io/inp/inp_parts.hpp"

#include <algorithm>
#include <optional>
#include <vector>

#include "io/inp/inp_cursor.hpp"
#include "io/inp/inp_include.hpp"

namespace tetune {
namespace {

/// A part, or an instance of one.
struct InpPart {
  std::string name;  ///< as written
  std::string of;    ///< key of the part; empty for a part itself
  InpPlace where;
  bool has_elements = false;
  bool has_tets = false;
};

bool is_tetrahedron(const InpKeyword& element) {
  using Role = InpElementType::Role;
  const std::string* type = element.find("TYPE");
  const Role role = type == nullptr ? Role::unknown : inp_element_type(inp_name(*type)).role;
  return role == Role::tetrahedron || role == Role::quadratic_tetrahedron;
}

std::vector<InpPart> list_parts(const std::string& deck, std::string_view text) {
  std::vector<InpPart> parts;
  bool is_inside = false;
  for_each_inp_keyword(deck, text, [&](const InpKeyword& keyword, const InpPlace& where) {
    const bool is_instance = keyword.name == "INSTANCE";
    if (is_instance || keyword.name == "PART") {
      const std::string* name = keyword.find("NAME");
      const std::string* of = is_instance ? keyword.find("PART") : nullptr;
      if (name == nullptr || name->empty()) where.fail("*" + keyword.name + " has no NAME");
      parts.push_back({*name, of == nullptr ? std::string() : inp_name(*of), where});
      is_inside = true;
    } else if (keyword.name == "ENDPART" || keyword.name == "ENDINSTANCE") {
      is_inside = false;
    } else if (keyword.name == "ELEMENT" && is_inside) {
      parts.back().has_elements = true;
      parts.back().has_tets |= is_tetrahedron(keyword);
    }
  });
  return parts;
}

/// The part or instance that has the mesh.
const InpPart& find_mesh_part(const std::vector<InpPart>& parts) {
  const InpPart* found = nullptr;
  for (const InpPart& part : parts) {
    if (!part.has_tets) continue;
    if (found != nullptr) {
      part.where.fail("the parts " + found->name + " and " + part.name +
                      " both have tetrahedra; write each of them to a deck of its own");
    }
    found = &part;
  }
  if (found != nullptr) return *found;
  const auto first = std::find_if(parts.begin(), parts.end(), [](const InpPart& part) { return part.has_elements; });
  return first == parts.end() ? parts.front() : *first;
}

}  // namespace

InpParts find_inp_parts(const std::string& deck, std::string_view text) {
  const std::vector<InpPart> parts = list_parts(deck, text);
  if (parts.empty()) return {};
  const InpPart& mesh = find_mesh_part(parts);
  if (!mesh.of.empty()) return {{}, mesh.name};
  InpParts found{inp_name(mesh.name), {}};
  for (const InpPart& instance : parts) {
    if (instance.of != found.part) continue;
    if (!found.instance.empty()) {
      instance.where.fail("the part " + mesh.name + " has several instances, " + found.instance + " and " +
                          instance.name + "; write a deck with one of them");
    }
    found.instance = instance.name;
  }
  return found;
}

InpReferences::InpReferences(const std::string& instance) : instance_(inp_name(instance)) {
  if (!instance.empty()) written_prefix_ = instance + ".";
}

bool InpReferences::is_instance(std::string_view written) const {
  return !instance_.empty() && inp_name(written) == instance_;
}

std::string_view InpReferences::without_instance(std::string_view written, bool& has_instance) const {
  const std::size_t quote = written.starts_with('"') ? written.find('"', 1) : 0;
  const std::size_t point = quote == std::string_view::npos ? quote : written.find('.', quote);
  has_instance = point != std::string_view::npos && is_instance(written.substr(0, point));
  return has_instance ? written.substr(point + 1) : written;
}

std::string InpReferences::key(std::string_view written, bool in_assembly) const {
  bool has_instance = false;
  const std::string_view name = without_instance(written, has_instance);
  const bool is_of_mesh = !instance_.empty() && (has_instance || !in_assembly);
  return (is_of_mesh ? instance_ + "." : std::string()) + inp_name(name);
}

bool InpReferences::parse_label(std::string_view field, bool in_assembly, std::int64_t& label) const {
  bool has_instance = false;
  const std::string_view number = without_instance(field, has_instance);
  return (has_instance || !in_assembly) && parse_inp_integer(number, label);
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tetune {

/// The place of the mesh in a deck of parts and an assembly, as Abaqus/CAE writes it. The mesh is that of one part, or
/// of one instance that has elements of its own; other parts are text.
struct InpParts {
  std::string part;      ///< key of the part that has the mesh; empty: the instance has it
  std::string instance;  ///< its name as written; empty: the part has none
};

/// Finds the part with tetrahedra, or else the first one with elements. `deck`: the path of the deck, `text` its
/// contents; included files are read too. Nothing where there is no part. Throws FileError where several parts have
/// tetrahedra, or where the part with the mesh has several instances.
InpParts find_inp_parts(const std::string& deck, std::string_view text);

/// How the names and numbers of a deck refer to its sets, nodes and elements. In a deck of parts, those of the part
/// that has the mesh have the name of its instance before them in the assembly and in steps, as in Part-1-1.Set-1 and
/// Part-1-1.17; other numbers there are those of nodes and elements of the assembly itself.
class InpReferences {
 public:
  InpReferences() = default;
  explicit InpReferences(const std::string& instance);

  /// The text before the number of a node or element in the assembly; empty in a deck without parts.
  const std::string& written_prefix() const { return written_prefix_; }
  /// Whether a name is that of the instance.
  bool is_instance(std::string_view written) const;
  /// The key of a set by its name in the assembly or in the part.
  std::string key(std::string_view written, bool in_assembly) const;
  /// Reads the number of a node or element of the mesh; returns false for other fields.
  bool parse_label(std::string_view field, bool in_assembly, std::int64_t& label) const;

 private:
  /// The part of a name behind that of the instance; all of it where it does not begin with that.
  std::string_view without_instance(std::string_view written, bool& has_instance) const;

  std::string instance_;        ///< its key
  std::string written_prefix_;  ///< with the point
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/file.hpp"
#include "tetune/mesh.hpp"
#include "tetune/quality.hpp"

namespace tetune {

struct Plugin;

/// What a reader, or a plugin that writes, is given besides the path.
struct ReadContext {
  int threads = 0;
  std::vector<std::string>* warnings = nullptr;
  void warn(const std::string& text) const {
    if (warnings != nullptr) warnings->push_back(text);
  }
};

/// One file format. A null function means the format cannot be read or written.
struct Format {
  const char* name;
  std::vector<std::string> endings;
  TetMesh (*read)(const std::string& path, const ReadContext& context);
  void (*write)(FileWriter& file, const TetMesh& mesh, int threads);
  /// Does what it says here where there is no function.
  const Plugin* plugin = nullptr;
  bool plugin_reads = false, plugin_writes = false;
  /// Some builds of the plugin's library do not have the format.
  bool may_lack = false;
  bool reads() const { return read != nullptr || plugin_reads; }
  bool writes() const { return write != nullptr || plugin_writes; }
};

/// Empty, or why a mesh cannot have so many vertices, tetrahedra or entries of another list: for readers, to refuse a
/// count before memory is asked for.
std::string too_many(std::int64_t entries, bool tets);

/// The formats this build has. To add one: docs/adding-a-format.md.
const std::vector<Format>& formats();

/// Text or binary, whichever it is.
TetMesh read_medit(const std::string& path, const ReadContext& context);
/// From bytes in memory; `name` is what messages call them.
TetMesh parse_medit(const std::string& name, std::string_view bytes, const ReadContext& context);
void write_medit_text(FileWriter& file, const TetMesh& mesh, int threads);
void write_medit_binary(FileWriter& file, const TetMesh& mesh, int threads);
/// What of the mesh a MEDIT file has no room for, a sentence each.
std::vector<std::string> not_kept_by_medit(const TetMesh& mesh);
/// Numbers of tetrahedra as a MEDIT solution in text, one scalar field for each of them.
void write_medit_solution(FileWriter& file, const std::vector<Measures>& values, int threads);
TetMesh read_tetgen(const std::string& path, const ReadContext& context);

}  // namespace tetune

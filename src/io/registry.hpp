// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/file.hpp"
#include "tetune/mesh.hpp"
#include "tetune/quality.hpp"

namespace tetune {

/// What a reader is given besides the path.
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
};

/// The formats this build has. To add one: docs/adding-a-format.md.
const std::vector<Format>& formats();

TetMesh read_medit_text(const std::string& path, const ReadContext& context);
TetMesh read_medit_binary(const std::string& path, const ReadContext& context);
void write_medit_text(FileWriter& file, const TetMesh& mesh, int threads);
void write_medit_binary(FileWriter& file, const TetMesh& mesh, int threads);
/// Numbers of tetrahedra as a MEDIT solution in text, one scalar field for each of them.
void write_medit_solution(FileWriter& file, const std::vector<Measures>& values, int threads);
TetMesh read_tetgen(const std::string& path, const ReadContext& context);

}  // namespace tetune

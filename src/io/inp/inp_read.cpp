// SPDX-License-Identifier: Apache-2.0
// Abaqus's and CalculiX's decks (.inp).
#include "io/inp/inp_middles.hpp"
#include "io/inp/inp_scan.hpp"

namespace tetune {

TetMesh parse_inp(const std::string& path, std::string bytes, const IoContext& context) {
  InpScan scan = scan_inp(path, std::move(bytes));
  TetMesh mesh;
  resolve_inp(scan, mesh, path, context);
  partition_inp(scan, scan.model, mesh, context);
  erase_inp_middles(scan.model, mesh, path);
  mesh.deck = std::make_shared<const AbaqusDeck>(std::move(scan.model));
  return mesh;
}

TetMesh read_inp(const std::string& path, const IoContext& context) {
  return parse_inp(path, std::string(MappedFile(path).bytes()), context);
}

}  // namespace tetune

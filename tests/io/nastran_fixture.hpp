// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "io_fixture.hpp"

namespace tetune::test {

/// The vertices of one tetrahedron of ten nodes, and its mid-side nodes, of which the first is not a midpoint.
inline const std::string kTenNodes =
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\nGRID,5,,.6,0.,0.\nGRID,6,,.5,.5,0.\n"
    "GRID,7,,0.,.5,0.\nGRID,8,,0.,0.,.5\nGRID,9,,.5,0.,.5\nGRID,10,,0.,.5,.5\n";
inline const std::string kFourNodes = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n";
inline const std::string kTet = "CTETRA,1,7,1,2,3,4\n";
inline const std::string kEnd = "ENDDATA\n";

class Nastran : public IoTest {
 protected:
  TetMesh read(const std::string& text) {
    warnings_.clear();
    return read_mesh(put("a.bdf", text), &warnings_, 1);
  }
  ::testing::AssertionResult warned(const std::string& part) const { return contains(warnings_, part); }
  std::string error(const std::string& text) const { return read_error(put("a.bdf", text)); }
  std::vector<std::string> warnings_;
};

}  // namespace tetune::test

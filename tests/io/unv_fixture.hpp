// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "io_fixture.hpp"

namespace tetune::test {

/// A data set with its marks.
inline std::string unv_set(const std::string& number, const std::string& lines) {
  return "    -1\n" + std::string(6 - number.size(), ' ') + number + "\n" + lines + "    -1\n";
}
inline const std::string kUnvTetNodes =
    "         1         1         1        11\n"
    "   0.0000000000000000D+00   0.0000000000000000D+00   0.0000000000000000D+00\n"
    "         2         1         1        11\n"
    "   1.0000000000000000D+00   0.0000000000000000D+00   0.0000000000000000D+00\n"
    "         3         1         1        11\n"
    "   0.0000000000000000D+00   1.0000000000000000D+00   0.0000000000000000D+00\n"
    "         4         1         1        11\n"
    "   0.0000000000000000D+00   0.0000000000000000D+00   1.0000000000000000D+00\n";
inline const std::string kUnvNodes = unv_set("2411", kUnvTetNodes);
inline const std::string kUnvTet =
    "         1       111         7         1         7         4\n         1         2         3         4\n";

class Unv : public IoTest {
 protected:
  TetMesh read(const std::string& text) {
    warnings_.clear();
    return read_mesh(put("a.unv", text), &warnings_, 1);
  }
  ::testing::AssertionResult warned(const std::string& part) const { return contains(warnings_, part); }
  std::string error(const std::string& text) const { return read_error(put("a.unv", text)); }
  std::vector<std::string> warnings_;
};

}  // namespace tetune::test

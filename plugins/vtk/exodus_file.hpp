// SPDX-License-Identifier: Apache-2.0
// The file and the element kinds that reading and writing Exodus share.
#pragma once

#include <vtk_exodusII.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "plugin.hpp"

namespace tetune::plugin {

/// Sides of a tetrahedron in Exodus' order, seen from outside counter-clockwise.
inline constexpr std::array<std::array<std::size_t, 3>, 4> kTetSides{{{0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 2, 1}}};

/// An open file. One that was written is complete only once close() has returned: the library writes the last part of
/// it there.
class File {
 public:
  explicit File(int id) : id_(id) {
    ex_opts(0);
    if (id_ < 0) fail("open");
    ex_set_max_name_length(id_, kNames - 1);
  }
  ~File() {
    if (id_ >= 0) ex_close(id_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int id() const { return id_; }
  void close() { check(ex_close(std::exchange(id_, -1)), "write the file"); }
  void check(int status, const char* what) const {
    if (status < 0) fail(what);
  }
  std::vector<int> ids(ex_entity_type type, std::int64_t count) const {
    std::vector<int> result(std::size_t(count), 0);
    if (count > 0) check(ex_get_ids(id_, type, result.data()), "read the numbers of blocks and sets");
    return result;
  }
  std::vector<std::string> variable_names(ex_entity_type type) const {
    int n = 0;
    check(ex_get_variable_param(id_, type, &n), "read the variables");
    std::vector<std::string> names;
    for (int i = 1; i <= n; ++i) {
      std::array<char, kNames + 1> name{};
      check(ex_get_variable_name(id_, type, i, name.data()), "read the name of a variable");
      names.emplace_back(name.data());
    }
    return names;
  }
  static constexpr int kNames = 256;

 private:
  [[noreturn]] static void fail(const char* what) {
    const char* message = nullptr;
    const char* function = nullptr;
    int code = 0;
    ex_get_err(&message, &function, &code);
    throw FileError(std::string("the Exodus library cannot ") + what + ": " +
                    (message != nullptr && *message != '\0' ? message : "the file is damaged or of another format"));
  }
  int id_;
};

/// Names of kinds of elements in Exodus. TetMesh has arrays for the first ones; the others are in the order of their
/// lists (kind_of_list()).
struct KindOfElement {
  const char* written;
  std::vector<const char*> names;
  int nodes;
  int corners;
};
inline const std::vector<KindOfElement> kKinds{
    {"TETRA", {"TET"}, 4, 4},
    {"TETRA10", {"TET"}, 10, 4},
    {"TRI3", {"TRI", "SHELL"}, 3, 3},
    {"TRI6", {"TRI", "SHELL"}, 6, 3},
    {"BAR2", {"BAR", "BEAM", "TRUSS", "ROD", "EDGE"}, 2, 2},
    {"BAR3", {"BAR", "BEAM", "TRUSS", "ROD", "EDGE"}, 3, 2},
    {"SPHERE", {"SPHERE", "CIRCLE", "POINT"}, 1, 1},
    {"QUAD4", {"QUAD", "SHELL"}, 4, 4},
    {"PYRAMID5", {"PYR"}, 5, 5},
    {"WEDGE6", {"WED"}, 6, 6},
    {"HEX8", {"HEX"}, 8, 8},
    {"QUAD8", {"QUAD", "SHELL"}, 8, 4},
    {"PYRAMID13", {"PYR"}, 13, 5},
    {"WEDGE15", {"WED"}, 15, 6},
    {"HEX20", {"HEX"}, 20, 8},
};
inline constexpr std::size_t kTets = 0, kTriangles = 2, kEdges = 4, kOthers = 6;

/// Warns of contents of a file that TetMesh has no place for.
void warn_of_losses_on_reading(const File& file, const ex_init_params& counts, Warnings& warnings);

}  // namespace tetune::plugin

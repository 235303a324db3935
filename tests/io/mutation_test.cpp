// SPDX-License-Identifier: Apache-2.0
// Damaged files end in FileError or in a mesh, never in a crash or an excessive request for memory. The fuzz
// targets search further; this test runs everywhere, from fixed seeds.
#include <random>

#include "io_fixture.hpp"
#include "support/allocation_watch.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

constexpr int kMutations = 500;

/// Portable, unlike std::uniform_int_distribution.
std::size_t below(std::mt19937& random, std::size_t n) { return random() % n; }

std::string mutated(std::string bytes, const std::vector<std::string>& tokens, std::mt19937& random) {
  const std::size_t edits = 1 + below(random, 4);
  for (std::size_t e = 0; e < edits && !bytes.empty(); ++e) {
    const std::size_t at = below(random, bytes.size());
    switch (below(random, 6)) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(random, 8)));
        break;
      case 2:
        bytes.erase(at, 1 + below(random, 12));
        break;
      case 3:
        bytes.insert(at, bytes.substr(below(random, bytes.size()), 1 + below(random, 24)));
        break;
      case 4:
        bytes.resize(at);
        break;
      default: {
        const std::string& token = tokens[below(random, tokens.size())];
        bytes.replace(at, token.size(), token);
      }
    }
  }
  return bytes;
}

/// Elements that every format with mid-side nodes has.
std::vector<ElementBlock> second_order_others() {
  return {{"Quadrilaterals", 4, {0, 1, 4, 3}, {7}, {}, {}, true},
          {"Prisms", 6, {8, 9, 10, 11, 12, 13}, {2}, {}, {}, true},
          {"Hexahedra", 8, {14, 15, 16, 17, 18, 19, 20, 21}, {2}, {}, {}, true}};
}

class MutationTest : public IoTest {
 protected:
  /// Reads a file and validates its mesh. Returns whether the reader refused it.
  bool refused(const std::string& file, std::size_t bytes) {
    const AllocationWatch watch;
    bool threw = false;
    try {
      const TetMesh mesh = read_mesh(file, nullptr, 1);
      EXPECT_NO_THROW(validate(mesh, 1));
    } catch (const FileError& e) {
      threw = true;
      EXPECT_NE(std::string(e.what()), "");
    } catch (const std::exception& e) {
      ADD_FAILURE() << e.what();
    }
    EXPECT_LT(watch.largest(), 64 * bytes + (1U << 20));
    return threw;
  }
  void run(const std::string& name, const std::string& whole, const std::vector<std::string>& tokens, unsigned seed) {
    std::mt19937 random(seed);
    int refusals = 0;
    for (int i = 0; i < kMutations; ++i) {
      const std::string bytes = mutated(whole, tokens, random);
      if (refused(put(name, bytes), bytes.size())) ++refusals;
      if (HasFailure()) {
        FAIL() << "mutation " << i << " of " << name;
      }
    }
    // Both ends are reached: mutations neither all break nor all miss.
    EXPECT_GT(refusals, kMutations / 10);
    EXPECT_LT(refusals, kMutations);
  }
};

const std::vector<std::string> kTextTokens = {
    "0 ",   "-1 ", "999999999 ", "2147483647 ", "2147483648 ", "99999999999999999999 ", "1e400 ", "nan ",   "-inf ",
    "1D5 ", "#",   "\n",         "Vertices\n",  "Tetrahedra ", "Triangles\n",           "End\n",  "Foo 3 ", " 0x10 "};

TEST_F(MutationTest, MeditText) {
  write_mesh(path("whole.mesh"), all_sections());
  run("a.mesh", get("whole.mesh"), kTextTokens, 1);
}

TEST_F(MutationTest, MeditTextOfAValidMesh) {
  write_mesh(path("whole.mesh"), cube(2, 0.2));
  run("a.mesh", get("whole.mesh"), kTextTokens, 2);
}

TEST_F(MutationTest, MeditBinary) {
  std::vector<std::string> words;
  for (const std::int32_t word : {-1, 0, 1, 3, 4, 5, 6, 7, 8, 10, 13, 49, 54, 16777216, 2147483647, -2147483647 - 1}) {
    words.emplace_back(4, '\0');
    std::memcpy(words.back().data(), &word, 4);
  }
  write_mesh(path("whole.meshb"), all_sections());
  run("a.meshb", get("whole.meshb"), words, 3);
  // Version 3 reads the same bytes in another way.
  std::string bytes = get("whole.meshb");
  bytes[4] = 3;
  std::mt19937 random(4);
  for (int i = 0; i < kMutations; ++i) {
    const std::string damaged = mutated(bytes, words, random);
    refused(put("b.meshb", damaged), damaged.size());
  }
}

TEST_F(MutationTest, Msh) {
  std::vector<std::string> words = {"$Nodes\n",    "$EndNodes\n", "$Elements\n", "$Periodic\n", "-1 ",         "0 ",
                                    "2147483648 ", "1e400 ",      "nan ",        "\n",          "99999999999 "};
  for (const std::int64_t word : {-1, 0, 1, 4, 11, 16, 2147483647}) {
    words.emplace_back(8, '\0');
    std::memcpy(words.back().data(), &word, 8);
  }
  for (const std::string dialect : {"msh 2.2 text", "msh 2.2 binary", "msh 4.1 text", "msh 4.1 binary"}) {
    TetMesh m = cube(2, 0.2);
    m.triangles = {{0, 2, 3}};
    m.triangle_tags = {7};
    m.point_data = {{"heat", 1, std::vector<double>(m.points.size(), 0.5)}};
    m.periodic = {{2, 7, 7, {}, {{0, 1}}}};
    m.dialect = dialect;
    for (const bool second_order : {false, true}) {
      m.second_order = second_order;
      if (second_order) m.others = second_order_others();
      write_mesh(path("whole.msh"), m);
      run("a.msh", get("whole.msh"), words, 6);
    }
  }
}

TEST_F(MutationTest, Inp) {
  TetMesh m = two_materials(2);
  m.triangles = {{0, 1, 4}, {0, 4, 3}};
  m.triangle_tags = {7, 8};
  m.groups = {{3, 1, "steel", {1}}, {2, 7, "inlet", {7, 8}}};
  for (const bool second_order : {false, true}) {
    m.second_order = second_order;
    if (second_order) m.others = second_order_others();
    write_mesh(path("whole.inp"), m);
    run("a.inp", get("whole.inp"),
        {"*NODE\n", "*ELEMENT, TYPE=C3D8\n", "*NSET, NSET=A, GENERATE\n", "*ELSET, ELSET=B\n", "*SURFACE, NAME=C\n",
         "**", "*INCLUDE, INPUT=a.inp\n", "-1, ", "0, ", "99999999999999999999, ", "1e400", "nan", "\n", "\"", "S4\n",
         "A, S1"},
        8);
  }
}

TEST_F(MutationTest, Su2) {
  TetMesh m = two_materials(2);
  m.triangles = {{0, 1, 4}, {0, 4, 3}};
  m.triangle_tags = {7, 8};
  m.groups = {{2, 7, "inlet", {7}}};
  write_mesh(path("whole.su2"), m);
  run("a.su2", get("whole.su2"),
      {"NELEM= 9\n", "MARKER_TAG= a\n", "%", "=", "-1 ", "1e400 ", "nan ", "\n", "12 ", "FFD= 1\n"}, 8);
}

TEST_F(MutationTest, Nastran) {
  TetMesh m = two_materials(2);
  m.triangles = {{0, 1, 4}, {0, 4, 3}};
  m.triangle_tags = {7, 8};
  m.edges = {{0, 1}};
  m.edge_tags = {9};
  for (const bool second_order : {false, true}) {
    m.second_order = second_order;
    if (second_order) m.others = second_order_others();
    write_mesh(path("whole.bdf"), m);
    run("a.bdf", get("whole.bdf"),
        {"GRID,", "CTETRA* ", "CHEXA   ", "INCLUDE 'a.bdf'\n", "BEGIN BULK\n", "ENDDATA\n", "       0", "      -1",
         "99999999", "999999999999", "1.+400", "nan", "\n", "\t", ",", "*", "+", "$", "="},
        11);
  }
}

TEST_F(MutationTest, Unv) {
  TetMesh m = two_materials(2);
  m.triangles = {{0, 1, 4}, {0, 4, 3}};
  m.triangle_tags = {7, 8};
  m.edges = {{0, 1}};
  m.edge_tags = {9};
  m.groups = {{2, 7, "inlet", {7}}};
  m.point_data = {{"node_set:3:corner", 1, std::vector<std::uint8_t>(m.points.size(), 1)}};
  for (const bool second_order : {false, true}) {
    m.second_order = second_order;
    if (second_order) m.others = second_order_others();
    write_mesh(path("whole.unv"), m);
    run("a.unv", get("whole.unv"),
        {"    -1\n", "  2412\n", "  2477\n", "  2420\n", "   780\n", "    15\n", "         0", "        -1",
         "        11", "       118", " 999999999", "9999999999", "1.D+400", "nan", "\n", "\t", "-", "D"},
        13);
  }
}

TEST_F(MutationTest, Netgen) {
  TetMesh m = two_materials(2);
  m.triangles = {{0, 1, 4}, {0, 4, 3}};
  m.triangle_tags = {7, 8};
  m.edges = {{0, 1}};
  m.edge_tags = {1};
  m.groups = {{2, 7, "inlet", {7}}};
  m.periodic = {{2, 7, 7, {}, {{0, 1}}}};
  m.second_order = true;
  write_mesh(path("whole.vol"), m);
  const std::vector<std::string> words = {"points\n",          "bcnames\n", "endmesh\n", "edgesegmentsgi3\n",
                                          "identifications\n", "-1 ",       "99999999 ", "1e400 ",
                                          "curvedelements\n",  "10 "};
  run("a.vol", get("whole.vol"), words, 9);
  try {
    write_mesh(path("whole.vol.gz"), m);
  } catch (const FileError&) {
    return;  // no zlib
  }
  std::mt19937 random(10);
  for (int i = 0; i < 50; ++i) {
    const std::string damaged = mutated(get("whole.vol.gz"), words, random);
    read_error(put("b.vol.gz", damaged));
  }
}

TEST_F(MutationTest, TetGen) {
  put("m.node", "4 3 0 1\n1 0 0 0 1\n2 1 0 0 2\n3 0 1 0 3\n4 0 0 1 4\n");
  put("m.face", "2 1\n1 1 2 3 5\n2 1 2 4 6\n");
  put("m.ele", "1 4 1\n1 1 2 3 4 7\n");
  for (const char* name : {"m.node", "m.face", "m.ele"}) {
    const std::string whole = get(name);
    run(name, whole, kTextTokens, 5);
    put(name, whole);
  }
}

}  // namespace
}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
// TetGen's .node, .ele, .face and .edge files (TetGen manual, Sect. 5.2).
#include <filesystem>
#include <limits>

#include "io/registry.hpp"
#include "io/text_cursor.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

constexpr std::size_t kNumbersOfTet = 5;

/// A count that the rest of the text cannot hold, at `numbers_each` an entry, is refused before memory is asked for.
std::size_t checked_count(TextCursor& cursor, const char* what, std::size_t numbers_each) {
  const std::int64_t n = cursor.integer(what);
  if (n < 0 || static_cast<std::uint64_t>(n) > cursor.remaining() / (2 * numbers_each) + 1) {
    cursor.fail(std::string(what) + " is " + std::to_string(n) + ", more than the rest of the file can hold");
  }
  if (const std::string excess = too_many(n, numbers_each == kNumbersOfTet); !excess.empty()) {
    cursor.fail("this file has " + excess);
  }
  return static_cast<std::size_t>(n);
}

int to_tag(TextCursor& cursor, double value) {
  if (!(value >= std::numeric_limits<int>::min() && value <= std::numeric_limits<int>::max()) ||
      value != static_cast<double>(static_cast<int>(value))) {
    cursor.fail("attribute " + std::to_string(value) + " is not a whole number, so it cannot be kept as a tag");
  }
  return static_cast<int>(value);
}

void expect_end(TextCursor& cursor) {
  if (!cursor.at_end()) cursor.fail("there are more lines than the header says");
}

/// Reads the points; returns the number that the file gives its first one (0 or 1).
std::int64_t read_nodes(const std::string& path, TetMesh& mesh) {
  const MappedFile file(path);
  TextCursor cursor(path, file.bytes());
  const std::size_t n = checked_count(cursor, "number of points", 4);
  if (cursor.integer("dimension") != 3) cursor.fail("the dimension must be 3");
  const std::int64_t attributes = cursor.line_done() ? 0 : cursor.integer("number of attributes");
  const std::int64_t markers = cursor.line_done() ? 0 : cursor.integer("boundary marker flag");
  std::int64_t base = 0;
  mesh.points.resize(n);
  mesh.point_tags.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int64_t id = cursor.integer("point number");
    if (i == 0) base = id;
    if (base != 0 && base != 1) {
      cursor.fail("the first point has number " + std::to_string(base) + "; 0 or 1 is expected");
    }
    if (id != base + static_cast<std::int64_t>(i)) cursor.fail("points are not numbered in sequence");
    for (double& x : mesh.points[i]) x = cursor.real("coordinate");
    for (std::int64_t a = 0; a < attributes; ++a) cursor.real("attribute");
    if (markers != 0) mesh.point_tags[i] = to_tag(cursor, cursor.real("boundary marker"));
  }
  expect_end(cursor);
  return base;
}

/// Reads elements of N vertices; `attribute`: a tag follows them.
template <std::size_t N>
void read_rows(TextCursor& cursor, std::size_t n, std::int64_t base, bool attribute,
               std::vector<std::array<Index, N>>& elements, std::vector<int>& tags) {
  elements.resize(n);
  tags.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    cursor.integer("element number");
    for (Index& v : elements[i]) {
      const std::int64_t id = cursor.integer("point number") - base;
      if (id < 0 || id > std::numeric_limits<Index>::max()) cursor.fail("point number out of range");
      v = static_cast<Index>(id);
    }
    if (attribute && !cursor.line_done()) tags[i] = to_tag(cursor, cursor.real("attribute"));
    while (!cursor.line_done()) cursor.word();  // second-order nodes, neighbours and the like
  }
  expect_end(cursor);
}

}  // namespace

TetMesh read_tetgen(const std::string& path, const ReadContext& context) {
  namespace fs = std::filesystem;
  const auto sibling = [&path](const char* ending) { return fs::path(path).replace_extension(ending).string(); };
  TetMesh mesh;
  const std::int64_t base = read_nodes(sibling(".node"), mesh);
  {
    const std::string name = sibling(".ele");
    const MappedFile file(name);
    TextCursor cursor(name, file.bytes());
    const std::size_t n = checked_count(cursor, "number of tetrahedra", kNumbersOfTet);
    const std::int64_t corners = cursor.integer("nodes per tetrahedron");
    if (corners != 4) {
      cursor.fail("tetrahedra have " + std::to_string(corners) +
                  " nodes; tetune takes those with 4 (run TetGen without -o2)");
    }
    const bool attribute = !cursor.line_done() && cursor.integer("number of attributes") > 0;
    read_rows(cursor, n, base, attribute, mesh.tets, mesh.tet_tags);
  }
  std::error_code ignored;
  if (const std::string name = sibling(".face"); fs::exists(name, ignored)) {
    const MappedFile file(name);
    TextCursor cursor(name, file.bytes());
    const std::size_t n = checked_count(cursor, "number of faces", 4);
    const bool marker = !cursor.line_done() && cursor.integer("boundary marker flag") != 0;
    read_rows(cursor, n, base, marker, mesh.triangles, mesh.triangle_tags);
  } else {
    context.warn(name + " is not there: boundary markers of faces are not known");
  }
  if (const std::string name = sibling(".edge"); fs::exists(name, ignored)) {
    const MappedFile file(name);
    TextCursor cursor(name, file.bytes());
    const std::size_t n = checked_count(cursor, "number of edges", 3);
    const bool marker = !cursor.line_done() && cursor.integer("boundary marker flag") != 0;
    read_rows(cursor, n, base, marker, mesh.edges, mesh.edge_tags);
  }
  return mesh;
}

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// TetGen's .node, .ele, .face and .edge files (TetGen manual, Sect. 5.2).
#include <filesystem>
#include <limits>
#include <optional>

#include "backend/span.hpp"
#include "io/checked_count.hpp"
#include "io/registry.hpp"
#include "io/text_cursor.hpp"
#include "mesh/whole_number.hpp"
#include "system/path.hpp"
#include "system/real_text.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

/// Reads a tag; `name` stands for it in messages.
int read_tag(TextCursor& cursor, const char* name) {
  const double value = cursor.real(name);
  const std::optional<int> tag = whole_number(value);
  if (tag) return *tag;
  cursor.fail(std::string(name) + " " + number_text(value) + " is not an integer of 32 bits, as tags are");
}

void expect_end(TextCursor& cursor) {
  if (!cursor.at_end()) cursor.fail("there are more lines than the header says");
}

/// Reads the points; returns the number of the first one in the file, 0 or 1.
std::int64_t read_nodes(const std::string& path, TetMesh& mesh, const IoContext& context) {
  const MappedFile file(path);
  TextCursor cursor(path, file.bytes());
  const std::size_t n = checked_count(cursor, "number of points", 4, kMaxEntries);
  if (cursor.integer("dimension") != 3) cursor.fail("the dimension must be 3");
  const std::int64_t attributes = cursor.line_done() ? 0 : cursor.integer("number of attributes");
  if (attributes > 0) context.warn(path + ": the attributes of points are not kept");
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
    if (id != base + std::int64_t(i)) cursor.fail("points are not numbered in sequence");
    for (double& x : mesh.points[i]) x = cursor.real("coordinate");
    for (std::int64_t a = 0; a < attributes; ++a) cursor.real("attribute");
    if (markers != 0) mesh.point_tags[i] = read_tag(cursor, "boundary marker");
  }
  expect_end(cursor);
  return base;
}

/// Reads elements of N vertices; a tag of the name `tag_name` follows the vertices unless that is null. Elements
/// without it are a warning, as the file may be cut short.
template <std::size_t N>
void read_rows(TextCursor& cursor, std::size_t n, std::int64_t base, const char* tag_name, const IoContext& context,
               std::vector<std::array<Index, N>>& elements, std::vector<int>& tags) {
  elements.resize(n);
  tags.assign(n, 0);
  std::size_t untagged = 0;
  std::string place;  // of the first of these
  for (std::size_t i = 0; i < n; ++i) {
    cursor.integer("element number");
    for (Index& v : elements[i]) {
      const std::int64_t id = cursor.integer("point number") - base;
      if (id < 0 || id > std::numeric_limits<Index>::max()) {
        cursor.fail("point number out of range: " + std::to_string(id + base) + "; numbers count from " +
                    std::to_string(base));
      }
      v = static_cast<Index>(id);
    }
    if (tag_name != nullptr) {
      if (!cursor.line_done()) {
        tags[i] = read_tag(cursor, tag_name);
      } else if (untagged++ == 0) {
        place = cursor.at_line("");
      }
    }
    while (!cursor.line_done()) cursor.word();  // second-order nodes, neighbors and the like
  }
  expect_end(cursor);
  if (untagged == 0) return;
  context.warn(place + "this is the first of " + std::to_string(untagged) + " lines without the " + tag_name +
               " that the header announces, which is 0 then; the file may be cut short");
}

}  // namespace

TetMesh read_tetgen(const std::string& path, const IoContext& context) {
  namespace fs = std::filesystem;
  const auto sibling = [&path](const char* ending) { return with_ending(path, ending); };
  TetMesh mesh;
  const std::int64_t base = read_nodes(sibling(".node"), mesh, context);
  {
    const std::string name = sibling(".ele");
    const MappedFile file(name);
    TextCursor cursor(name, file.bytes());
    const std::size_t n = checked_count(cursor, "number of tetrahedra", 5, kMaxTets);
    const std::int64_t corners = cursor.integer("nodes per tetrahedron");
    if (corners != 4) {
      cursor.fail("tetrahedra have " + std::to_string(corners) +
                  " nodes; tetune takes those with 4 (run TetGen without -o2)");
    }
    const std::int64_t attributes = cursor.line_done() ? 0 : cursor.integer("number of attributes");
    if (attributes > 1) context.warn(sibling(".ele") + ": the attributes of tetrahedra after the first are not kept");
    read_rows(cursor, n, base, attributes > 0 ? "attribute" : nullptr, context, mesh.tets, mesh.tet_tags);
  }
  const auto read_optional = [&](const char* ending, const char* count, int numbers, auto& elements, auto& tags) {
    const std::string name = sibling(ending);
    std::error_code ignored;
    if (!fs::exists(path_of(name), ignored)) return false;
    const MappedFile file(name);
    TextCursor cursor(name, file.bytes());
    const std::size_t n = checked_count(cursor, count, numbers, kMaxEntries);
    const bool marker = !cursor.line_done() && cursor.integer("boundary marker flag") != 0;
    read_rows(cursor, n, base, marker ? "boundary marker" : nullptr, context, elements, tags);
    return true;
  };
  if (!read_optional(".face", "number of faces", 4, mesh.triangles, mesh.triangle_tags)) {
    context.warn(sibling(".face") + " does not exist: boundary markers of faces are not known");
  }
  read_optional(".edge", "number of edges", 3, mesh.edges, mesh.edge_tags);
  return mesh;
}

}  // namespace tetune

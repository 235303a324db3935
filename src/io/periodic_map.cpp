// SPDX-License-Identifier: Apache-2.0
// Text files of periodic pairs (docs/command-line.md).
#include <cmath>

#include "backend/span.hpp"
#include "io/text_cursor.hpp"
#include "mesh/messages.hpp"
#include "mesh/periodic.hpp"
#include "system/file.hpp"
#include "tetune/periodic.hpp"

namespace tetune {
namespace {

/// Requires that another number stands on the line.
void expect_more(TextCursor& cursor, const char* what) {
  if (cursor.line_done()) cursor.fail(std::string("expected ") + what + ", found the end of the line");
}

/// Reads one vertex; returns its id.
Index read_vertex(TextCursor& cursor, const char* name, std::size_t vertices) {
  expect_more(cursor, "a vertex and its master");
  const std::int64_t number = cursor.integer(name);
  if (number < 1 || number > std::int64_t(vertices)) {
    cursor.fail(std::string(name) + " " + std::to_string(number) + " does not exist: the mesh has the vertices 1 to " +
                std::to_string(vertices));
  }
  return to_index(number - 1);
}

void check_pair(TextCursor& cursor, const TetMesh& mesh, const PeriodicLink& link, double tolerance) {
  const auto [vertex, master] = link.pairs.back();
  double distance = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double at = span_of(mesh.points)[master][k] + link.affine[4 * k + 3];
    distance = std::max(distance, std::fabs(span_of(mesh.points)[vertex][k] - at));
  }
  if (distance <= tolerance) return;
  cursor.fail("vertex " + std::to_string(vertex + 1) + " is " + short_text(distance) + " from vertex " +
              std::to_string(master + 1) +
              " plus the translation; a pair of another translation belongs to a link of "
              "its own, which begins with \"translation X Y Z\"");
}

}  // namespace

void read_periodic_map(const std::string& path, TetMesh& mesh) {
  const MappedFile file(path);
  TextCursor cursor(path, file.bytes());
  const double tolerance = kMatchTolerance * extent_of(mesh);
  std::vector<PeriodicLink> links;
  while (!cursor.at_end()) {
    if (cursor.peek() == "translation") {
      cursor.word();
      PeriodicLink link;
      link.affine = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
      for (std::size_t k = 0; k < 3; ++k) {
        expect_more(cursor, "the three components of a translation");
        const double component = cursor.real("translation");
        if (!std::isfinite(component)) cursor.fail("the translation has a component that is not a finite number");
        link.affine[4 * k + 3] = component;
      }
      links.push_back(std::move(link));
      continue;
    }
    if (links.empty()) cursor.fail("expected \"translation X Y Z\" before the first pair");
    const Index vertex = read_vertex(cursor, "vertex", mesh.points.size());
    const Index master = read_vertex(cursor, "master", mesh.points.size());
    links.back().pairs.push_back({vertex, master});
    check_pair(cursor, mesh, links.back(), tolerance);
  }
  mesh.periodic.insert(mesh.periodic.end(), links.begin(), links.end());
}

}  // namespace tetune

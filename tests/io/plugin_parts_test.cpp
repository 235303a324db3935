// SPDX-License-Identifier: Apache-2.0
// Meshes in several VTK files, which are joined.
#include <algorithm>
#include <set>
#include <sstream>
#include <utility>
#include <variant>

#include "plugin_fixture.hpp"
#include "support/entities.hpp"
#include "tetune/validate.hpp"

namespace tetune::test {
namespace {

/// The elements with a tag and their vertices, with the curved edges and other elements between these.
TetMesh part_of(const TetMesh& m, int tag) {
  TetMesh part;
  part.second_order = m.second_order;
  std::vector<Index> old2new(m.points.size(), -1);
  const auto now = [&old2new](Index v) { return old2new[static_cast<std::size_t>(v)]; };
  for (std::size_t t = 0; t < m.tets.size(); ++t) {
    if (m.tet_tags[t] != tag) continue;
    auto tet = m.tets[t];
    for (Index& v : tet) {
      Index& number = old2new[static_cast<std::size_t>(v)];
      if (number < 0) {
        number = static_cast<Index>(part.points.size());
        part.points.push_back(m.points[static_cast<std::size_t>(v)]);
      }
      v = number;
    }
    part.tets.push_back(tet);
    part.tet_tags.push_back(tag);
  }
  part.point_tags.assign(part.points.size(), 0);
  for (const CurvedEdge& e : m.curved_edges) {
    const Index a = now(e.vertices[0]), b = now(e.vertices[1]);
    if (a >= 0 && b >= 0) part.curved_edges.push_back({{std::min(a, b), std::max(a, b)}, e.middle});
  }
  std::sort(part.curved_edges.begin(), part.curved_edges.end(),
            [](const CurvedEdge& x, const CurvedEdge& y) { return x.vertices < y.vertices; });
  for (ElementBlock block : m.others) {
    for (Index& v : block.element2vertex) v = now(v);
    if (std::count(block.element2vertex.begin(), block.element2vertex.end(), -1) == 0) part.others.push_back(block);
  }
  return part;
}

const char* const kTwoParts =
    R"(<VTKFile type="PUnstructuredGrid" version="1.0"><PUnstructuredGrid GhostLevel="0"><PCellData>)"
    R"(<PDataArray type="Int32" Name="medit:ref"/></PCellData><PPoints><PDataArray type="Float64" NumberOfComponents="3"/>)"
    R"(</PPoints><Piece Source="part1.vtu"/><Piece Source="part2.vtu"/></PUnstructuredGrid></VTKFile>)";

TEST_F(Plugins, PartsAreJoinedWhereTheyMeet) {
  const TetMesh m = two_materials(4);
  for (int part = 1; part <= 2; ++part) write_mesh(path("part" + std::to_string(part) + ".vtu"), part_of(m, part), 1);
  std::vector<std::string> warnings;
  const TetMesh joined = read_mesh(put("a.pvtu", kTwoParts), &warnings, 1);
  EXPECT_EQ(warnings, std::vector<std::string>());
  EXPECT_EQ(joined.points.size(), m.points.size());
  EXPECT_EQ(joined.tets.size(), m.tets.size());
  EXPECT_TRUE(validate(joined).ok());
  EXPECT_EQ(std::set<int>(joined.tet_tags.begin(), joined.tet_tags.end()), (std::set<int>{1, 2}));
}

/// The curved edges of a mesh, by positions.
std::set<std::pair<std::set<Point3>, Point3>> curved_places(const TetMesh& m) {
  std::set<std::pair<std::set<Point3>, Point3>> places;
  const auto at = [&m](Index v) { return m.points[static_cast<std::size_t>(v)]; };
  for (const CurvedEdge& e : m.curved_edges) places.insert({{at(e.vertices[0]), at(e.vertices[1])}, e.middle});
  return places;
}

TEST_F(Plugins, PartsOfSecondOrderAreJoinedWithTheirCurvedEdges) {
  TetMesh m = two_materials(4);
  m.second_order = true;
  for (const auto& [a, b] : edges_of(m)) {  // all, also those between both parts
    const Point3 p = m.points[static_cast<std::size_t>(a)], q = m.points[static_cast<std::size_t>(b)];
    m.curved_edges.push_back({{a, b}, {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2 + 0.01, (p[2] + q[2]) / 2}});
  }
  // An element of another kind in each part, behind whose vertices the file has mid-side nodes.
  for (const auto& tet : {m.tets[0], m.tets.back()}) {
    m.others.push_back({"Quadrilaterals", 4, {tet.begin(), tet.end()}, {5}, {}});
  }
  for (int part = 1; part <= 2; ++part) write_mesh(path("part" + std::to_string(part) + ".vtu"), part_of(m, part), 1);
  const TetMesh joined = read_mesh(put("a.pvtu", kTwoParts), nullptr, 1);
  EXPECT_EQ(joined.points.size(), m.points.size());
  EXPECT_EQ(joined.curved_edges.size(), m.curved_edges.size());
  EXPECT_EQ(curved_places(joined), curved_places(m));
  EXPECT_TRUE(validate(joined).ok());
  ASSERT_EQ(joined.others.size(), 1U);
  std::vector<Point3> places;
  for (const Index v : joined.others[0].element2vertex) places.push_back(joined.points[static_cast<std::size_t>(v)]);
  std::vector<Point3> expected;
  for (const ElementBlock& block : m.others) {
    for (const Index v : block.element2vertex) expected.push_back(m.points[static_cast<std::size_t>(v)]);
  }
  EXPECT_EQ(places, expected);
}

/// Two tetrahedra with a common face, 1 2 3.
const std::vector<Point3> kFivePoints{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 2, 2}};
const std::array<Index, 4> kLowTet{0, 1, 2, 3}, kHighTet{1, 2, 3, 4};

struct Piece {
  std::vector<Point3> points = kFivePoints;
  std::vector<int> values, duplicates;  ///< per point
  std::vector<std::array<Index, 4>> tets;
  std::vector<int> ghosts;  ///< per tetrahedron
};

std::string vtu_of(const Piece& piece) {
  const auto array = [](const char* type, const char* name, const auto& values, int components = 1) {
    std::string text = std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                       std::to_string(components) + "\" format=\"ascii\">";
    std::ostringstream numbers;
    numbers.precision(17);
    for (const auto& value : values) numbers << value << ' ';
    return text + numbers.str() + "</DataArray>";
  };
  std::vector<double> coordinates;
  for (const Point3& p : piece.points) coordinates.insert(coordinates.end(), p.begin(), p.end());
  std::vector<int> ids, offsets, types(piece.tets.size(), 10);
  for (const auto& tet : piece.tets) {
    ids.insert(ids.end(), tet.begin(), tet.end());
    offsets.push_back(int(ids.size()));
  }
  return "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\"><UnstructuredGrid><Piece NumberOfPoints=\"" +
         std::to_string(piece.points.size()) + "\" NumberOfCells=\"" + std::to_string(piece.tets.size()) +
         "\"><PointData>" + array("Int32", "value", piece.values) + array("UInt8", "vtkGhostType", piece.duplicates) +
         "</PointData><CellData>" + array("UInt8", "vtkGhostType", piece.ghosts) + "</CellData><Points>" +
         array("Float64", "Points", coordinates, 3) + "</Points><Cells>" + array("Int32", "connectivity", ids) +
         array("Int32", "offsets", offsets) + array("UInt8", "types", types) +
         "</Cells></Piece></UnstructuredGrid></VTKFile>";
}

const char* const kTwoPartsWithGhosts =
    R"(<VTKFile type="PUnstructuredGrid" version="1.0"><PUnstructuredGrid GhostLevel="1"><PPointData>)"
    R"(<PDataArray type="Int32" Name="value"/><PDataArray type="UInt8" Name="vtkGhostType"/></PPointData><PCellData>)"
    R"(<PDataArray type="UInt8" Name="vtkGhostType"/></PCellData><PPoints><PDataArray type="Float64" NumberOfComponents="3"/>)"
    R"(</PPoints><Piece Source="part1.vtu"/><Piece Source="part2.vtu"/></PUnstructuredGrid></VTKFile>)";

TEST_F(Plugins, SharedPointsOfPartsHaveTheDataOfTheirOwner) {
  constexpr int kStale = -999;
  // Points 0 and 4 are copies in one part that only its ghost cell uses; the face belongs to the second part.
  const Piece first{kFivePoints, {10, kStale, kStale, kStale, kStale}, {0, 1, 1, 1, 1}, {kLowTet, kHighTet}, {0, 1}};
  const Piece second{kFivePoints, {kStale, 11, 12, 13, 14}, {0, 0, 0, 0, 0}, {kHighTet, kLowTet}, {0, 1}};
  for (const bool swaps : {false, true}) {
    put("part1.vtu", vtu_of(swaps ? second : first));
    put("part2.vtu", vtu_of(swaps ? first : second));
    const TetMesh joined = read_mesh(put("a.pvtu", kTwoPartsWithGhosts), nullptr, 1);
    EXPECT_EQ(joined.points, kFivePoints);
    EXPECT_EQ(joined.tets.size(), 2U);
    ASSERT_EQ(joined.point_data.size(), 1U) << "flags of copies are not data of the whole mesh";
    EXPECT_EQ(joined.point_data[0].name, "value");
    EXPECT_EQ(std::get<std::vector<std::int32_t>>(joined.point_data[0].values),
              (std::vector<std::int32_t>{10, 11, 12, 13, 14}));
    EXPECT_TRUE(joined.tet_data.empty());
  }
}

TEST_F(Plugins, PartsWhoseCommonPointsDifferInTheLastBits) {
  Piece low{kFivePoints, {0, 1, 2, 3, 4}, {0, 0, 0, 0, 0}, {kLowTet}, {0}};
  Piece high = low;
  high.tets = {kHighTet};
  for (const double shift : {1e-13, 1e-8}) {
    for (std::size_t v = 1; v < 4; ++v) high.points[v][0] = low.points[v][0] + shift;
    put("part1.vtu", vtu_of(low));
    put("part2.vtu", vtu_of(high));
    std::vector<std::string> warnings;
    read_mesh(put("a.pvtu", kTwoPartsWithGhosts), &warnings, 1);
    const auto is_torn = [](const std::string& w) {
      return w.find("6 points are nearer to a point of another piece") != w.npos;
    };
    EXPECT_EQ(std::count_if(warnings.begin(), warnings.end(), is_torn), shift < 1e-9 ? 1 : 0);
  }
}

}  // namespace
}  // namespace tetune::test

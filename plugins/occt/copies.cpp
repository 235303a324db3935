// SPDX-License-Identifier: Apache-2.0
#include "copies.hpp"

#include <BRepAdaptor_Curve.hxx>
#include <BRep_Tool.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <map>

#include "box.hpp"
#include "plugin.hpp"

namespace tetune::plugin {
namespace {

using Key = std::vector<int>;

/// Returns for each of the entities 1 to `count` the first one with the same key that is the same.
template <class KeyOf, class AreSame>
std::vector<int> first_of(int count, const KeyOf& key_of, const AreSame& are_same) {
  std::vector<int> first(std::size_t(count + 1), 0);
  std::map<Key, std::vector<int>> firsts;
  for (int i = 1; i <= count; ++i) {
    std::vector<int>& known = firsts[key_of(i)];
    const auto same = std::find_if(known.begin(), known.end(), [&](int j) { return are_same(j, i); });
    item(first, i) = same == known.end() ? i : *same;
    if (same == known.end()) known.push_back(i);
  }
  return first;
}

/// Whether both edges pass through the same places, in the same or the opposite direction.
bool follow_each_other(const TopoDS_Edge& d, const TopoDS_Edge& e, double tolerance) {
  const bool degenerate = BRep_Tool::Degenerated(d);
  if (degenerate || BRep_Tool::Degenerated(e)) return degenerate && BRep_Tool::Degenerated(e);
  const BRepAdaptor_Curve a(d), b(e);
  const auto at = [](const BRepAdaptor_Curve& c, double part) {
    return c.Value(c.FirstParameter() + part * (c.LastParameter() - c.FirstParameter()));
  };
  bool same = true, opposite = true;
  for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const gp_Pnt p = at(a, part);
    same = same && p.Distance(at(b, part)) <= tolerance;
    opposite = opposite && p.Distance(at(b, 1 - part)) <= tolerance;
  }
  return same || opposite;
}

bool have_same_box(const TopoDS_Shape& f, const TopoDS_Shape& g, double tolerance) {
  const Bnd_Box a = box_of(f), b = box_of(g);
  return a.CornerMin().Distance(b.CornerMin()) <= tolerance && a.CornerMax().Distance(b.CornerMax()) <= tolerance;
}

}  // namespace

FirstCopies find_copies(const TopTools_IndexedMapOfShape& vertices, const TopTools_IndexedMapOfShape& edges,
                        const TopTools_IndexedMapOfShape& faces, double tolerance) {
  FirstCopies first;
  const auto place = [&](int v) { return BRep_Tool::Pnt(TopoDS::Vertex(vertices(v))); };
  first.vertices = first_of(
      vertices.Extent(), [](int) { return Key(); },
      [&](int v, int w) { return place(v).Distance(place(w)) <= tolerance; });
  const auto parts_of = [](const TopoDS_Shape& shape, TopAbs_ShapeEnum kind, const TopTools_IndexedMapOfShape& map,
                           const std::vector<int>& map2first) {
    Key key;
    for (TopExp_Explorer part(shape, kind); part.More(); part.Next()) {
      key.push_back(item(map2first, map.FindIndex(part.Current())));
    }
    std::sort(key.begin(), key.end());
    return key;
  };
  first.edges = first_of(
      edges.Extent(), [&](int e) { return parts_of(edges(e), TopAbs_VERTEX, vertices, first.vertices); },
      [&](int d, int e) { return follow_each_other(TopoDS::Edge(edges(d)), TopoDS::Edge(edges(e)), tolerance); });
  first.faces = first_of(
      faces.Extent(), [&](int f) { return parts_of(faces(f), TopAbs_EDGE, edges, first.edges); },
      [&](int f, int g) { return have_same_box(faces(f), faces(g), 10 * tolerance); });
  return first;
}

}  // namespace tetune::plugin

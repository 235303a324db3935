// SPDX-License-Identifier: Apache-2.0
#include "model.hpp"

#include <BRepAdaptor_Curve.hxx>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BinTools.hxx>
#include <Bnd_Box.hxx>
#include <IGESControl_Reader.hxx>
#include <STEPControl_Reader.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <fstream>
#include <utility>

#include "box.hpp"

namespace tetune::plugin {
namespace {

TopoDS_Shape read_step(const std::string& file, Warnings& warnings) {
  STEPControl_Reader reader;
  if (reader.ReadFile(file.c_str()) != IFSelect_RetDone) {
    throw FileError("the file is damaged, cut short, or no STEP file");
  }
  TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
  reader.FileUnits(lengths, angles, solid_angles);
  for (int i = 2; i <= lengths.Length(); ++i) {
    if (lengths.Value(i) != lengths.First()) {
      warnings.emplace_back("parts of the model are in different units; each is converted");
      break;
    }
  }
  reader.TransferRoots();
  return reader.OneShape();
}

/// Faces of IGES are separate: those that meet are joined at common edges.
TopoDS_Shape read_iges(const std::string& file) {
  IGESControl_Reader reader;
  if (reader.ReadFile(file.c_str()) != IFSelect_RetDone) {
    throw FileError("the file is damaged, cut short, or no IGES file");
  }
  reader.TransferRoots();
  const TopoDS_Shape faces = reader.OneShape();
  if (faces.IsNull()) return faces;
  Bnd_Box box;
  BRepBndLib::Add(faces, box);
  if (box.IsVoid()) return faces;
  constexpr double kJoinTolerance = 1e-5;  // of the diagonal
  BRepBuilderAPI_Sewing sewing(kJoinTolerance * std::sqrt(box.SquareExtent()));
  sewing.Add(faces);
  sewing.Perform();
  return sewing.SewedShape();
}

TopoDS_Shape read_brep(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string start(64, '\0');
  in.read(start.data(), std::ssize(start));
  const auto has = [&](const char* text) { return start.find(text) != std::string::npos; };
  const bool is_binary = has("Open CASCADE Topology");
  if (!is_binary && !has("CASCADE Topology") && !has("DBRep_DrawableShape")) {
    throw FileError("this is not a BREP file");
  }
  in.clear();
  in.seekg(0);
  // OpenCASCADE reads on after the end of a file that is cut short.
  in.exceptions(std::ios::failbit | std::ios::badbit);
  TopoDS_Shape shape;
  try {
    if (is_binary) {
      BinTools::Read(shape, in);
    } else {
      BRepTools::Read(shape, in, BRep_Builder());
    }
  } catch (const std::ios::failure&) {
    throw FileError("the file is damaged or cut short");
  }
  return shape;
}

void sort_lists(std::vector<std::vector<int>>& lists) {
  for (std::vector<int>& list : lists) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
}

}  // namespace

TopoDS_Shape read_shape(const std::string& file, Warnings& warnings) {
  const std::string ending = ending_of(file);
  if (ending == ".step" || ending == ".stp") return read_step(file, warnings);
  if (ending == ".iges" || ending == ".igs") return read_iges(file);
  if (ending == ".brep" || ending == ".brp") return read_brep(file);
  throw FileError("the ending is not one of CAD geometry: .step .stp .iges .igs .brep .brp");
}

LoadedModel summarize(const TopoDS_Shape& shape) {
  LoadedModel model;
  constexpr TopAbs_ShapeEnum kKinds[] = {TopAbs_VERTEX, TopAbs_EDGE, TopAbs_FACE, TopAbs_SOLID};
  for (std::size_t d = 0; d < model.counts.size() && !shape.IsNull(); ++d) {
    TopTools_IndexedMapOfShape map;
    TopExp::MapShapes(shape, kKinds[d], map);
    model.counts[d] = map.Extent();
  }
  if (model.counts[2] == 0) throw FileError("the file has no face: it is damaged, or has no geometry of a surface");
  Bnd_Box box;
  BRepBndLib::AddOptimal(shape, box, Standard_False, Standard_False);
  if (box.IsVoid() || box.IsOpen()) throw FileError("the model is unbounded");
  const gp_Pnt low = box.CornerMin(), high = box.CornerMax();
  model.low = {low.X(), low.Y(), low.Z()};
  model.high = {high.X(), high.Y(), high.Z()};
  return model;
}

Model::Model(TopoDS_Shape shape) : shape_(std::move(shape)) {
  TopExp::MapShapes(shape_, TopAbs_VERTEX, vertices_);
  TopExp::MapShapes(shape_, TopAbs_EDGE, edges_);
  TopExp::MapShapes(shape_, TopAbs_FACE, faces_);
  Bnd_Box box;
  BRepBndLib::Add(shape_, box);
  constexpr double kSamePlace = 1e-7;  // of the diagonal
  first_ = find_copies(vertices_, edges_, faces_, kSamePlace * std::sqrt(box.SquareExtent()));
  face_boxes_.resize(std::size_t(faces() + 1));
  for (int f = 1; f <= faces(); ++f) item(face_boxes_, f) = box_of(face(f));
  list_boundaries();
  find_feature_edges();
  find_feature_vertices();
}

void Model::list_boundaries() {
  edge2faces_.resize(std::size_t(edges() + 1));
  vertex2faces_.resize(std::size_t(vertices() + 1));
  face2edges_.resize(std::size_t(faces() + 1));
  for (int f = 1; f <= faces(); ++f) {
    if (!is_first_face(f)) continue;
    for (TopExp_Explorer e(faces_(f), TopAbs_EDGE); e.More(); e.Next()) {
      const int id = item(first_.edges, edges_.FindIndex(e.Current()));
      if (BRep_Tool::Degenerated(edge(id))) continue;
      item(edge2faces_, id).push_back(f);
      item(face2edges_, f).push_back(id);
    }
    for (TopExp_Explorer v(faces_(f), TopAbs_VERTEX); v.More(); v.Next()) {
      item(vertex2faces_, first_vertex(v.Current())).push_back(f);
    }
  }
  for (auto* lists : {&edge2faces_, &vertex2faces_, &face2edges_}) sort_lists(*lists);
}

gp_Pnt Model::vertex(int i) const { return BRep_Tool::Pnt(TopoDS::Vertex(vertices_(i))); }

bool Model::is_seam_of(int e, const TopoDS_Face& face) const {
  for (TopExp_Explorer side(face, TopAbs_EDGE); side.More(); side.Next()) {
    const TopoDS_Edge& listed = TopoDS::Edge(side.Current());
    if (item(first_.edges, edges_.FindIndex(listed)) == e && BRep_Tool::IsClosed(listed, face)) return true;
  }
  return false;
}

void Model::find_feature_edges() {
  feature_edge_.assign(std::size_t(edges() + 1), 0);
  for (int e = 1; e <= edges(); ++e) {
    const std::vector<int>& bounded = faces_of_edge(e);
    const bool is_seam = bounded.size() == 1 && is_seam_of(e, face(bounded[0]));
    item(feature_edge_, e) = !bounded.empty() && !is_seam;
  }
}

void Model::find_feature_vertices() {
  struct End {
    int edge;
    gp_Vec outward;
  };
  std::vector<std::vector<End>> ends(std::size_t(vertices() + 1));
  for (int e = 1; e <= edges(); ++e) {
    if (!is_feature_edge(e)) continue;
    const BRepAdaptor_Curve curve(edge(e));
    TopoDS_Vertex first, last;
    TopExp::Vertices(TopoDS::Edge(edge(e).Oriented(TopAbs_FORWARD)), first, last);
    gp_Pnt p;
    gp_Vec tangent;
    curve.D1(curve.FirstParameter(), p, tangent);
    if (!first.IsNull()) item(ends, first_vertex(first)).push_back({e, tangent});
    curve.D1(curve.LastParameter(), p, tangent);
    if (!last.IsNull()) item(ends, first_vertex(last)).push_back({e, -tangent});
  }
  feature_vertex_.assign(std::size_t(vertices() + 1), 0);
  constexpr double kSmooth = 1e-3;  // radians
  for (int v = 1; v <= vertices(); ++v) {
    const std::vector<End>& at = item(ends, v);
    const bool closed = at.size() == 2 && at[0].edge == at[1].edge && at[0].outward.Magnitude() > 0 &&
                        at[1].outward.Magnitude() > 0 && at[0].outward.IsOpposite(at[1].outward, kSmooth);
    item(feature_vertex_, v) = !at.empty() && !closed;
  }
}

}  // namespace tetune::plugin

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Bnd_Box.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <gp_Pnt.hxx>
#include <string>
#include <vector>

#include "copies.hpp"
#include "io/geometry/geometry_stream.hpp"
#include "plugin.hpp"

namespace tetune::plugin {

inline gp_Pnt pnt(const Point3& p) { return {p[0], p[1], p[2]}; }

/// Reads STEP, IGES, or text or binary BREP, by the ending of its name. Throws FileError, or OpenCASCADE's exceptions.
TopoDS_Shape read_shape(const std::string& file, Warnings& warnings);

/// Throws FileError where the shape has no surface, or an unbounded one.
LoadedModel summarize(const TopoDS_Shape& shape);

/// The entities of a model and which bound which. Lists of entities are sorted, and in numbers from 1.
///
/// Seams of periodic faces and poles are no edges of the shape, but of its parametrization: they are in no list, nor
/// are vertices at which nothing but seams and one closed smooth edge end. Entities that coincide, as the faces of two
/// solids that touch, of which STEP has two copies, count as one: that with the lowest number.
class Model {
 public:
  explicit Model(TopoDS_Shape shape);

  int vertices() const { return vertices_.Extent(); }
  int edges() const { return edges_.Extent(); }
  int faces() const { return faces_.Extent(); }
  gp_Pnt vertex(int i) const;
  const TopoDS_Edge& edge(int i) const { return TopoDS::Edge(edges_(i)); }
  const TopoDS_Face& face(int i) const { return TopoDS::Face(faces_(i)); }
  /// The face that face i coincides with; 0 where there is no face i.
  int first_face(int i) const { return i >= 1 && i <= faces() ? item(first_.faces, i) : 0; }
  const Bnd_Box& face_box(int i) const { return item(face_boxes_, i); }
  bool is_first_face(int i) const { return first_face(i) == i; }
  bool is_feature_edge(int i) const { return item(feature_edge_, i); }
  bool is_feature_vertex(int i) const { return item(feature_vertex_, i); }
  const std::vector<int>& faces_of_edge(int i) const { return item(edge2faces_, i); }
  const std::vector<int>& faces_of_vertex(int i) const { return item(vertex2faces_, i); }
  const std::vector<int>& edges_of_face(int i) const { return item(face2edges_, i); }

 private:
  int first_vertex(const TopoDS_Shape& vertex) const { return item(first_.vertices, vertices_.FindIndex(vertex)); }
  bool is_seam_of(int edge, const TopoDS_Face& face) const;
  void list_boundaries();
  void find_feature_edges();
  void find_feature_vertices();

  TopoDS_Shape shape_;
  TopTools_IndexedMapOfShape vertices_, edges_, faces_;
  FirstCopies first_;
  std::vector<Bnd_Box> face_boxes_;
  std::vector<char> feature_edge_, feature_vertex_;
  std::vector<std::vector<int>> edge2faces_, vertex2faces_;
  std::vector<std::vector<int>> face2edges_;  ///< all that are not degenerate, seams too
};

}  // namespace tetune::plugin

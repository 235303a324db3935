// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <map>
#include <string>

#include "arrays.hpp"
#include "bindings.hpp"
#include "tetune/tetune.hpp"

namespace tetune::python {

using namespace nb::literals;
namespace {

using Self = nb::handle_t<TetMesh>;
using Block = std::tuple<std::string, nb::object>;

TetMesh& of(Self self) { return nb::cast<TetMesh&>(self); }

void fill_tags(std::vector<int>& tags, std::size_t size) {
  if (tags.empty()) tags.resize(size, 0);
}

void assign_curved_edges(const nb::object& edges, const nb::object& middles, std::vector<CurvedEdge>& to) {
  std::vector<std::array<Index, 2>> ends;
  std::vector<Point3> positions;
  assign("curved_edges", edges, ends);
  assign("curved_middles", middles, positions);
  if (ends.size() != positions.size()) {
    throw nb::value_error("curved_edges and curved_middles must have the same number of rows");
  }
  for (std::size_t i = 0; i < ends.size(); ++i) {
    to.push_back({{std::min(ends[i][0], ends[i][1]), std::max(ends[i][0], ends[i][1])}, positions[i]});
  }
  std::sort(to.begin(), to.end(), [](const auto& a, const auto& b) { return a.vertices < b.vertices; });
}

/// A view of a member of each curved edge.
template <class T, std::size_t N>
auto view_curved(std::vector<CurvedEdge>& of, std::array<T, N> CurvedEdge::*member, nb::handle owner) {
  static_assert(sizeof(CurvedEdge) % sizeof(T) == 0);
  T* data = of.empty() ? nullptr : (of.front().*member).data();
  return nb::ndarray<nb::numpy, T, nb::shape<-1, nb::ssize_t{N}>>(data, {of.size(), N}, owner,
                                                                  {std::int64_t{sizeof(CurvedEdge) / sizeof(T)}, 1});
}

void construct(TetMesh* place, nb::object points, nb::object tets, nb::object point_tags, nb::object tet_tags,
               nb::object triangles, nb::object triangle_tags, nb::object edges, nb::object edge_tags,
               nb::object corners, nb::object required_vertices, nb::object ridges, nb::object required_edges,
               nb::object required_triangles, nb::object required_tets, const std::vector<Block>& others,
               const std::vector<bool>& second_order_others, bool second_order, nb::object curved_edges,
               nb::object curved_middles) {
  TetMesh mesh;
  assign("points", points, mesh.points);
  assign("tets", tets, mesh.tets);
  assign("point_tags", point_tags, mesh.point_tags);
  assign("tet_tags", tet_tags, mesh.tet_tags);
  assign("triangles", triangles, mesh.triangles);
  assign("triangle_tags", triangle_tags, mesh.triangle_tags);
  assign("edges", edges, mesh.edges);
  assign("edge_tags", edge_tags, mesh.edge_tags);
  assign("corners", corners, mesh.corners);
  assign("required_vertices", required_vertices, mesh.required_vertices);
  assign("ridges", ridges, mesh.ridges);
  assign("required_edges", required_edges, mesh.required_edges);
  assign("required_triangles", required_triangles, mesh.required_triangles);
  assign("required_tets", required_tets, mesh.required_tets);
  assign_curved_edges(curved_edges, curved_middles, mesh.curved_edges);
  mesh.second_order = second_order || !mesh.curved_edges.empty();
  if (!second_order_others.empty() && second_order_others.size() != others.size()) {
    throw nb::value_error("second_order_others must have one entry per entry of others, or none");
  }
  for (std::size_t i = 0; i < others.size(); ++i) {
    const auto& [kind, object] = others[i];
    const auto array = as_array(kind.c_str(), object);
    if (array.ndim() != 2 || array.shape(1) == 0) {
      throw nb::value_error((kind + " must have the shape (n, vertices of one), with at least one vertex").c_str());
    }
    ElementBlock block{
        kind, static_cast<int>(array.shape(1)), std::vector<Index>(array.size()), std::vector<int>(array.shape(0)), {}};
    if (array.size() > 0) copy_array(kind.c_str(), array, array.shape(1), block.element2vertex.data());
    block.second_order = !second_order_others.empty() && second_order_others[i];
    mesh.others.push_back(std::move(block));
  }
  fill_tags(mesh.point_tags, mesh.points.size());
  fill_tags(mesh.tet_tags, mesh.tets.size());
  fill_tags(mesh.triangle_tags, mesh.triangles.size());
  fill_tags(mesh.edge_tags, mesh.edges.size());
  const std::int64_t turned = without_gil([&] { return orient_uniformly(mesh); });
  if (turned > 0 && !mesh.listed_inside_out) {
    warn(std::to_string(turned) + " tetrahedra were listed inside out, unlike their neighbors: they were reversed");
  }
  new (place) TetMesh(std::move(mesh));
}

void link_box(TetMesh& mesh, const std::string& axes) {
  std::array<bool, 3> chosen{};
  for (const char c : axes) {
    const std::size_t axis = std::string("xyz").find(c);
    if (axis == std::string::npos) throw nb::value_error("axes must be some of \"xyz\"");
    chosen.at(axis) = true;
  }
  link_box_faces(mesh, chosen);
}

void bind_mesh_arrays(nb::class_<TetMesh>& type) {
  type.def_prop_ro(
          "points", [](Self s) { return view(of(s).points, s); }, "Positions, (n, 3).")
      .def_prop_ro("point_tags", [](Self s) { return view(of(s).point_tags, s); })
      .def_prop_ro(
          "tets", [](Self s) { return view(of(s).tets, s); },
          "Tetrahedra (v0, v1, v2, v3) with det(v1-v0, v2-v0, v3-v0) > 0, (m, 4).")
      .def_prop_ro(
          "tet_tags", [](Self s) { return view(of(s).tet_tags, s); }, "Region (material) of each tetrahedron.")
      .def_prop_ro(
          "triangles", [](Self s) { return view(of(s).triangles, s); },
          "Listed triangles: boundary patches, interfaces and other constraints, (k, 3).")
      .def_prop_ro("triangle_tags", [](Self s) { return view(of(s).triangle_tags, s); })
      .def_prop_ro(
          "edges", [](Self s) { return view(of(s).edges, s); },
          "Listed edges: feature lines and other constraints, (k, 2).")
      .def_prop_ro("edge_tags", [](Self s) { return view(of(s).edge_tags, s); })
      .def_prop_ro(
          "corners", [](Self s) { return view(of(s).corners, s); }, "Vertices that are corners of the shape.")
      .def_prop_ro(
          "required_vertices", [](Self s) { return view(of(s).required_vertices, s); }, "Vertices that must not move.")
      .def_prop_ro(
          "ridges", [](Self s) { return view(of(s).ridges, s); }, "Rows of `edges`: sharp feature lines.")
      .def_prop_ro(
          "required_edges", [](Self s) { return view(of(s).required_edges, s); },
          "Rows of `edges` that must not change.")
      .def_prop_ro(
          "required_triangles", [](Self s) { return view(of(s).required_triangles, s); },
          "Rows of `triangles` that must not change.")
      .def_prop_ro(
          "required_tets", [](Self s) { return view(of(s).required_tets, s); }, "Rows of `tets` that must not change.");
}

void bind_links(nb::class_<TetMesh>& type) {
  type.def_prop_ro(
          "groups",
          [](const TetMesh& mesh) {
            std::vector<std::tuple<std::string, int, std::vector<int>>> groups;
            for (const Group& group : mesh.groups) groups.emplace_back(group.name, group.dimension, group.tags);
            return groups;
          },
          "Groups of the file: the name, which may be empty, the dimension (0: points, 1: edges, 2: faces, 3: solids) "
          "and the tags of the elements.")
      .def_prop_ro(
          "periodic",
          [](Self s) {
            nb::list list;
            for (PeriodicLink& link : of(s).periodic) {
              list.append(nb::ndarray<nb::numpy, Index, nb::ndim<2>>(link.pairs.data(), {link.pairs.size(), 2}, s));
            }
            return list;
          },
          nb::sig("def periodic(self) -> list[NDArray[numpy.int32]]"),
          "Links of periodic parts of the boundary: vertices and their masters, (n, 2).")
      .def("link_box_faces", &link_box, "axes"_a,
           "Links the vertices of opposite faces of a box along axes, as \"xy\": optimize() moves them together. "
           "Raises MeshError where they do not match.")
      .def(
          "read_periodic_map",
          [](TetMesh& mesh, const std::filesystem::path& path) { read_periodic_map(file_name(path), mesh); }, "path"_a,
          nb::sig("def read_periodic_map(self, path: str | os.PathLike[str]) -> None"),
          "Adds the links of a text file: a line \"translation X Y Z\", then \"VERTEX MASTER\" for each pair, in "
          "numbers from 1.");
}

/// Whether elements have mid-side nodes, and those that are not midpoints.
void bind_second_order(nb::class_<TetMesh>& type) {
  type.def_prop_rw(
          "second_order", [](const TetMesh& mesh) { return mesh.second_order; },
          [](TetMesh& mesh, bool on) {
            if (!on && !mesh.curved_edges.empty()) throw nb::value_error("second_order: the mesh has curved edges");
            mesh.second_order = on;
          },
          "Whether the elements have mid-side nodes; these are not among `points`.")
      .def_prop_ro(
          "second_order_others",
          [](Self s) {
            std::vector<bool> flags;
            for (const ElementBlock& b : of(s).others) flags.push_back(b.second_order);
            return flags;
          },
          "Whether each of `others` has mid-side nodes, if `second_order`.")
      .def_prop_ro(
          "curved_edges", [](Self s) { return view_curved(of(s).curved_edges, &CurvedEdge::vertices, s); },
          "The vertices of the edges whose mid-side node is not the midpoint, (n, 2).")
      .def_prop_ro(
          "curved_middles", [](Self s) { return view_curved(of(s).curved_edges, &CurvedEdge::middle, s); },
          "The positions of these nodes, (n, 3).");
}

}  // namespace

void bind_mesh(nb::module_& m) {
  nb::class_<TetMesh> type(
      m, "TetMesh",
      "A tetrahedral mesh. Its arrays are views of the mesh's own memory, shared and writable; ids are "
      "zero-based.\n\nThe tag 0 means \"no tag\". Tetrahedra that are listed inside out are "
      "reversed. Meshes are copied by copy, and pickled for the same version of tetune, except those of decks "
      "(.inp), whose text a pickle cannot hold.");
  type.def(
      "__init__", &construct, "points"_a, "tets"_a, nb::kw_only(), "point_tags"_a = nb::none(),
      "tet_tags"_a = nb::none(), "triangles"_a = nb::none(), "triangle_tags"_a = nb::none(), "edges"_a = nb::none(),
      "edge_tags"_a = nb::none(), "corners"_a = nb::none(), "required_vertices"_a = nb::none(), "ridges"_a = nb::none(),
      "required_edges"_a = nb::none(), "required_triangles"_a = nb::none(), "required_tets"_a = nb::none(),
      "others"_a = std::vector<Block>{}, "second_order_others"_a = std::vector<bool>{}, "second_order"_a = false,
      "curved_edges"_a = nb::none(), "curved_middles"_a = nb::none(),
      nb::sig("def __init__(self, points: ArrayLike, tets: ArrayLike, *, point_tags: ArrayLike | None = None, "
              "tet_tags: ArrayLike | None = None, triangles: ArrayLike | None = None, "
              "triangle_tags: ArrayLike | None = None, edges: ArrayLike | None = None, "
              "edge_tags: ArrayLike | None = None, corners: ArrayLike | None = None, "
              "required_vertices: ArrayLike | None = None, ridges: ArrayLike | None = None, "
              "required_edges: ArrayLike | None = None, required_triangles: ArrayLike | None = None, "
              "required_tets: ArrayLike | None = None, others: Sequence[tuple[str, ArrayLike]] = ..., "
              "second_order_others: Sequence[bool] = ..., second_order: bool = False, curved_edges: ArrayLike | None = "
              "None, "
              "curved_middles: ArrayLike | None = None) -> None"),
      "Copies the arrays. Each of `others` is a kind of element and the vertices of all elements of that kind; "
      "they do not change. `second_order_others` says which of them have mid-side nodes, if `second_order`. Edges "
      "of second-order elements are straight except `curved_edges`, each with the position of its mid-side node in "
      "`curved_middles`.");
  bind_mesh_arrays(type);
  bind_links(type);
  bind_second_order(type);
  bind_state(type);
  type.def_prop_ro(
          "others",
          [](Self s) {
            nb::list list;
            for (ElementBlock& b : of(s).others) {
              const auto width = static_cast<std::size_t>(b.vertices_per_element);
              list.append(
                  nb::make_tuple(b.kind, nb::ndarray<nb::numpy, Index, nb::ndim<2>>(
                                             b.element2vertex.data(), {b.element2vertex.size() / width, width}, s)));
            }
            return list;
          },
          nb::sig("def others(self) -> list[tuple[str, NDArray[numpy.int32]]]"),
          "Elements of other kinds, each with its vertices.")
      .def(
          "copy", [](const TetMesh& mesh) { return mesh; }, "A mesh of its own memory.")
      .def("__copy__", [](const TetMesh& mesh) { return mesh; })
      .def(
          "__deepcopy__", [](const TetMesh& mesh, nb::handle) { return mesh; }, "memo"_a)
      .def("__repr__", [](const TetMesh& mesh) {
        return "<tetune.TetMesh: " + std::to_string(mesh.points.size()) + " vertices, " +
               std::to_string(mesh.tets.size()) + " tetrahedra, " + std::to_string(mesh.triangles.size()) +
               " listed triangles>";
      });
}

}  // namespace tetune::python

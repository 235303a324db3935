// SPDX-License-Identifier: Apache-2.0
// vtkUnstructuredGrid from TetMesh.
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataSetAttributes.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>

#include "grid.hpp"
#include "grid_names.hpp"
#include "io/losses.hpp"
#include "io/second_order.hpp"
#include "vtk_arrays.hpp"

namespace tetune::plugin {
namespace {

/// The elements of one kind in a grid.
struct Cells {
  std::size_t count;
  const std::vector<int>* tags;
  const std::vector<DataArray>* data;
};

/// Each array over all cells; 0 (or not a number) for kinds without data of that name.
std::vector<DataArray> merged(const std::vector<Cells>& kinds) {
  std::vector<DataArray> all;
  std::size_t done = 0;
  const auto fill = [](DataArray& array, std::size_t cells) {
    std::visit(
        [&](auto& values) {
          using T = typename std::remove_cvref_t<decltype(values)>::value_type;
          values.resize(cells * components_of(array),
                        std::is_floating_point_v<T> ? std::numeric_limits<T>::quiet_NaN() : T{});
        },
        array.values);
  };
  for (const Cells& kind : kinds) {
    for (const DataArray& array : *kind.data) {
      if (kind.count == 0) continue;
      auto at = std::find_if(all.begin(), all.end(), [&](const DataArray& a) { return a.name == array.name; });
      if (at == all.end()) {
        at = all.insert(all.end(), {array.name, array.components, {}});
        std::visit([&](const auto& v) { at->values = std::remove_cvref_t<decltype(v)>(); }, array.values);
      }
      if (at->components != array.components || at->values.index() != array.values.index()) {
        throw FileError("the data \"" + array.name +
                        "\" has another type or number of components on elements of another kind; rename one of them");
      }
      fill(*at, done);
      std::visit(
          [&](auto& to) {
            const auto& from = std::get<std::remove_cvref_t<decltype(to)>>(array.values);
            to.insert(to.end(), from.begin(), from.end());
          },
          at->values);
    }
    done += kind.count;
  }
  for (DataArray& array : all) fill(array, done);
  return all;
}

vtkSmartPointer<vtkDataArray> flags_of(const char* name, const std::vector<Index>& ids, std::size_t first,
                                       std::size_t all) {
  std::vector<std::uint8_t> flags(all, 0);
  for (const Index i : ids) item(flags, first + std::size_t(i)) = 1;
  return to_vtk({name, 1, std::move(flags)});
}

/// The cells of a grid: edges, triangles and tetrahedra, then the other kinds.
struct Layout {
  std::vector<Cells> kinds;
  std::vector<std::size_t> first_of_block{};  ///< position of the first cell of each block of other kinds
};

Layout add_cells(const TetMesh& mesh, const Middles* middles, vtkUnstructuredGrid& grid) {
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkUnsignedCharArray> types;
  Layout layout;
  std::vector<vtkIdType> ids;
  const auto add = [&](const Index* v, std::size_t n, int type) {
    ids.assign(v, v + n);
    cells->InsertNextCell(std::ssize(ids), ids.data());
    types->InsertNextValue(static_cast<unsigned char>(type));
  };
  const auto add_all = [&](const auto& elements, const auto& edges, int type, int second_order_type) {
    std::vector<Index> v;
    for (const auto& element : elements) {
      v.assign(element.begin(), element.end());
      if (middles) {
        for (const Pair& p : edges) {
          v.push_back(middles->of(item(element, p[0]), item(element, p[1])));
        }
      }
      add(v.data(), v.size(), middles ? second_order_type : type);
    }
  };
  add_all(mesh.edges, kEdgeEdges, VTK_LINE, VTK_QUADRATIC_EDGE);
  layout.kinds.push_back({mesh.edges.size(), &mesh.edge_tags, &mesh.edge_data});
  add_all(mesh.triangles, kTriangleEdges, VTK_TRIANGLE, VTK_QUADRATIC_TRIANGLE);
  layout.kinds.push_back({mesh.triangles.size(), &mesh.triangle_tags, &mesh.triangle_data});
  add_all(mesh.tets, kTetEdges, VTK_TETRA, VTK_QUADRATIC_TETRA);
  layout.kinds.push_back({mesh.tets.size(), &mesh.tet_tags, &mesh.tet_data});
  for (const ElementBlock& block : mesh.others) {
    const std::size_t list = list_of(mesh, block);
    if (list == kOtherLists) throw FileError("VTK has no cells for elements of kind " + block.kind);
    layout.first_of_block.push_back(std::size_t(cells->GetNumberOfCells()));
    const std::span<const Pair> edges = middle_edges(mesh, block, MiddleOrder::base_top_between);
    const std::size_t each = std::size_t(block.vertices_per_element) + edges.size();
    std::array<Index, kMaxNodes> nodes{};
    for (std::size_t i = 0; i < block.tags.size(); ++i) {
      list_other(block, i, middles, edges, nodes);
      add(nodes.data(), each, kOtherTypes[list]);
    }
    layout.kinds.push_back({block.tags.size(), &block.tags, &block.data});
  }
  grid.SetCells(types, cells);
  return layout;
}

/// Adds tags, before data: one with their name is renamed, as by use_as_tags(), with a warning.
void add_tags(std::vector<int> tags, const std::string& own_name, const char* entities, std::vector<DataArray>& data,
              vtkDataSetAttributes& attributes, Warnings& warnings) {
  const std::string name = own_name.empty() ? kOwnTags : own_name;
  const auto find = [&data](const std::string& text) {
    return std::find_if(data.begin(), data.end(), [&](const DataArray& array) { return array.name == text; });
  };
  if (const auto same = find(name); same != data.end()) {
    std::string other = name;
    while (find(other) != data.end()) other += ":before";
    warnings.push_back(std::string("the ") + entities + " data \"" + name + "\" are renamed to \"" + other +
                       "\", as tags have this name");
    same->name = other;
  }
  attributes.AddArray(to_vtk({name, 1, std::move(tags)}));
}

void add_cell_data(const TetMesh& mesh, const Layout& layout, vtkUnstructuredGrid& grid, Warnings& warnings) {
  std::vector<int> tags;
  for (const Cells& kind : layout.kinds) tags.insert(tags.end(), kind.tags->begin(), kind.tags->end());
  const std::size_t all = tags.size();
  std::vector<DataArray> data = merged(layout.kinds);
  if (has_tag(tags) || !mesh.cell_tags_name.empty()) {
    add_tags(std::move(tags), mesh.cell_tags_name, "cell", data, *grid.GetCellData(), warnings);
  }
  for (const DataArray& array : data) grid.GetCellData()->AddArray(to_vtk(array));
  const auto add_flags = [&](const char* name, const std::vector<Index>& list, std::size_t first) {
    if (!list.empty()) grid.GetCellData()->AddArray(flags_of(name, list, first, all));
  };
  std::vector<Index> required_quads;
  add_flags(kRequiredEdges, mesh.required_edges, 0);
  add_flags(kRidges, mesh.ridges, 0);
  add_flags(kRequiredTriangles, mesh.required_triangles, mesh.edges.size());
  add_flags(kRequiredTets, mesh.required_tets, mesh.edges.size() + mesh.triangles.size());
  for (std::size_t b = 0; b < mesh.others.size(); ++b) {
    if (mesh.others[b].kind != "Quadrilaterals") continue;
    for (const Index i : mesh.others[b].required) required_quads.push_back(Index(layout.first_of_block[b]) + i);
  }
  add_flags(kRequiredQuads, required_quads, 0);
}

void add_point_data(TetMesh& mesh, vtkUnstructuredGrid& grid, Warnings& warnings) {
  if (has_tag(mesh.point_tags) || !mesh.point_tags_name.empty()) {
    add_tags(mesh.point_tags, mesh.point_tags_name, "point", mesh.point_data, *grid.GetPointData(), warnings);
  }
  for (const DataArray& array : mesh.point_data) grid.GetPointData()->AddArray(to_vtk(array));
  for (const PointFlags& flags : kPointFlags) {
    if ((mesh.*flags.ids).empty()) continue;
    grid.GetPointData()->AddArray(flags_of(flags.name, mesh.*flags.ids, 0, mesh.points.size()));
  }
}

}  // namespace

vtkSmartPointer<vtkUnstructuredGrid> to_grid(TetMesh mesh, Warnings& warnings) {
  const auto middles = mesh.second_order ? std::make_unique<Middles>(mesh) : nullptr;
  warn_of_names(mesh, {0, &warnings});
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(std::ssize(mesh.points));
  vtkIdType next = 0;
  for (const Point3& x : mesh.points) points->SetPoint(next++, x.data());
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  const Layout layout = add_cells(mesh, middles.get(), *grid);
  add_cell_data(mesh, layout, *grid, warnings);
  add_point_data(mesh, *grid, warnings);
  return grid;
}

}  // namespace tetune::plugin

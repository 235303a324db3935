// SPDX-License-Identifier: Apache-2.0
// TetMesh from and to vtkUnstructuredGrid.
#include "grid.hpp"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>

#include "second_order.hpp"
#include "vtk_arrays.hpp"

namespace tetune::plugin {
namespace {

constexpr std::array<int, 5> kOtherTypes{VTK_VERTEX, VTK_QUAD, VTK_PYRAMID, VTK_WEDGE, VTK_HEXAHEDRON};
constexpr const char* kOwnTags = "medit:ref";

/// Flags under the names that Mmg's Python package gives them.
struct PointFlags {
  const char* name;
  std::vector<Index> TetMesh::*ids;
};
constexpr std::array<PointFlags, 2> kPointFlags{
    {{"mmg_required_vertices", &TetMesh::required_vertices}, {"mmg_corners", &TetMesh::corners}}};
constexpr const char* kRequiredEdges = "mmg_required_edges";
constexpr const char* kRidges = "mmg_ridge_edges";
constexpr const char* kRequiredTriangles = "mmg_required_triangles";
constexpr const char* kRequiredTets = "mmg_required_tetrahedra";
constexpr const char* kRequiredQuads = "mmg_required_quadrilaterals";

/// The cells of a grid by kind, in order.
class Reader {
 public:
  Reader(vtkUnstructuredGrid* grid, TetMesh& mesh, Warnings& warnings) : grid_(grid), mesh_(mesh), warnings_(warnings) {
    for (const OtherKind& kind : kOtherKinds) others_.push_back({kind.name, kind.vertices, {}, {}, {}});
  }

  void read() {
    read_points();
    // Copies of the elements of another part.
    vtkUnsignedCharArray* ghosts = grid_->GetCellGhostArray();
    for (vtkIdType c = 0; c < grid_->GetNumberOfCells(); ++c) {
      if (ghosts == nullptr || (ghosts->GetValue(c) & vtkDataSetAttributes::DUPLICATECELL) == 0) read_cell(c);
    }
    read_point_data();
    read_cell_data();
    leave_out(middles_, mesh_);
    for (std::size_t i = 0; i < others_.size(); ++i) {
      if (!others_[i].element2vertex.empty()) mesh_.others.push_back(std::move(others_[i]));
    }
  }

 private:
  void read_points() {
    const vtkIdType n = grid_->GetNumberOfPoints();
    if (n > std::numeric_limits<Index>::max()) throw FileError("more than 2^31 points");
    mesh_.points.resize(static_cast<std::size_t>(n));
    for (vtkIdType i = 0; i < n; ++i) grid_->GetPoint(i, mesh_.points[static_cast<std::size_t>(i)].data());
  }

  void read_cell(vtkIdType c) {
    vtkIdType n = 0;
    const vtkIdType* ids = nullptr;
    grid_->GetCellPoints(c, n, ids);
    std::array<Index, 10> v{};
    const int type = grid_->GetCellType(c);
    const int wanted = size_of(type);
    if (wanted < 0 || (type == VTK_POLY_VERTEX && n != 1)) {
      throw FileError("cell " + std::to_string(c) + " is of VTK's type " + std::to_string(type) +
                      ", which tetune does not take: tetrahedra (of first or second order), triangles, lines, "
                      "vertices, quadrilaterals, pyramids, wedges and hexahedra");
    }
    if (n != wanted) {
      throw FileError("cell " + std::to_string(c) + " of VTK's type " + std::to_string(type) + " has " +
                      std::to_string(n) + " points");
    }
    for (vtkIdType k = 0; k < n; ++k) {
      if (ids[k] < 0 || ids[k] >= grid_->GetNumberOfPoints()) {
        throw FileError("cell " + std::to_string(c) + " names point " + std::to_string(ids[k]) + "; there are " +
                        std::to_string(grid_->GetNumberOfPoints()));
      }
      v[static_cast<std::size_t>(k)] = static_cast<Index>(ids[k]);
    }
    switch (type) {
      case VTK_QUADRATIC_TETRA:
        add_middles(v, 4, kTetEdges);
        [[fallthrough]];
      case VTK_TETRA:
        mesh_.tets.push_back({v[0], v[1], v[2], v[3]});
        tets_.push_back(c);
        return;
      case VTK_QUADRATIC_TRIANGLE:
        add_middles(v, 3, kTriangleEdges);
        [[fallthrough]];
      case VTK_TRIANGLE:
        mesh_.triangles.push_back({v[0], v[1], v[2]});
        triangles_.push_back(c);
        return;
      case VTK_QUADRATIC_EDGE:
        add_middles(v, 2, kEdgeEdges);
        [[fallthrough]];
      case VTK_LINE:
        mesh_.edges.push_back({v[0], v[1]});
        edges_.push_back(c);
        return;
      default:
        break;
    }
    // A pixel and a voxel are a quadrilateral and a hexahedron in another order.
    if (type == VTK_PIXEL || type == VTK_VOXEL) std::swap(v[2], v[3]);
    if (type == VTK_VOXEL) std::swap(v[6], v[7]);
    const int plain = type == VTK_PIXEL         ? VTK_QUAD
                      : type == VTK_VOXEL       ? VTK_HEXAHEDRON
                      : type == VTK_POLY_VERTEX ? VTK_VERTEX
                                                : type;
    const auto k =
        static_cast<std::size_t>(std::find(kOtherTypes.begin(), kOtherTypes.end(), plain) - kOtherTypes.begin());
    others_[k].element2vertex.insert(others_[k].element2vertex.end(), v.begin(), v.begin() + n);
    other_cells_[k].push_back(c);
  }

  static int size_of(int type) {
    switch (type) {
      case VTK_VERTEX:
      case VTK_POLY_VERTEX:
        return 1;
      case VTK_LINE:
        return 2;
      case VTK_TRIANGLE:
      case VTK_QUADRATIC_EDGE:
        return 3;
      case VTK_QUAD:
      case VTK_PIXEL:
      case VTK_TETRA:
        return 4;
      case VTK_PYRAMID:
        return 5;
      case VTK_WEDGE:
      case VTK_QUADRATIC_TRIANGLE:
        return 6;
      case VTK_HEXAHEDRON:
      case VTK_VOXEL:
        return 8;
      case VTK_QUADRATIC_TETRA:
        return 10;
      default:
        return -1;
    }
  }

  template <std::size_t N>
  void add_middles(const std::array<Index, 10>& v, std::size_t corners, const std::array<Pair, N>& edges) {
    for (std::size_t e = 0; e < N; ++e) {
      middles_.push_back(
          {v[corners + e], {v[static_cast<std::size_t>(edges[e][0])], v[static_cast<std::size_t>(edges[e][1])]}});
    }
  }

  void read_point_data() {
    mesh_.point_data = arrays_of(grid_->GetPointData(), "vertices", warnings_);
    mesh_.point_tags = take_tags(mesh_.point_data, mesh_.point_tags_name, warnings_);
    mesh_.point_tags.resize(mesh_.points.size(), 0);
    for (const PointFlags& flags : kPointFlags) {
      for (const vtkIdType v : take_flags(mesh_.point_data, flags.name)) {
        (mesh_.*flags.ids).push_back(static_cast<Index>(v));
      }
    }
  }

  void read_cell_data() {
    std::vector<DataArray> data = arrays_of(grid_->GetCellData(), "cells", warnings_);
    std::vector<int> tags = take_tags(data, mesh_.cell_tags_name, warnings_);
    tags.resize(static_cast<std::size_t>(grid_->GetNumberOfCells()), 0);
    const auto flags = [&data](const char* name, const std::vector<vtkIdType>& cells, std::vector<Index>& ids) {
      for (const vtkIdType c : take_flags(data, name)) {
        const auto at = std::lower_bound(cells.begin(), cells.end(), c);
        if (at != cells.end() && *at == c) ids.push_back(static_cast<Index>(at - cells.begin()));
      }
    };
    flags(kRequiredEdges, edges_, mesh_.required_edges);
    flags(kRidges, edges_, mesh_.ridges);
    flags(kRequiredTriangles, triangles_, mesh_.required_triangles);
    flags(kRequiredTets, tets_, mesh_.required_tets);
    flags(kRequiredQuads, other_cells_[1], others_[1].required);
    const auto take = [&](const std::vector<vtkIdType>& cells, std::vector<int>& own,
                          std::vector<DataArray>& own_data) {
      for (const vtkIdType c : cells) own.push_back(tags[static_cast<std::size_t>(c)]);
      if (cells.empty()) return;
      for (const DataArray& array : data) own_data.push_back(entries(array, cells));
    };
    take(tets_, mesh_.tet_tags, mesh_.tet_data);
    take(triangles_, mesh_.triangle_tags, mesh_.triangle_data);
    take(edges_, mesh_.edge_tags, mesh_.edge_data);
    for (std::size_t k = 0; k < others_.size(); ++k) take(other_cells_[k], others_[k].tags, others_[k].data);
  }

  vtkUnstructuredGrid* grid_;
  TetMesh& mesh_;
  Warnings& warnings_;
  std::vector<vtkIdType> tets_, triangles_, edges_;
  std::vector<ElementBlock> others_;
  std::array<std::vector<vtkIdType>, 5> other_cells_;
  std::vector<Middle> middles_;
};

/// The elements of one kind on their way into a grid.
struct Cells {
  std::size_t count;
  const std::vector<int>* tags;
  const std::vector<DataArray>* data;
};

/// Each array over all cells; 0 (or not a number) where a kind has none of that name.
std::vector<DataArray> merged(const std::vector<Cells>& kinds) {
  std::vector<DataArray> all;
  std::size_t done = 0;
  const auto fill = [](DataArray& array, std::size_t cells) {
    std::visit(
        [&](auto& values) {
          using T = typename std::remove_cvref_t<decltype(values)>::value_type;
          values.resize(cells * static_cast<std::size_t>(array.components),
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
  for (const Index i : ids) flags[first + static_cast<std::size_t>(i)] = 1;
  return to_vtk({name, 1, std::move(flags)});
}

bool any(const std::vector<int>& tags) {
  return std::any_of(tags.begin(), tags.end(), [](int t) { return t != 0; });
}

}  // namespace

TetMesh from_grid(vtkUnstructuredGrid* grid, Warnings& warnings) {
  TetMesh mesh;
  Reader(grid, mesh, warnings).read();
  const vtkFieldData* none = nullptr;
  if (vtkFieldData* fields = grid->GetFieldData(); fields != none) {
    for (int i = 0; i < fields->GetNumberOfArrays(); ++i) {
      warnings.push_back("the field data \"" + std::string(fields->GetArrayName(i)) + "\" is not kept");
    }
  }
  return mesh;
}

void merge_points(TetMesh& mesh) {
  std::vector<vtkIdType> order(mesh.points.size());
  std::iota(order.begin(), order.end(), vtkIdType{0});
  const auto at = [&mesh](vtkIdType v) -> const Point3& { return mesh.points[static_cast<std::size_t>(v)]; };
  std::stable_sort(order.begin(), order.end(), [&at](vtkIdType a, vtkIdType b) { return at(a) < at(b); });
  std::vector<vtkIdType> first(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && at(order[i]) == at(order[i - 1]);
    first[static_cast<std::size_t>(order[i])] = same ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  std::vector<Index> old2new(order.size());
  std::vector<vtkIdType> kept;
  for (std::size_t v = 0; v < first.size(); ++v) {
    const auto owner = static_cast<std::size_t>(first[v]);
    if (owner == v) kept.push_back(static_cast<vtkIdType>(v));
    old2new[v] = owner == v ? static_cast<Index>(kept.size() - 1) : old2new[owner];
  }
  if (kept.size() == first.size()) return;
  for (std::size_t v = 0; v < kept.size(); ++v) {
    mesh.points[v] = at(kept[v]);
    mesh.point_tags[v] = mesh.point_tags[static_cast<std::size_t>(kept[v])];
  }
  mesh.points.resize(kept.size());
  mesh.point_tags.resize(kept.size());
  for (DataArray& array : mesh.point_data) array = entries(array, kept);
  const auto renumber = [&old2new](auto& ids) {
    for (Index& v : ids) v = old2new[static_cast<std::size_t>(v)];
  };
  for (auto& tet : mesh.tets) renumber(tet);
  for (auto& triangle : mesh.triangles) renumber(triangle);
  for (auto& edge : mesh.edges) renumber(edge);
  for (ElementBlock& block : mesh.others) renumber(block.element2vertex);
  for (std::vector<Index>* ids : {&mesh.corners, &mesh.required_vertices}) {
    renumber(*ids);
    std::sort(ids->begin(), ids->end());
    ids->erase(std::unique(ids->begin(), ids->end()), ids->end());
  }
}

vtkSmartPointer<vtkUnstructuredGrid> to_grid(TetMesh mesh, Warnings& warnings) {
  const auto middles = mesh.second_order ? std::make_unique<Middles>(mesh) : nullptr;
  if (std::any_of(mesh.groups.begin(), mesh.groups.end(), [](const Group& g) { return !g.name.empty(); })) {
    warnings.push_back("VTK's files have no room for the names of groups");
  }
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    points->SetPoint(static_cast<vtkIdType>(v), mesh.points[v].data());
  }
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);

  // Points, edges, triangles and tetrahedra, then the other kinds.
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkUnsignedCharArray> types;
  std::vector<Cells> kinds;
  std::vector<vtkIdType> ids;
  const auto add = [&](const Index* v, std::size_t n, int type) {
    ids.assign(v, v + n);
    cells->InsertNextCell(static_cast<vtkIdType>(ids.size()), ids.data());
    types->InsertNextValue(static_cast<unsigned char>(type));
  };
  const auto add_all = [&](const auto& elements, const auto& edges, int type, int second_order_type) {
    std::vector<Index> v;
    for (const auto& element : elements) {
      v.assign(element.begin(), element.end());
      if (middles) {
        for (const Pair& p : edges) {
          v.push_back(middles->of(element[static_cast<std::size_t>(p[0])], element[static_cast<std::size_t>(p[1])]));
        }
      }
      add(v.data(), v.size(), middles ? second_order_type : type);
    }
  };
  add_all(mesh.edges, kEdgeEdges, VTK_LINE, VTK_QUADRATIC_EDGE);
  kinds.push_back({mesh.edges.size(), &mesh.edge_tags, &mesh.edge_data});
  add_all(mesh.triangles, kTriangleEdges, VTK_TRIANGLE, VTK_QUADRATIC_TRIANGLE);
  kinds.push_back({mesh.triangles.size(), &mesh.triangle_tags, &mesh.triangle_data});
  add_all(mesh.tets, kTetEdges, VTK_TETRA, VTK_QUADRATIC_TETRA);
  kinds.push_back({mesh.tets.size(), &mesh.tet_tags, &mesh.tet_data});
  std::size_t first_quad = 0;
  for (const ElementBlock& block : mesh.others) {
    const auto kind = std::find_if(std::begin(kOtherKinds), std::end(kOtherKinds),
                                   [&block](const OtherKind& k) { return k.name == block.kind; });
    if (kind == std::end(kOtherKinds)) throw FileError("VTK has no cells for elements of kind " + block.kind);
    const int type = kOtherTypes[static_cast<std::size_t>(kind - std::begin(kOtherKinds))];
    if (type == VTK_QUAD) first_quad = static_cast<std::size_t>(cells->GetNumberOfCells());
    const auto each = static_cast<std::size_t>(kind->vertices);
    for (std::size_t i = 0; i < block.tags.size(); ++i) add(block.element2vertex.data() + i * each, each, type);
    kinds.push_back({block.tags.size(), &block.tags, &block.data});
  }
  grid->SetCells(types, cells);

  std::vector<int> tags;
  for (const Cells& kind : kinds) tags.insert(tags.end(), kind.tags->begin(), kind.tags->end());
  const std::size_t all = tags.size();
  const auto own_name = [](const std::string& name) { return name.empty() ? kOwnTags : name; };
  if (any(tags) || !mesh.cell_tags_name.empty()) {
    grid->GetCellData()->AddArray(to_vtk({own_name(mesh.cell_tags_name), 1, std::move(tags)}));
  }
  for (const DataArray& array : merged(kinds)) grid->GetCellData()->AddArray(to_vtk(array));
  const auto add_flags = [&](const char* name, const std::vector<Index>& list, std::size_t first) {
    if (!list.empty()) grid->GetCellData()->AddArray(flags_of(name, list, first, all));
  };
  add_flags(kRequiredEdges, mesh.required_edges, 0);
  add_flags(kRidges, mesh.ridges, 0);
  add_flags(kRequiredTriangles, mesh.required_triangles, mesh.edges.size());
  add_flags(kRequiredTets, mesh.required_tets, mesh.edges.size() + mesh.triangles.size());
  for (const ElementBlock& block : mesh.others) {
    if (block.kind == "Quadrilaterals") add_flags(kRequiredQuads, block.required, first_quad);
  }

  if (any(mesh.point_tags) || !mesh.point_tags_name.empty()) {
    grid->GetPointData()->AddArray(to_vtk({own_name(mesh.point_tags_name), 1, mesh.point_tags}));
  }
  for (const DataArray& array : mesh.point_data) grid->GetPointData()->AddArray(to_vtk(array));
  for (const PointFlags& flags : kPointFlags) {
    if ((mesh.*flags.ids).empty()) continue;
    grid->GetPointData()->AddArray(flags_of(flags.name, mesh.*flags.ids, 0, mesh.points.size()));
  }
  return grid;
}

}  // namespace tetune::plugin

// SPDX-License-Identifier: Apache-2.0
// TetMesh from vtkUnstructuredGrid.
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <limits>

#include "grid.hpp"
#include "grid_names.hpp"
#include "io/second_order.hpp"
#include "pieces.hpp"
#include "vtk_arrays.hpp"

namespace tetune::plugin {
namespace {

/// The cells of a grid by kind, in order.
class GridReader {
 public:
  GridReader(vtkUnstructuredGrid* grid, TetMesh& mesh, Warnings& warnings)
      : grid_(grid), mesh_(mesh), warnings_(warnings) {}

  /// Points of several pieces are merged before the mid-side nodes are checked: both copies of such a node are one.
  void read(Pieces pieces) {
    read_points();
    // Ghost cells are copies of the elements of another part.
    vtkUnsignedCharArray* ghosts = grid_->GetCellGhostArray();
    for (vtkIdType c = 0; c < grid_->GetNumberOfCells(); ++c) {
      if (ghosts == nullptr || (ghosts->GetValue(c) & vtkDataSetAttributes::DUPLICATECELL) == 0) read_cell(c);
    }
    read_point_data();
    read_cell_data();
    for (std::size_t i = 0; i < others_.size(); ++i) {
      if (!others_[i].element2vertex.empty()) mesh_.others.push_back(std::move(others_[i]));
    }
    if (pieces == Pieces::several) join();
    for (std::string& warning : erase_middles(middles_, mesh_)) warnings_.push_back(std::move(warning));
  }

 private:
  void read_points() {
    const vtkIdType n = grid_->GetNumberOfPoints();
    if (n > std::numeric_limits<Index>::max()) throw FileError("more than 2^31 points");
    mesh_.points.resize(std::size_t(n));
    for (vtkIdType i = 0; i < n; ++i) grid_->GetPoint(i, item(mesh_.points, i).data());
  }

  /// Reads and checks the vertices of a cell.
  std::array<Index, kMaxNodes> vertices_of(vtkIdType c, int type) const {
    vtkIdType n = 0;
    const vtkIdType* ids = nullptr;
    grid_->GetCellPoints(c, n, ids);
    std::array<Index, kMaxNodes> v{};
    const int expected = size_of(type);
    if (expected < 0 || (type == VTK_POLY_VERTEX && n != 1)) {
      const std::string found = "cell " + std::to_string(c) + " is of VTK's type " + std::to_string(type);
      if (has_nodes_on_faces(type)) throw FileError(found + ": " + kNodesOnFaces);
      throw FileError(found +
                      ", which tetune does not read; it reads vertices, and lines, triangles, tetrahedra, "
                      "quadrilaterals, pyramids, wedges and hexahedra of first or second order");
    }
    if (n != expected) {
      throw FileError("cell " + std::to_string(c) + " of VTK's type " + std::to_string(type) + " has " +
                      std::to_string(n) + " points");
    }
    for (vtkIdType k = 0; k < n; ++k) {
      if (ids[k] < 0 || ids[k] >= grid_->GetNumberOfPoints()) {
        throw FileError("cell " + std::to_string(c) + " has point " + std::to_string(ids[k]) + "; there are " +
                        std::to_string(grid_->GetNumberOfPoints()));
      }
      item(v, k) = Index(ids[k]);
    }
    return v;
  }

  void read_cell(vtkIdType c) {
    const int type = grid_->GetCellType(c);
    std::array<Index, kMaxNodes> v = vertices_of(c, type);
    const std::span<const Index> nodes = std::span(v).first(std::size_t(size_of(type)));
    switch (type) {
      case VTK_QUADRATIC_TETRA:
        add_middles(nodes, kTetEdges, middles_);
        [[fallthrough]];
      case VTK_TETRA:
        mesh_.tets.push_back({v[0], v[1], v[2], v[3]});
        tets_.push_back(c);
        return;
      case VTK_QUADRATIC_TRIANGLE:
        add_middles(nodes, kTriangleEdges, middles_);
        [[fallthrough]];
      case VTK_TRIANGLE:
        mesh_.triangles.push_back({v[0], v[1], v[2]});
        triangles_.push_back(c);
        return;
      case VTK_QUADRATIC_EDGE:
        add_middles(nodes, kEdgeEdges, middles_);
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
    const std::size_t k(std::find(kOtherTypes.begin(), kOtherTypes.end(), plain) - kOtherTypes.begin());
    ElementBlock& block = others_[k];
    block.element2vertex.insert(block.element2vertex.end(), v.begin(), v.begin() + block.vertices_per_element);
    other_cells_[k].push_back(c);
    if (block.second_order) add_middles(nodes, kind_of_list(k).edges, middles_);
  }

  /// Joins the pieces. Flags of copies say nothing of the whole mesh.
  void join() {
    std::vector<bool> duplicates(mesh_.points.size(), false);
    if (vtkUnsignedCharArray* ghosts = grid_->GetPointGhostArray(); ghosts != nullptr) {
      for (std::size_t v = 0; v < duplicates.size(); ++v) {
        duplicates[v] = (ghosts->GetValue(vtkIdType(v)) & vtkDataSetAttributes::DUPLICATEPOINT) != 0;
      }
    }
    std::vector<std::vector<DataArray>*> lists{&mesh_.point_data, &mesh_.tet_data, &mesh_.triangle_data,
                                               &mesh_.edge_data};
    for (ElementBlock& block : mesh_.others) lists.push_back(&block.data);
    for (auto* data : lists) {
      std::erase_if(*data, [](const DataArray& a) { return a.name == vtkDataSetAttributes::GhostArrayName(); });
    }
    if (const std::size_t torn = merge_points(mesh_, duplicates, middles_.nodes); torn > 0) {
      warnings_.push_back(std::to_string(torn) +
                          " points are nearer to a point of another piece than 1e-9 of the diagonal, but not at the "
                          "same position: there the pieces are apart, as points are merged where all bits are equal");
    }
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
      case VTK_QUADRATIC_QUAD:
        return 8;
      case VTK_QUADRATIC_TETRA:
        return 10;
      case VTK_QUADRATIC_PYRAMID:
        return 13;
      case VTK_QUADRATIC_WEDGE:
        return 15;
      case VTK_QUADRATIC_HEXAHEDRON:
        return 20;
      default:
        return -1;
    }
  }
  /// Whether a type is a quadrilateral, pyramid, wedge or hexahedron with nodes in the middles of faces.
  static bool has_nodes_on_faces(int type) {
    return type == VTK_BIQUADRATIC_QUAD || type == VTK_TRIQUADRATIC_PYRAMID || type == VTK_TRIQUADRATIC_HEXAHEDRON ||
           type == VTK_BIQUADRATIC_QUADRATIC_WEDGE || type == VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON;
  }

  void read_point_data() {
    mesh_.point_data = arrays_of(grid_->GetPointData(), "vertices", warnings_);
    mesh_.point_tags = take_tags(mesh_.point_data, mesh_.point_tags_name, warnings_);
    mesh_.point_tags.resize(mesh_.points.size(), 0);
    for (const PointFlags& flags : kPointFlags) {
      for (const vtkIdType v : take_flags(mesh_.point_data, flags.name)) {
        (mesh_.*flags.ids).push_back(Index(v));
      }
    }
  }

  void read_cell_data() {
    std::vector<DataArray> data = arrays_of(grid_->GetCellData(), "cells", warnings_);
    std::vector<int> tags = take_tags(data, mesh_.cell_tags_name, warnings_);
    tags.resize(std::size_t(grid_->GetNumberOfCells()), 0);
    const auto add_flagged = [](const std::vector<vtkIdType>& flagged, const std::vector<vtkIdType>& cells,
                                std::vector<Index>& ids) {
      for (const vtkIdType c : flagged) {
        const auto at = std::lower_bound(cells.begin(), cells.end(), c);
        if (at != cells.end() && *at == c) ids.push_back(Index(at - cells.begin()));
      }
    };
    const auto flags = [&](const char* name, const std::vector<vtkIdType>& cells, std::vector<Index>& ids) {
      add_flagged(take_flags(data, name), cells, ids);
    };
    flags(kRequiredEdges, edges_, mesh_.required_edges);
    flags(kRidges, edges_, mesh_.ridges);
    flags(kRequiredTriangles, triangles_, mesh_.required_triangles);
    flags(kRequiredTets, tets_, mesh_.required_tets);
    const std::vector<vtkIdType> required_quads = take_flags(data, kRequiredQuads);
    for (std::size_t k = 0; k < others_.size(); ++k) {
      if (kind_of_list(k).dimension == 2) add_flagged(required_quads, other_cells_[k], others_[k].required);
    }
    const auto take = [&](const std::vector<vtkIdType>& cells, std::vector<int>& own,
                          std::vector<DataArray>& own_data) {
      for (const vtkIdType c : cells) own.push_back(item(tags, c));
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
  std::vector<ElementBlock> others_ = blocks_of_lists();
  std::array<std::vector<vtkIdType>, kOtherLists> other_cells_;
  MiddleList middles_;
};

}  // namespace

TetMesh from_grid(vtkUnstructuredGrid* grid, Pieces pieces, Warnings& warnings) {
  TetMesh mesh;
  GridReader(grid, mesh, warnings).read(pieces);
  vtkFieldData* const fields = grid->GetFieldData();
  for (int i = 0; fields != nullptr && i < fields->GetNumberOfArrays(); ++i) {
    const char* const name = fields->GetArrayName(i);
    warnings.push_back("the field data \"" + std::string(name != nullptr ? name : "") + "\" is not kept");
  }
  return mesh;
}

}  // namespace tetune::plugin

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tetune/export.hpp"
#include "tetune/mesh.hpp"
#include "tetune/report.hpp"

namespace tetune {

/// Gathers the entries `new2old` of each array, in that order. optimize() transfers the data of tetrahedra in this way
/// (by Report::tet2original), and those of triangles and of edges. The entry of -1 is zeros. Throws MeshError if
/// another entry is out of range or an array has no components.
TETUNE_API std::vector<DataArray> take_entries(const std::vector<DataArray>& data, const std::vector<Index>& new2old);

/// Transfers data of vertices to a mesh in which vertices were inserted and removed, as optimize() does: each vertex
/// keeps its entry wherever it has moved. `vertex2original` is as in Report; if it is empty, the data is returned as
/// is.
///
/// An inserted vertex (-1) gets a mean of the vertices with which it shares tetrahedra, by mean value coordinates (Ju,
/// Schaefer, Warren 2005), which reproduce linear fields exactly and stay within the neighbors' values. Its integer
/// values are those of the nearest vertex with which it shares an edge, through other inserted vertices if necessary.
///
/// `points` and `tets` are those of the result. Throws MeshError if an entry is out of range, an array has no
/// components, or `vertex2original` is not as long as `points`.
TETUNE_API std::vector<DataArray> carry_point_data(const std::vector<DataArray>& data,
                                                   const std::vector<Index>& vertex2original,
                                                   const std::vector<Point3>& points,
                                                   const std::vector<std::array<Index, 4>>& tets);

/// Evaluates data of the vertices of a mesh at places in it, as optimize() does with DataTransfer::interpolate:
/// floating-point values linearly, so that linear fields are exact up to rounding and no value is outside those of the
/// four vertices; integers, and values that are not finite, are those of the vertex of the largest weight. Throws
/// MeshError if an entry is out of range or an array has no components.
TETUNE_API std::vector<DataArray> interpolate_point_data(const std::vector<DataArray>& data,
                                                         const std::vector<MeshPlace>& places);

/// Data of the vertices and tetrahedra of a result.
struct ConservedData {
  std::vector<DataArray> point_data, tet_data;
  double uncovered = 0;  ///< part of the input's volume that no tetrahedron of the result covers
};

/// Transfers the data of vertices and tetrahedra of `input` to a result of it, as optimize() does with
/// DataTransfer::conserve, over the intersections of tetrahedra (docs/method.md, "Conservative transfer").
///
/// With the vertices of the result at their places in the input, floating-point data keep their integral over each
/// region to rounding, where both meshes fill it, and get no value outside those of the input around it. Data of
/// tetrahedra are means by overlap; data of vertices are the L2 projection of the linear field, exact for linear
/// fields, limited where it would exceed the bounds. Integers are those of the tetrahedron of the largest overlap, and
/// of the vertex of the largest weight; so are values beside ones that are not finite. Tetrahedra with the same
/// vertices at the same places, and their vertices, keep the bits of their data.
///
/// `tets`, `tet2original` and `places` describe the result, as in Report. `threads` 0 means all; the values do not
/// depend on it. Throws MeshError if an array is too short or has no components, or an id is out of range.
TETUNE_API ConservedData conserve_data(const TetMesh& input, const std::vector<std::array<Index, 4>>& tets,
                                       const std::vector<Index>& tet2original, const std::vector<MeshPlace>& places,
                                       int threads = 0);

/// Copies the cell data of this name to the tags of tetrahedra, triangles, edges and other elements. Former tags other
/// than 0 become data, under their name with ":before" appended.
///
/// Each value must be a 32-bit integer; NaN counts as 0, "no tag", as does each element of a kind without such data.
/// Throws OptionError if the tetrahedra have no data of this name or other values, and if the mesh has groups, which
/// name its present tags.
TETUNE_API void use_as_tags(TetMesh& mesh, const std::string& name);

}  // namespace tetune

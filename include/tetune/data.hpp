// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// The entries `new2old` of each array, in that order. optimize() does so with the data of tetrahedra (by
/// Report::tet2original), of triangles and of edges. Throws MeshError when an entry is not there or has no components.
std::vector<DataArray> take_entries(const std::vector<DataArray>& data, const std::vector<Index>& new2old);

/// Data of vertices after some were inserted and removed, as optimize() does it: each vertex keeps its entry wherever
/// it has moved (`vertex2original` as in Report; empty: all were kept, and the data is handed back as it is).
///
/// An inserted vertex (-1) gets a mean of the vertices that it shares tetrahedra with, by mean value coordinates (Ju,
/// Schaefer, Warren 2005): its floating-point values are those of any linear field, and lie within its neighbours'. Its
/// integer values are those of the nearest vertex that it shares an edge with, through other inserted ones if need be.
///
/// `points` and `tets` are the result's. Throws MeshError when an entry is not there or has no components, and when
/// `vertex2original` is not as long as `points`.
std::vector<DataArray> carry_point_data(const std::vector<DataArray>& data, const std::vector<Index>& vertex2original,
                                        const std::vector<Point3>& points,
                                        const std::vector<std::array<Index, 4>>& tets);

/// Makes the cell data of this name the tags of tetrahedra, triangles, edges and other elements; they are data still.
/// What were tags, if there were any, become data too, under the name that they had with ":before" after it.
///
/// Each value must be one whole number of 32 bits; what is not a number counts as 0, "no tag", as does each element of
/// a kind without such data. Throws OptionError where no tetrahedra have data of this name or the values are others,
/// and where the mesh has groups, which name the tags that it has.
void use_as_tags(TetMesh& mesh, const std::string& name);

}  // namespace tetune

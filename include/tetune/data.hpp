// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "tetune/mesh.hpp"

namespace tetune {

/// The entries `new2old` of each array, in that order. optimize() does so with the data of tetrahedra (by
/// Report::tet2original), of triangles and of edges. Throws MeshError when an entry is not there.
std::vector<DataArray> take_entries(const std::vector<DataArray>& data, const std::vector<Index>& new2old);

/// Data of vertices after some were inserted and removed, as optimize() does it: each vertex keeps its entry wherever
/// it has moved (`vertex2original` as in Report; empty: all were kept, and the data is handed back as it is).
///
/// An inserted vertex (-1) gets a mean of the vertices that it shares tetrahedra with, by mean value coordinates (Ju,
/// Schaefer, Warren 2005): its floating-point values are those of any linear field, and lie within its neighbours'. Its
/// integer values are those of the nearest vertex that it shares an edge with, through other inserted ones if need be.
///
/// `points` and `tets` are the result's. Throws MeshError when an entry is not there.
std::vector<DataArray> carry_point_data(const std::vector<DataArray>& data, const std::vector<Index>& vertex2original,
                                        const std::vector<Point3>& points,
                                        const std::vector<std::array<Index, 4>>& tets);

}  // namespace tetune

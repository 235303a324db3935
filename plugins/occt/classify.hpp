// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/geometry/geometry_stream.hpp"
#include "workers.hpp"

namespace tetune::plugin {

/// Finds the vertex, edge or face of the model on which each point is, and the face of each triangle. A triangle
/// belongs to the face within the radii of its vertices that it is nearest to; it is ambiguous if another is about as
/// near. Surfaces of the mesh's file are taken first. The point's entity is what bounds the faces of all triangles
/// around it, and within the radius: a face, else an edge, else a vertex. A vertex of the model belongs to the nearest
/// such point.
ClassifyAnswer classify(const ClassifyQuery& query, const Model& model, Workers& workers);

/// The nearest points of known entities.
ProjectAnswer project(const ProjectQuery& query, const Model& model, Workers& workers);

}  // namespace tetune::plugin

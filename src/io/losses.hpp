// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "io/registry.hpp"
#include "tetune/mesh.hpp"

/// Warnings of contents of a mesh that most formats cannot hold.
namespace tetune {

/// Whether a tag is not 0.
bool has_tag(const std::vector<int>& tags);
/// Lists of corners, ridges and required entities.
void warn_of_lists(const TetMesh& mesh, const IoContext& context);
/// Tags of vertices.
void warn_of_point_tags(const TetMesh& mesh, const IoContext& context);
/// The data of any entity, except for those of a name that the format has room for.
void warn_of_data(const TetMesh& mesh, const IoContext& context, const char* kept = nullptr);
/// The names of groups.
void warn_of_names(const TetMesh& mesh, const IoContext& context);

}  // namespace tetune

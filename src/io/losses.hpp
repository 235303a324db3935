// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "io/io_context.hpp"
#include "tetune/mesh.hpp"

/// Warnings of contents of a mesh that most formats cannot hold, for all writers.
namespace tetune {

/// Whether a tag is not 0.
bool has_tag(const std::vector<int>& tags);
/// Warns of lists of corners, ridges and required entities.
void warn_of_lists(const TetMesh& mesh, const IoContext& context);
/// Warns of tags of vertices.
void warn_of_point_tags(const TetMesh& mesh, const IoContext& context);
/// Warns of the data of any entity, except for those of a name that the format has room for.
void warn_of_data(const TetMesh& mesh, const IoContext& context, const char* kept = nullptr);
/// Warns of the data of any entity, except for sets of nodes.
void warn_of_data_but_node_sets(const TetMesh& mesh, const IoContext& context);
/// The warning of a format that stores doubles on lists of data with integers beyond 2^53; empty where there are none.
std::string rounded_integers(const std::vector<const std::vector<DataArray>*>& lists, const char* format);
/// Warns of names of groups.
void warn_of_names(const TetMesh& mesh, const IoContext& context);
/// Warns of elements of one vertex.
void warn_of_point_elements(const IoContext& context);
/// Warns of elements that are in several groups, where a format has one name per element.
void warn_of_shared_names(const IoContext& context);
/// The groups that a format writes under other names, of which one warning lists the first.
class RenamedGroups {
 public:
  /// Lists a group if its names differ.
  void add(const std::string& name, const std::string& written);
  void warn(const IoContext& context) const;

 private:
  std::vector<std::string> texts_;
};
/// Warns of a named group without elements.
void warn_of_empty_group(const Group& group, const IoContext& context);
/// Warns of all named groups without elements.
void warn_of_empty_groups(const TetMesh& mesh, const IoContext& context);
/// Warns of tags that share their only group, whose number becomes the tag of all.
void warn_of_merged_tags(const Group& group, std::size_t tags, const IoContext& context);

/// Throws FileError where a coordinate is infinite or no number, for which the format has no notation.
void refuse_infinite_points(const TetMesh& mesh);

/// The groups without elements, in their order.
std::vector<const Group*> empty_groups(const TetMesh& mesh);

}  // namespace tetune

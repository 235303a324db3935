// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "io/msh/msh_model.hpp"
#include "io/msh/msh_source.hpp"

/// Readers of the sections of an .msh file, each from the line after the name to the line before the end.
namespace tetune {

/// $Entities, $PartitionedEntities and $Elements.
class MshElementReader {
 public:
  MshElementReader(MshSource& source, MshModel& model) : source_(source), model_(model) {}
  void read_entities(bool partitioned);
  void read_elements();

 private:
  /// An entity of version 4.1.
  struct Entity {
    std::vector<int> groups;
    int parent_dimension = -1, parent = 0, partition = 0;
  };
  std::vector<int> integers(const char* name);
  std::size_t read_old_line();
  std::size_t read_old_block(std::size_t left);
  Index read_old_cell(int dimension, int tags);
  void read_blocks();
  const MshType& type_of(int number, std::int64_t element);
  void reserve(const MshType& type, std::size_t n);
  template <class ReadNode>
  void add_element(const MshType& type, Index cell, std::int64_t number, const ReadNode& read_node);
  Index cell_of(const std::array<int, 4>& key);
  MshCell make_cell(const std::array<int, 4>& key) const;

  MshSource& source_;
  MshModel& model_;
  std::map<std::pair<int, int>, Entity> entities_;
  std::map<std::array<int, 4>, Index> cell_of_;
  std::array<int, 4> last_key_{-1, 0, 0, 0};
  Index last_cell_ = -1;
};

void read_msh_names(MshSource& source, MshModel& model);
void read_msh_comments(MshSource& source, MshModel& model);
void read_msh_periodic(MshSource& source, MshModel& model, const IoContext& context);
/// $NodeData or $ElementData.
void read_msh_view(MshSource& source, bool on_nodes, MshModel& model, const IoContext& context);

}  // namespace tetune

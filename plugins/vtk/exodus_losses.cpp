// SPDX-License-Identifier: Apache-2.0
// Contents of Exodus files that TetMesh has no place for.
#include <algorithm>
#include <numeric>

#include "exodus_file.hpp"
#include "io/plain_text.hpp"

namespace tetune::plugin {
namespace {

class Losses {
 public:
  Losses(const File& file, const ex_init_params& counts, Warnings& warnings)
      : file_(file), counts_(counts), warnings_(warnings) {}

  void find() {
    const std::vector<int> blocks = file_.ids(EX_ELEM_BLOCK, counts_.num_elem_blk);
    warn("attributes of the element blocks", blocks, [this](int id) { return has_attributes(id); });
    warn("distribution factors of the side sets", file_.ids(EX_SIDE_SET, counts_.num_side_sets),
         [this](int id) { return has_factors(EX_SIDE_SET, id); });
    warn("distribution factors of the node sets", file_.ids(EX_NODE_SET, counts_.num_node_sets),
         [this](int id) { return has_factors(EX_NODE_SET, id); });
    warn_of_variables(EX_GLOBAL, "global variables");
    warn_of_variables(EX_SIDE_SET, "variables of side sets");
    warn_of_variables(EX_NODE_SET, "variables of node sets");
    warn_of_numbers(EX_NODE_MAP, counts_.num_nodes, "nodes");
    warn_of_numbers(EX_ELEM_MAP, counts_.num_elem, "elements");
  }

 private:
  void warn(const std::string& what, const std::vector<std::string>& which) {
    if (!which.empty()) warnings_.push_back("the " + what + " " + listed_texts(which) + " are not kept");
  }

  template <class Has>
  void warn(const std::string& what, const std::vector<int>& ids, const Has& has) {
    std::vector<std::string> which;
    for (const int id : ids) {
      if (has(id)) which.push_back(std::to_string(id));
    }
    warn(what, which);
  }

  bool has_attributes(int id) const {
    ex_block info{};
    info.id = id;
    info.type = EX_ELEM_BLOCK;
    file_.check(ex_get_block_param(file_.id(), &info), "read an element block");
    return info.num_entry > 0 && info.num_attribute > 0;
  }

  /// Factors that are all 1 are those of a set without any.
  bool has_factors(ex_entity_type type, int id) const {
    int entries = 0;
    int factors = 0;
    file_.check(ex_get_set_param(file_.id(), type, id, &entries, &factors), "read a set");
    if (factors <= 0) return false;
    std::vector<double> values(std::size_t(factors), 1.0);
    file_.check(ex_get_set_dist_fact(file_.id(), type, id, values.data()), "read distribution factors");
    return std::any_of(values.begin(), values.end(), [](double value) { return value != 1; });
  }

  void warn_of_variables(ex_entity_type type, const char* what) {
    std::vector<std::string> quoted;
    for (const std::string& name : file_.variable_names(type)) quoted.push_back("\"" + name + "\"");
    warn(what, quoted);
  }

  void warn_of_numbers(ex_entity_type type, std::int64_t count, const char* what) {
    std::vector<int> numbers(std::size_t(count), 0);
    std::vector<int> positions(numbers.size());
    std::iota(positions.begin(), positions.end(), 1);
    // The call fails for numbers beyond 32 bits, too.
    const bool is_read = count == 0 || ex_get_id_map(file_.id(), type, numbers.data()) >= 0;
    if (!is_read || numbers != positions) warnings_.push_back(std::string("the numbers of ") + what + " are not kept");
  }

  const File& file_;
  const ex_init_params& counts_;
  Warnings& warnings_;
};

}  // namespace

void warn_of_losses_on_reading(const File& file, const ex_init_params& counts, Warnings& warnings) {
  Losses(file, counts, warnings).find();
}

}  // namespace tetune::plugin

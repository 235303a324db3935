// SPDX-License-Identifier: Apache-2.0
// Gmsh's .msh files, versions 2.2 and 4.1, text and binary.
#include <algorithm>
#include <utility>

#include "backend/span.hpp"
#include "io/msh/msh_sections.hpp"
#include "system/real_text.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

class MshReader {
 public:
  MshReader(MshSource& source, const IoContext& context) : source_(source), context_(context) {}

  MshModel read() {
    TextCursor& text = source_.text();
    for (std::string_view word = text.word(); !word.empty(); word = text.word()) {
      if (word[0] != '$') {
        source_.fail("expected a section, found \"" + printable(word.substr(0, 40)) +
                     "\"; the section before it is longer than it says");
      }
      check_order(word.substr(1));
      text.line();
      read_section(word.substr(1));
      source_.expect_end(word.substr(1));
    }
    if (!has_nodes_ || !has_elements_) {
      source_.fail("the section $Nodes or $Elements is missing; the file may be cut short");
    }
    const auto is_dropped = [](const MshCell& cell) { return cell.is_dropped; };
    if (std::any_of(model_.cells.begin(), model_.cells.end(), is_dropped)) {
      context_.warn("interfaces between partitions are not kept");
    }
    if (model_.has_ghosts) context_.warn("ghost elements of partitions are not kept");
    if (source_.is_old()) {
      find_dimensions_of_names(model_);
      join_repeated_elements(model_);
    }
    return std::move(model_);
  }

 private:
  /// Refuses a section that occurs twice, or before those that it refers to.
  void check_order(std::string_view name) {
    const bool has_numbers = name == "Periodic" || name == "NodeData" || name == "ElementData";
    if ((name == "Nodes" || name == "ParametricNodes") && std::exchange(has_nodes_, true)) {
      source_.fail("the section $Nodes occurs twice");
    }
    if (name == "Elements" && !has_nodes_) source_.fail("the section $Elements comes before $Nodes");
    if (name == "Elements" && std::exchange(has_elements_, true)) source_.fail("the section $Elements occurs twice");
    if (has_numbers && !has_elements_) source_.fail("the section $" + std::string(name) + " comes before $Elements");
  }

  void read_section(std::string_view name) {
    const bool is_partitioned = name == "PartitionedEntities";
    const bool is_parametric = name == "ParametricNodes";
    const bool on_nodes = name == "NodeData";
    if (name == "PhysicalNames") return read_msh_names(source_, model_);
    if (name == "Comments") return read_msh_comments(source_, model_);
    if (!source_.is_old() && (name == "Entities" || is_partitioned)) {
      return element_reader_.read_entities(is_partitioned);
    }
    if (name == "Nodes" || is_parametric) return read_nodes(is_parametric);
    if (name == "Elements") return element_reader_.read_elements();
    if (name == "Periodic") return read_msh_periodic(source_, model_, context_);
    if (on_nodes || name == "ElementData") return read_msh_view(source_, on_nodes, model_, context_);
    context_.warn("the section $" + printable(name.substr(0, 60)) + " is not kept");
    source_.skip_section(name);
  }

  // Nodes.

  void read_nodes(bool parametric) {
    std::vector<std::int64_t> numbers;
    if (source_.is_old()) {
      read_old_nodes(parametric, numbers);
    } else {
      read_blocks_of_nodes(numbers);
    }
    if (has_parameters_) context_.warn("parametric coordinates of nodes are not kept, as vertices move");
    model_.nodes = NumberIndex(numbers);
    if (model_.nodes.repeated() >= 0) source_.fail("node " + std::to_string(model_.nodes.repeated()) + " occurs twice");
    const std::vector<Index>& order = model_.nodes.order();
    if (!std::is_sorted(order.begin(), order.end())) {
      std::vector<Point3> sorted(order.size());
      std::transform(order.begin(), order.end(), sorted.begin(), [this](Index v) { return span_of(model_.points)[v]; });
      model_.points = std::move(sorted);
    }
    if (!numbers.empty() &&
        (model_.nodes.rank(1) != 0 || model_.nodes.rank(std::ssize(numbers)) != std::ssize(numbers) - 1)) {
      context_.warn("the nodes are not numbered from 1 to " + std::to_string(numbers.size()) +
                    ": they get these numbers, in the same order");
    }
  }

  void reserve_nodes(std::size_t n) {
    if (const std::string excess = excess_of(std::int64_t(n), kMaxEntries); !excess.empty())
      source_.fail("the mesh has " + excess);
    model_.points.reserve(n);
  }
  void read_point() {
    Point3 p;
    for (double& x : p) x = source_.real("coordinate");
    model_.points.push_back(p);
  }
  void read_parameters(int n) {
    has_parameters_ = true;
    for (int k = 0; k < n; ++k) source_.real("parametric coordinate");
  }

  void read_old_nodes(bool parametric, std::vector<std::int64_t>& numbers) {
    const std::size_t n = source_.text_count("number of nodes", 4, 28);
    reserve_nodes(n);
    numbers.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      numbers.push_back(source_.short_integer("number of a node"));
      read_point();
      if (!parametric) continue;
      const int dimension = source_.integer("dimension of an entity");
      source_.integer("number of an entity");
      read_parameters(dimension == 1 || dimension == 2 ? dimension : 0);
    }
  }
  void read_blocks_of_nodes(std::vector<std::int64_t>& numbers) {
    const std::int64_t blocks = source_.long_integer("number of blocks");
    const std::size_t n = source_.count("number of nodes", 4, 32);
    source_.long_integer("least number");
    source_.long_integer("largest number");
    reserve_nodes(n);
    numbers.reserve(n);
    for (std::int64_t b = 0; b < blocks; ++b) {
      const int dimension = source_.integer("dimension of an entity");
      source_.integer("number of an entity");
      const bool parametric = source_.integer("parametric flag") != 0;
      const std::size_t size = source_.count("number of nodes of a block", 4, 32);
      for (std::size_t i = 0; i < size; ++i) numbers.push_back(source_.long_integer("number of a node"));
      for (std::size_t i = 0; i < size; ++i) {
        read_point();
        if (parametric) read_parameters(std::clamp(dimension, 0, 3));
      }
    }
    if (numbers.size() != n) {
      source_.fail("the blocks have " + std::to_string(numbers.size()) + " nodes, and the section says " +
                   std::to_string(n));
    }
  }

  MshSource& source_;
  const IoContext& context_;
  MshModel model_;
  MshElementReader element_reader_{source_, model_};
  bool has_nodes_ = false, has_elements_ = false, has_parameters_ = false;
};

/// The version and encoding of a file.
struct MshHeader {
  double version = 0;
  bool is_binary = false;
};

MshHeader read_header(MshSource& source) {
  TextCursor& text = source.text();
  std::string_view word = text.word();
  for (; word == "$Comments"; word = text.word()) {
    source.skip_section("Comments");
    source.expect_end("Comments");
  }
  if (word == "$NOD") return {1, false};
  if (word != "$MeshFormat") source.fail("this is not a Gmsh mesh: it does not start with $MeshFormat");
  MshHeader header;
  header.version = text.real("version");
  header.is_binary = text.integer("file type") != 0;
  const std::int64_t bytes = text.integer("bytes of a number");
  if (bytes == 4 && header.version == 4.1) {
    source.set_short_sizes();
  } else if (bytes != 8) {
    source.fail("numbers of " + std::to_string(bytes) + " bytes; 8 are expected");
  }
  text.line();
  if (header.is_binary) {
    source.set_binary(true);
    const int one = source.integer("mark of the byte order");
    if (one != 1 && one != 16777216)
      source.fail("the mark of the byte order is " + std::to_string(one) + ", and not 1");
    if (one != 1) source.set_swapped();
  }
  source.expect_end("MeshFormat");
  return header;
}

}  // namespace

TetMesh read_msh(const std::string& path, const IoContext& context) {
  const MappedFile file(path);
  if (file.bytes().empty()) throw FileError(path + ": the file is empty");
  MshSource source(path, file.bytes());
  const MshHeader header = read_header(source);
  const bool is_old = header.version >= 2 && header.version < 3;
  if (!is_old && header.version != 4.1) {
    const bool known = header.version == 1 || header.version == 3 || header.version == 4;
    if (known && has_plugin(kGmshPlugin)) return read_by_plugin(kGmshPlugin, path, context);  // written as version 4.1
    source.fail(std::string("this is version ")
                    .append(number_text(header.version))
                    .append("; tetune reads 2.2 and 4.1 (gmsh FILE -save -format msh41 -o NEW.msh)"));
  }
  source.set_old(is_old);
  std::vector<std::string> warnings;
  const IoContext unnamed{context.threads, &warnings};
  MshModel model = MshReader(source, unnamed).read();
  model.dialect = std::string(is_old ? "msh 2.2" : "msh 4.1").append(header.is_binary ? " binary" : " text");
  TetMesh mesh;
  try {
    mesh = mesh_of(std::move(model), unnamed);
  } catch (const FileError& e) {
    throw FileError(path + ": " + e.what());
  }
  for (const std::string& warning : warnings) context.warn(path + ": " + warning);
  return mesh;
}

}  // namespace tetune

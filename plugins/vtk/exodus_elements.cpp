// SPDX-License-Identifier: Apache-2.0
// Blocks of elements and sets of sides, as Exodus has them.
#include "exodus_elements.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "exodus_file.hpp"
#include "io/tag_numbers.hpp"
#include "mesh/listed_faces.hpp"

namespace tetune::plugin {
namespace {

class Collector {
 public:
  Collector(const TetMesh& mesh, const Middles* middles, Warnings& warnings)
      : mesh_(mesh), middles_(middles), warnings_(warnings) {}

  ExodusElements run() {
    const std::size_t second = middles_ != nullptr ? 1 : 0;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      add(kTets + second, 3, mesh_.tet_tags[t], mesh_.tets[t], kTetEdges, t);
    }
    find_sides();
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      if (triangle2side_[i].tet >= 0) continue;
      add(kTriangles + second, 2, mesh_.triangle_tags[i], mesh_.triangles[i], kTriangleEdges, i);
    }
    for (std::size_t e = 0; e < mesh_.edges.size(); ++e) {
      add(kEdges + second, 1, mesh_.edge_tags[e], mesh_.edges[e], kEdgeEdges, e);
    }
    for (const ElementBlock& block : mesh_.others) add_others(block);
    collect_side_sets(kTets + second);
    choose_ids();
    return std::move(result_);
  }

 private:
  struct Side {
    std::int64_t tet = -1;
    int number = 0;  ///< from 1
  };
  using Face = std::array<Index, 3>;

  /// Adds an element to the block of its kind and tag.
  void add(std::size_t kind, int dimension, int tag, std::span<const Index> vertices, std::span<const Pair> edges,
           std::size_t element) {
    const auto [at, fresh] = kind_and_tag2block_.try_emplace({kind, tag}, result_.blocks.size());
    if (fresh) result_.blocks.push_back({0, kind, dimension, tag, {}, {}});
    OutBlock& block = result_.blocks[at->second];
    for (const Index v : vertices) block.nodes.push_back(v + 1);
    if (middles_ != nullptr) {
      for (const Pair& p : edges) block.nodes.push_back(middles_->of(item(vertices, p[0]), item(vertices, p[1])) + 1);
    }
    block.elements.push_back(element);
  }

  void add_others(const ElementBlock& block) {
    const std::size_t list = list_of(mesh_, block);
    if (list == kOtherLists) throw FileError("Exodus has no elements of kind " + block.kind);
    const std::span<const Pair> edges = middle_edges(mesh_, block, MiddleOrder::base_between_top);
    for (std::size_t i = 0; i < block.tags.size(); ++i) {
      const auto vertices = entry_of(block.element2vertex, std::int64_t(i), std::size_t(block.vertices_per_element));
      add(kOthers + list, kind_of_list(list).dimension, block.tags[i], vertices, edges, i);
    }
  }

  /// Finds for each listed triangle the tetrahedron whose side it is, of two the one with the same orientation.
  void find_sides() {
    std::vector<std::pair<Face, Index>> faces;
    for (const Face& triangle : mesh_.triangles) faces.emplace_back(triangle, index_count(faces));
    const ListedFaces<3> triangles(std::move(faces), mesh_.points.size());
    triangle2side_.resize(mesh_.triangles.size());
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      for (std::size_t s = 0; s < 4; ++s) {
        const auto& corners = kTetSides[s];
        const Face face{mesh_.tets[t][corners[0]], mesh_.tets[t][corners[1]], mesh_.tets[t][corners[2]]};
        triangles.find(face, [&](Index triangle) {
          const Face& listed = item(mesh_.triangles, triangle);
          const bool same_orientation =
              face == listed || Face{face[1], face[2], face[0]} == listed || Face{face[2], face[0], face[1]} == listed;
          Side& side = item(triangle2side_, triangle);
          if (side.tet < 0 || same_orientation) side = {std::int64_t(t), int(s) + 1};
        });
      }
    }
  }

  /// Collects for each tag of triangles the sides with it, by the numbers of the elements in the file.
  void collect_side_sets(std::size_t kind_of_tets) {
    std::vector<int> tet2element(mesh_.tets.size());
    int next = 0;
    for (const OutBlock& block : result_.blocks) {
      for (const std::size_t e : block.elements) {
        ++next;
        if (block.kind == kind_of_tets) tet2element[e] = next;
      }
    }
    std::map<int, OutSet> sets;
    FreeNumbers free_numbers({mesh_.triangle_tags.begin(), mesh_.triangle_tags.end()});
    std::map<int, int> tag2id;
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      const Side side = triangle2side_[i];
      if (side.tet < 0) continue;
      const int tag = mesh_.triangle_tags[i];
      const auto [id, fresh] = tag2id.try_emplace(tag, tag);
      if (fresh && tag <= 0) {
        id->second = free_numbers.take_lowest();
        warnings_.push_back("Exodus' numbers are positive: the tag " + std::to_string(tag) + " is side set " +
                            std::to_string(id->second));
      }
      OutSet& set = sets[id->second];
      set.id = id->second;
      set.tag = tag;
      set.entries.push_back(item(tet2element, side.tet));
      set.sides.push_back(side.number);
    }
    for (auto& [id, set] : sets) result_.side_sets.push_back(std::move(set));
  }

  /// Gives a block the number of its tag where that is positive and no block of another kind has it.
  void choose_ids() {
    std::set<int> tags;
    for (const OutBlock& block : result_.blocks) tags.insert(block.tag);
    FreeNumbers free_numbers(tags);
    std::set<int> used;
    int others = 0;
    for (OutBlock& block : result_.blocks) {
      block.id = block.tag;
      if (block.tag > 0 && used.insert(block.tag).second) continue;
      block.id = free_numbers.take_lowest();
      ++others;
    }
    if (others > 0) {
      warnings_.push_back("the numbers of element blocks are other than their tags: " + std::to_string(others) +
                          "; Exodus' are positive, and different for elements of different kinds");
    }
  }

  const TetMesh& mesh_;
  const Middles* middles_;
  Warnings& warnings_;
  ExodusElements result_;
  std::map<std::pair<std::size_t, int>, std::size_t> kind_and_tag2block_;
  std::vector<Side> triangle2side_;
};

}  // namespace

ExodusElements exodus_elements(const TetMesh& mesh, const Middles* middles, Warnings& warnings) {
  return Collector(mesh, middles, warnings).run();
}

}  // namespace tetune::plugin

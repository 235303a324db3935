// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "tetune/error.hpp"
#include "tetune/mesh.hpp"

/// A mesh as a sequence of bytes, between tetune and the programs of its plugins: of one build on one machine.
namespace tetune {

/// In front of a mesh and of an answer. They go up whenever what follows changes, so that a plugin of another build is
/// recognised.
inline constexpr std::uint64_t kStreamVersion = 0x7465'7475'6e65'0001;
inline constexpr std::uint64_t kAnswerVersion = ~kStreamVersion;

/// Calls archive(x) for each member of the mesh, in one order for both directions.
template <class Archive>
void transfer(Archive& archive, DataArray& array) {
  archive(array.name);
  archive(array.components);
  archive.variant(array.values);
}
template <class Archive>
void transfer(Archive& archive, Group& group) {
  archive(group.dimension);
  archive(group.number);
  archive(group.name);
  archive(group.tags);
}
template <class Archive>
void transfer(Archive& archive, ElementBlock& block) {
  archive(block.kind);
  archive(block.vertices_per_element);
  archive(block.element2vertex);
  archive(block.tags);
  archive(block.required);
  archive(block.data);
}
template <class Archive>
void transfer(Archive& archive, TetMesh& m) {
  archive(m.points);
  archive(m.point_tags);
  archive(m.tets);
  archive(m.tet_tags);
  archive(m.triangles);
  archive(m.triangle_tags);
  archive(m.edges);
  archive(m.edge_tags);
  for (std::vector<Index>* ids :
       {&m.corners, &m.required_vertices, &m.ridges, &m.required_edges, &m.required_triangles, &m.required_tets}) {
    archive(*ids);
  }
  archive(m.others);
  for (std::vector<DataArray>* data : {&m.point_data, &m.tet_data, &m.triangle_data, &m.edge_data}) archive(*data);
  archive(m.groups);
  archive(m.point_tags_name);
  archive(m.cell_tags_name);
  archive(m.dialect);
  archive(m.second_order);
  archive(m.listed_inside_out);
}

/// What writing and reading have in common. `Self` has bytes(void*, n), raw(container of plain items) and
/// length(container of others).
template <class Self>
class MeshArchive {
 public:
  template <class T>
  void operator()(T& item) {
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = item ? 1 : 0;  // whatever comes: no other value of a bool
      self().bytes(&byte, 1);
      item = byte != 0;
    } else if constexpr (std::is_arithmetic_v<T>) {
      self().bytes(&item, sizeof item);
    } else {
      transfer(self(), item);
    }
  }
  void operator()(std::string& text) { self().raw(text); }
  template <class T>
  void operator()(std::vector<T>& items) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      self().raw(items);
    } else {
      self().length(items);
      for (T& item : items) (*this)(item);
    }
  }

 private:
  Self& self() { return static_cast<Self&>(*this); }
};

/// `Sink`: void(const void* data, std::size_t bytes).
template <class Sink>
class MeshWriter : public MeshArchive<MeshWriter<Sink>> {
 public:
  explicit MeshWriter(Sink sink) : sink_(std::move(sink)) {}

  void variant(DataValues& values) {
    std::uint64_t which = values.index();
    (*this)(which);
    std::visit([this](auto& v) { this->raw(v); }, values);
  }

 private:
  friend class MeshArchive<MeshWriter>;
  void bytes(const void* data, std::size_t n) { sink_(data, n); }
  template <class Container>
  void length(Container& items) {
    std::uint64_t n = items.size();
    (*this)(n);
  }
  template <class Container>
  void raw(Container& items) {
    length(items);
    if (!items.empty()) sink_(items.data(), items.size() * sizeof items[0]);
  }
  Sink sink_;
};

/// Reads what MeshWriter wrote. Throws FileError where the bytes end too early.
class MeshReader : public MeshArchive<MeshReader> {
 public:
  explicit MeshReader(std::string_view bytes) : bytes_(bytes) {}

  void variant(DataValues& values) {
    std::uint64_t which = 0;
    (*this)(which);
    set_type<0>(values, which);
    std::visit([this](auto& v) { this->raw(v); }, values);
  }

 private:
  friend class MeshArchive<MeshReader>;
  template <class Container>
  void length(Container& items) {
    items.resize(count(sizeof(std::uint64_t)));  // each starts with a length
  }
  template <std::size_t I>
  static void set_type(DataValues& values, std::uint64_t which) {
    if constexpr (I < std::variant_size_v<DataValues>) {
      if (which == I) {
        values.emplace<I>();
      } else {
        set_type<I + 1>(values, which);
      }
    } else {
      fail();
    }
  }
  [[noreturn]] static void fail() { throw FileError("what the plugin sent is incomplete"); }
  std::size_t count(std::size_t bytes_each) {
    std::uint64_t n = 0;
    bytes(&n, sizeof n);
    if (n > bytes_.size() / bytes_each) fail();
    return static_cast<std::size_t>(n);
  }
  template <class Container>
  void raw(Container& items) {
    items.resize(count(sizeof items[0]));
    bytes(items.data(), items.size() * sizeof items[0]);
  }
  void bytes(void* to, std::size_t n) {
    if (n > bytes_.size()) fail();
    if (n > 0) std::memcpy(to, bytes_.data(), n);
    bytes_.remove_prefix(n);
  }
  std::string_view bytes_;
};

}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "tetune/error.hpp"
#include "tetune/mesh.hpp"

/// A mesh as a sequence of bytes, between tetune and the programs of its plugins on the same machine, and in pickles of
/// Python.
namespace tetune {

/// The first word of a stream with a mesh, and of an answer: "tetune" and the version of the encoding, which increases
/// with every change of transfer() or of the types below it. A plugin of another build is recognized by it.
inline constexpr std::uint64_t kStreamVersion = 0x7465'7475'6e65'0005;
inline constexpr std::uint64_t kAnswerVersion = ~kStreamVersion;

/// T, or const T.
template <class Maybe, class T>
concept MaybeConst = std::same_as<std::remove_const_t<Maybe>, T>;

/// Calls archive() with the members, in one order for both directions.
template <class Archive, MaybeConst<DataArray> Array>
void transfer(Archive& archive, Array& array) {
  archive(array.name, array.components, array.values);
}
template <class Archive, MaybeConst<Group> AnyGroup>
void transfer(Archive& archive, AnyGroup& group) {
  archive(group.dimension, group.number, group.name, group.tags);
}
template <class Archive, MaybeConst<PeriodicLink> AnyLink>
void transfer(Archive& archive, AnyLink& link) {
  archive(link.dimension, link.entity, link.master, link.affine, link.pairs);
}
template <class Archive, MaybeConst<ElementBlock> Block>
void transfer(Archive& archive, Block& block) {
  archive(block.kind, block.vertices_per_element, block.element2vertex, block.tags, block.required, block.data,
          block.second_order);
}
template <class Archive, MaybeConst<TetMesh> Mesh>
void transfer(Archive& archive, Mesh& m) {
  archive(m.points, m.point_tags, m.tets, m.tet_tags, m.triangles, m.triangle_tags, m.edges, m.edge_tags);
  archive(m.corners, m.required_vertices, m.ridges, m.required_edges, m.required_triangles, m.required_tets);
  archive(m.others, m.point_data, m.tet_data, m.triangle_data, m.edge_data, m.groups, m.periodic);
  archive(m.point_tags_name, m.cell_tags_name, m.dialect, m.second_order, m.curved_edges, m.listed_inside_out);
}

/// Encodes numbers, texts, lists and whole meshes. `Sink`: void(const void* data, std::size_t bytes).
template <class Sink>
class MeshWriter {
 public:
  explicit MeshWriter(Sink sink) : sink_(std::move(sink)) {}

  template <class... Items>
  requires(sizeof...(Items) > 1) void operator()(const Items&... items) { ((*this)(items), ...); }
  template <class T>
  void operator()(const T& item) {
    if constexpr (std::is_same_v<T, bool>) {
      (*this)(std::uint8_t{item});
    } else if constexpr (std::is_arithmetic_v<T>) {
      sink_(&item, sizeof item);
    } else {
      transfer(*this, item);
    }
  }
  void operator()(const std::string& text) { raw(text); }
  void operator()(const DataValues& values) {
    (*this)(std::uint64_t{values.index()});
    std::visit([this](const auto& v) { this->raw(v); }, values);
  }
  template <class T>
  void operator()(const std::vector<T>& items) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      raw(items);
    } else {
      (*this)(std::uint64_t{items.size()});
      for (const T& item : items) (*this)(item);
    }
  }

 private:
  template <class Container>
  void raw(const Container& items) {
    (*this)(std::uint64_t{items.size()});
    if (!items.empty()) sink_(items.data(), items.size() * sizeof items[0]);
  }
  Sink sink_;
};

/// Decodes what MeshWriter wrote. Throws FileError where the bytes end early or cannot be such.
class MeshReader {
 public:
  explicit MeshReader(std::string_view bytes) : bytes_(bytes) {}

  template <class... Items>
  requires(sizeof...(Items) > 1) void operator()(Items&... items) { ((*this)(items), ...); }
  template <class T>
  void operator()(T& item) {
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      (*this)(byte);
      item = byte != 0;  // any other bit pattern than 0 and 1 would be no bool
    } else if constexpr (std::is_arithmetic_v<T>) {
      take(&item, sizeof item);
    } else {
      transfer(*this, item);
    }
  }
  void operator()(std::string& text) { raw(text); }
  void operator()(DataValues& values) {
    std::uint64_t which = 0;
    (*this)(which);
    if (which >= std::variant_size_v<DataVariant>) fail();
    const auto set_type = [&]<std::size_t... I>(std::index_sequence<I...>) {
      ((which == I ? void(values.emplace<I>()) : void()), ...);
    };
    set_type(std::make_index_sequence<std::variant_size_v<DataVariant>>());
    std::visit([this](auto& v) { raw(v); }, values);
  }
  template <class T>
  void operator()(std::vector<T>& items) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      raw(items);
    } else {
      items.resize(count(sizeof(std::uint64_t)));  // each item starts with a length
      for (T& item : items) (*this)(item);
    }
  }

 private:
  [[noreturn]] static void fail() { throw FileError("the encoded mesh ends early or is damaged"); }
  /// Reads the number of items of `item_bytes` or more each; fails where the rest of the bytes cannot hold them.
  std::uint64_t count(std::size_t item_bytes) {
    std::uint64_t n = 0;
    take(&n, sizeof n);
    if (n > bytes_.size() / item_bytes) fail();
    return n;
  }
  template <class Container>
  void raw(Container& items) {
    items.resize(count(sizeof items[0]));
    take(items.data(), items.size() * sizeof items[0]);
  }
  void take(void* to, std::size_t n) {
    if (n > bytes_.size()) fail();
    if (n > 0) std::memcpy(to, bytes_.data(), n);
    bytes_.remove_prefix(n);
  }
  std::string_view bytes_;
};

}  // namespace tetune

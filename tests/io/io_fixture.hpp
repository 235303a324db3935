// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "support/meshes.hpp"
#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune::test {

/// A folder of its own for each test, gone afterwards.
class IoTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::random_device random;
    do {
      folder_ = std::filesystem::temp_directory_path() / ("tetune_io_" + std::to_string(random()));
    } while (!std::filesystem::create_directory(folder_));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  /// Writes a file and returns its path.
  std::string put(const std::string& name, const std::string& bytes) const {
    // A new file each time: some file systems flush one that was cut to nothing when it is closed.
    std::filesystem::remove(path(name));
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }
  std::string get(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      names.push_back(entry.path().filename().string());
    }
    return names;
  }
  /// The message of the FileError that reading the file throws; empty when it does not throw.
  static std::string read_error(const std::string& file, int threads = 1) {
    try {
      read_mesh(file, nullptr, threads);
    } catch (const FileError& e) {
      return e.what();
    }
    return "";
  }
  /// The lengths to which a file can be cut so that reading it gives neither an error nor a warning.
  std::vector<std::size_t> silent_cuts(const std::string& name, const std::string& whole) const {
    std::vector<std::size_t> silent;
    for (std::size_t n = 0; n < whole.size(); ++n) {
      std::vector<std::string> warnings;
      try {
        read_mesh(put(name, whole.substr(0, n)), &warnings, 1);
        if (warnings.empty()) silent.push_back(n);
      } catch (const FileError&) {
      }
    }
    return silent;
  }

 private:
  std::filesystem::path folder_;
};

inline ::testing::AssertionResult contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "\"" << part << "\" is not in \"" << text << "\"";
}

/// One of the texts contains the part.
inline ::testing::AssertionResult contains(const std::vector<std::string>& texts, const std::string& part) {
  std::string all;
  for (const std::string& text : texts) {
    if (contains(text, part)) return ::testing::AssertionSuccess();
    all += "\n  " + text;
  }
  return ::testing::AssertionFailure() << "\"" << part << "\" is in none of:" << all;
}

/// Equal to the last bit: -0.0 and 0.0 differ.
inline void expect_same(const TetMesh& a, const TetMesh& b) {
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(std::memcmp(&a.points[i], &b.points[i], sizeof(Point3)), 0) << "vertex " << i;
  }
  EXPECT_EQ(a.point_tags, b.point_tags);
  EXPECT_EQ(a.tets, b.tets);
  EXPECT_EQ(a.tet_tags, b.tet_tags);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.triangle_tags, b.triangle_tags);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.edge_tags, b.edge_tags);
  EXPECT_EQ(a.corners, b.corners);
  EXPECT_EQ(a.required_vertices, b.required_vertices);
  EXPECT_EQ(a.ridges, b.ridges);
  EXPECT_EQ(a.required_edges, b.required_edges);
  EXPECT_EQ(a.required_triangles, b.required_triangles);
  EXPECT_EQ(a.required_tets, b.required_tets);
  ASSERT_EQ(a.others.size(), b.others.size());
  for (std::size_t i = 0; i < a.others.size(); ++i) {
    EXPECT_EQ(a.others[i].kind, b.others[i].kind);
    EXPECT_EQ(a.others[i].vertices_per_element, b.others[i].vertices_per_element);
    EXPECT_EQ(a.others[i].element2vertex, b.others[i].element2vertex);
    EXPECT_EQ(a.others[i].tags, b.others[i].tags);
    EXPECT_EQ(a.others[i].required, b.others[i].required);
  }
  EXPECT_EQ(a.listed_inside_out, b.listed_inside_out);
}

/// A mesh with something in every section that tetune keeps.
inline TetMesh all_sections() {
  TetMesh m = cube(1);
  const auto tag = [](std::size_t i) { return static_cast<int>(i) * 37 - 50; };
  for (const double x : {5e-324, 1e308, 0.1, -0.0, 1.0 / 3, 2.2250738585072014e-308, -1.7976931348623157e308, 1e22}) {
    m.points.push_back({x, -x, 0.0});
  }
  m.point_tags.resize(m.points.size());
  for (std::size_t i = 0; i < m.point_tags.size(); ++i) m.point_tags[i] = tag(i);
  for (std::size_t i = 0; i < m.tet_tags.size(); ++i) m.tet_tags[i] = tag(i) + 1;
  m.point_tags[0] = 2147483647;
  m.point_tags[1] = -2147483647 - 1;
  m.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}};
  m.triangle_tags = {7, 0, -8};
  m.edges = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  m.edge_tags = {1, 2, 3, 4};
  m.corners = {0, 7};
  m.required_vertices = {3, 9, 15};
  m.ridges = {0, 3};
  m.required_edges = {2};
  m.required_triangles = {1, 2};
  m.required_tets = {0, 5};
  m.others = {
      {"Quadrilaterals", 4, {0, 1, 3, 2, 4, 5, 7, 6}, {11, 12}, {1}},
      {"Pyramids", 5, {0, 1, 3, 2, 8}, {21}, {}},
      {"Prisms", 6, {0, 1, 3, 4, 5, 7}, {31}, {}},
      {"Hexahedra", 8, {0, 1, 3, 2, 4, 5, 7, 6}, {-41}, {}},
  };
  return m;
}

/// The same with every tetrahedron listed the other way round.
inline TetMesh turned(TetMesh mesh) {
  for (auto& tet : mesh.tets) std::swap(tet[2], tet[3]);
  return mesh;
}

/// The message of the error that writing the mesh throws, or nothing.
inline std::string write_error(const std::string& file, const TetMesh& mesh) {
  try {
    write_mesh(file, mesh);
  } catch (const FileError& e) {
    return e.what();
  }
  return "";
}

}  // namespace tetune::test

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "support/meshes.hpp"

/// Quadrilaterals, pyramids, prisms and hexahedra with nodes in the middles of their edges, as the manuals of formats
/// list these, and files of them.
namespace tetune::test {

using Ends = std::array<int, 2>;  ///< of an edge; twice the same number for a vertex
using Listing = std::vector<Ends>;

/// An element as the manuals of the formats list its nodes.
struct Manual {
  std::string kind;
  Listing vertices_first;              ///< the mid-side nodes after the vertices, as Abaqus has them
  Listing nastran, gmsh, unv;          ///< likewise; that of unv is a tour
  std::string inp_type, nastran_card;  ///< empty: the format has none
  int gmsh_type, gmsh_dimension, unv_descriptor;
};

inline const std::vector<Manual>& manuals() {
  static const std::vector<Manual> kManuals{
      {"Quadrilaterals",
       {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
       {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
       {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
       {{0, 0}, {0, 1}, {1, 1}, {1, 2}, {2, 2}, {2, 3}, {3, 3}, {3, 0}},
       "S8R",
       "CQUAD8",
       16,
       2,
       95},
      {"Pyramids",
       {},
       {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}},
       {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 4}, {2, 3}, {2, 4}, {3, 4}},
       {{0, 0}, {0, 1}, {1, 1}, {1, 2}, {2, 2}, {2, 3}, {3, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}, {4, 4}},
       "",
       "CPYRAM",
       19,
       3,
       114},
      {"Prisms",
       {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}},
       {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 4}, {2, 5}, {3, 4}, {4, 5}, {5, 3}},
       {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 4}, {2, 5}, {3, 4}, {3, 5}, {4, 5}},
       {{0, 0},
        {0, 1},
        {1, 1},
        {1, 2},
        {2, 2},
        {2, 0},
        {0, 3},
        {1, 4},
        {2, 5},
        {3, 3},
        {3, 4},
        {4, 4},
        {4, 5},
        {5, 5},
        {5, 3}},
       "C3D15",
       "CPENTA",
       18,
       3,
       113},
      {"Hexahedra",
       {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}},
       {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 5}, {2, 6}, {3, 7}, {4, 5}, {5, 6}, {6, 7}, {7, 4}},
       {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}},
       {{0, 0}, {0, 1}, {1, 1}, {1, 2}, {2, 2}, {2, 3}, {3, 3}, {3, 0}, {0, 4}, {1, 5},
        {2, 6}, {3, 7}, {4, 4}, {4, 5}, {5, 5}, {5, 6}, {6, 6}, {6, 7}, {7, 7}, {7, 4}},
       "C3D20",
       "CHEXA",
       17,
       3,
       116}};
  return kManuals;
}

inline int vertices_of(const Manual& manual) {
  int last = 0;
  for (const Ends& e : manual.gmsh) last = std::max({last, e[0], e[1]});
  return last + 1;
}

inline Listing with_vertices(const Manual& manual, const Listing& middles) {
  Listing all;
  for (int v = 0; v < vertices_of(manual); ++v) all.push_back({v, v});
  all.insert(all.end(), middles.begin(), middles.end());
  return all;
}

/// No two edges have the same midpoint.
inline Point3 vertex_at(int v) { return {double(v) + 0.25 * v * v, double(v % 3), double(v % 2) + 0.5 * v}; }

/// The nodes in the order of a listing; that of the edge `bent` is beside the midpoint.
inline std::vector<Point3> nodes_of(const Listing& listing, Ends bent) {
  std::vector<Point3> nodes;
  for (const auto& [a, b] : listing) {
    const Point3 p = vertex_at(a), q = vertex_at(b);
    nodes.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
    if (a != b && Ends{a, b} == bent) nodes.back()[2] += 0.5;
  }
  return nodes;
}

/// Lists numbers from 1, with a break after each `per_line` of them, of which `first` precede.
inline std::string numbers(std::size_t n, const std::string& between, std::size_t per_line, std::size_t first,
                           const std::string& line_break) {
  std::string text;
  for (std::size_t k = 1; k <= n; ++k) {
    if (k > 1) text += (k - 1 + first) % per_line == 0 ? line_break : between;
    text += std::to_string(k);
  }
  return text;
}

inline std::string coordinates(const Point3& p, const std::string& between) {
  return std::to_string(p[0]) + between + std::to_string(p[1]) + between + std::to_string(p[2]);
}

/// A file with the element alone: its name and text. Its nodes are numbered as it lists them.
struct Written {
  std::string name, text;
};
inline Written in_msh(const Manual& m, Ends bent) {
  const std::vector<Point3> nodes = nodes_of(with_vertices(m, m.gmsh), bent);
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(nodes.size()) + "\n";
  for (std::size_t i = 0; i < nodes.size(); ++i)
    text += std::to_string(i + 1) + " " + coordinates(nodes[i], " ") + "\n";
  return {"a.msh", text + "$EndNodes\n$Elements\n1\n1 " + std::to_string(m.gmsh_type) + " 2 7 7 " +
                       numbers(nodes.size(), " ", 99, 0, " ") + "\n$EndElements\n"};
}
inline Written in_inp(const Manual& m, Ends bent) {
  const std::vector<Point3> nodes = nodes_of(with_vertices(m, m.vertices_first), bent);
  std::string text = "*NODE\n";
  for (std::size_t i = 0; i < nodes.size(); ++i)
    text += std::to_string(i + 1) + ", " + coordinates(nodes[i], ", ") + "\n";
  return {"a.inp", text + "*ELEMENT, TYPE=" + m.inp_type + ", ELSET=" + (m.gmsh_dimension == 3 ? "Volume" : "Surface") +
                       "7\n1, " + numbers(nodes.size(), ", ", 16, 1, ",\n") + "\n"};
}
inline Written in_bdf(const Manual& m, Ends bent) {
  const std::vector<Point3> nodes = nodes_of(with_vertices(m, m.nastran), bent);
  std::string text;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    text += "GRID," + std::to_string(i + 1) + ",," + coordinates(nodes[i], ",") + "\n";
  }
  return {"a.bdf", text + m.nastran_card + ",1,7," + numbers(nodes.size(), ",", 8, 2, ",\n,") + "\nENDDATA\n"};
}
inline Written in_unv(const Manual& m, Ends bent) {
  const std::vector<Point3> nodes = nodes_of(m.unv, bent);
  std::string text = "    -1\n  2411\n";
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    text += std::to_string(i + 1) + " 1 1 11\n" + coordinates(nodes[i], " ") + "\n";
  }
  return {"a.unv", text + "    -1\n    -1\n  2412\n1 " + std::to_string(m.unv_descriptor) + " 7 7 7 " +
                       std::to_string(nodes.size()) + "\n" + numbers(nodes.size(), " ", 8, 0, "\n") + "\n    -1\n"};
}

}  // namespace tetune::test

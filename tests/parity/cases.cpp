// SPDX-License-Identifier: Apache-2.0
#include "parity/cases.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/curved.hpp"
#include "support/periodic_cube.hpp"
#include "tetune/periodic.hpp"

namespace tetune::test {
namespace {

using Counts = OperationCounts;
using Operation = CountInfo<Counts>::Member;

Case& add(std::vector<Case>& all, const std::string& name, TetMesh mesh) {
  all.push_back({name, std::move(mesh), {}, {}});
  return all.back();
}

/// With Effort::best. The simulator takes seconds per tetrahedron that nothing improves, so that the meshes are small.
void add_best(std::vector<Case>& all) {
  const std::size_t first = all.size();
  Case& fixed = add(all, "fixed_best", scrambled(cube(2, 0.25), 3, 14));
  fixed.options.boundary = Boundary::fixed;
  fixed.operations = {&Counts::face_removals, &Counts::compound_flips, &Counts::vertices_inserted};
  Case& preserve = add(all, "preserve_best", scrambled(two_materials(2, 0.1), 3, 14));
  preserve.operations = {&Counts::boundary_flips, &Counts::compound_flips, &Counts::vertices_inserted,
                         &Counts::vertices_removed};
  Case& slide = add(all, "slide_best", ball(5));
  slide.options.boundary = Boundary::slide;
  slide.operations = {&Counts::face_removals, &Counts::compound_flips, &Counts::vertices_inserted};
  Case& bounded = add(all, "deviation_best", waved(cube(2, 0.25)));
  bounded.options.boundary = Boundary::slide;
  bounded.options.max_deviation = 0.05;
  bounded.operations = {&Counts::boundary_flips, &Counts::vertices_inserted};
  Case& periodic = add(all, "periodic", scrambled(periodic_cube(3, 0.3), 3, 4));
  link_box_faces(periodic.mesh, {true, true, true});
  periodic.operations = {&Counts::edge_removals, &Counts::boundary_flips, &Counts::compound_flips,
                         &Counts::vertices_inserted};
  Case& kept = add(all, "keep_vertices", cube(3, 0.25));
  kept.options.keep_vertices = true;
  kept.operations = {&Counts::edge_removals, &Counts::boundary_flips, &Counts::compound_flips};
  Case& growing = add(all, "max_growth", two_materials(2, 0.2));
  growing.options.boundary = Boundary::slide;
  growing.options.max_growth = 2;
  growing.operations = {&Counts::boundary_flips, &Counts::vertices_inserted, &Counts::vertices_removed};
  Case& untangle = add(all, "untangle_best", tangled(3, 0.5, 8));
  untangle.options.untangle = true;
  untangle.operations = {&Counts::vertices_inserted, &Counts::vertices_removed};
  for (std::size_t k = first; k < all.size(); ++k) {
    all[k].options.effort = Effort::best;
    all[k].options.restarts = all[k].name == "fixed_best" ? 0 : 1;
  }
}

/// The other efforts, each with several blocks of threads per launch.
void add_efforts(std::vector<Case>& all) {
  for (const auto& [name, effort] : {std::pair{"fast", Effort::fast}, std::pair{"standard", Effort::standard}}) {
    const std::size_t first = all.size();
    add(all, std::string("fixed_") + name, waved(cube(9, 0.2))).options.boundary = Boundary::fixed;
    add(all, std::string("preserve_") + name, scrambled(two_materials(10, 0.2), 3, 1));
    add(all, std::string("slide_") + name, ball(9)).options.boundary = Boundary::slide;
    for (std::size_t k = first; k < all.size(); ++k) {
      all[k].options.effort = effort;
      all[k].operations = {&Counts::flips32, &Counts::edge_removals, &Counts::face_removals};
      if (effort == Effort::standard) all[k].operations.push_back(&Counts::compound_flips);
    }
    all[first + 1].operations.push_back(&Counts::boundary_flips);
    all[first + 2].operations.push_back(&Counts::flips23);
  }
}

/// Energies, kinds of relocation and limits.
void add_methods(std::vector<Case>& all) {
  const std::vector<Operation> flips = {&Counts::flips32, &Counts::edge_removals, &Counts::face_removals};
  Case& gradient = add(all, "gradient", two_materials(6, 0.2));
  gradient.options.relocation = Relocation::gradient;
  gradient.operations = {&Counts::boundary_flips};
  Case& gradient_slide = add(all, "gradient_slide", ball(6));
  gradient_slide.options.relocation = Relocation::gradient;
  gradient_slide.options.boundary = Boundary::slide;
  gradient_slide.options.feature_angle = 20;  // its features are weak lines
  gradient_slide.operations = flips;
  Case& harmonic = add(all, "harmonic", cube(6, 0.2));
  harmonic.options.energy = Energy::harmonic;
  harmonic.operations = {&Counts::edge_removals, &Counts::face_removals, &Counts::boundary_flips};
  Case& paper = add(all, "paper", cube(6, 0.2));
  paper.options.termination = Termination::paper;
  paper.operations = {&Counts::edge_removals, &Counts::boundary_flips};
  Case& bound = add(all, "deviation", waved(cube(6, 0.15)));
  bound.options.boundary = Boundary::slide;
  bound.options.max_deviation = 2e-3;
  bound.operations = flips;
  Case& patches = add(all, "patches", with_patches(waved(two_materials(6, 0.15)), 0.4));
  patches.options.boundary = Boundary::slide;
  patches.options.frozen_patches = {7};
  patches.operations = flips;
  add(all, "no_flips", cube(6, 0.2)).options.flips = false;
  Case& interior = add(all, "no_boundary_flips", cube(6, 0.2));
  interior.options.boundary_flips = false;
  interior.operations = {&Counts::edge_removals};
  Case& rings = add(all, "small_rings", cube(6, 0.2));
  rings.options.energy = Energy::harmonic;
  rings.options.termination = Termination::paper;
  rings.options.max_ring = 3;
  Case& flips_alone = add(all, "flips_alone", cube(6, 0.2));
  flips_alone.options.max_iterations = 0;
  flips_alone.operations = {&Counts::edge_removals};
}

/// With parts of the mesh that stay as they are.
void add_kept_parts(std::vector<Case>& all) {
  const std::size_t first = all.size();
  add(all, "frozen_region", two_materials(6, 0.2)).options.frozen_regions = {2};
  Case& vertices = add(all, "frozen_vertices", cube(6, 0.2));
  vertices.options.frozen_vertices.resize(vertices.mesh.points.size());
  for (std::size_t v = 0; v < vertices.mesh.points.size(); v += 5) vertices.options.frozen_vertices[v] = 1;
  Case& required = add(all, "required", cube(6, 0.2));
  for (Index t = 0; t < 100; t += 7) required.mesh.required_tets.push_back(t);
  Case& edges = add(all, "edges", cube(6, 0.2));
  for (std::size_t t = 0; t < 60; t += 9) {
    edges.mesh.edges.push_back({edges.mesh.tets[t][0], edges.mesh.tets[t][2]});
    edges.mesh.edge_tags.push_back(3);
  }
  for (std::size_t k = first; k < all.size(); ++k) {
    all[k].operations = {&Counts::edge_removals, &Counts::boundary_flips};
  }
}

}  // namespace

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::vector<Case> cases() {
  std::vector<Case> all;
  add_efforts(all);
  add_best(all);
  add_methods(all);
  add_kept_parts(all);
  for (const auto boundary : {Boundary::preserve, Boundary::slide}) {
    Case& c = add(all, boundary == Boundary::slide ? "untangle_slide" : "untangle", tangled(6, 0.9, 7));
    c.options.boundary = boundary;
    c.options.untangle = true;
    c.operations = {&Counts::edge_removals, &Counts::boundary_flips};
  }
  return all;
}

void expect_operations(const Case& c, const Report& report) {
  for (const auto& operation : kOperationCounts) {
    if (std::count(c.operations.begin(), c.operations.end(), operation.count) == 0) continue;
    EXPECT_GT(report.*operation.count, 0) << operation.name;
  }
}

void expect_parity(const Report& report, const Report& on_cpu) {
  EXPECT_NEAR(report.energy_after, on_cpu.energy_after, 1e-12 * on_cpu.energy_after);
  for (const auto& operation : kOperationCounts) {
    EXPECT_EQ(report.*operation.count, on_cpu.*operation.count) << operation.name;
  }
  EXPECT_EQ(report.tets_untangled, on_cpu.tets_untangled);
  EXPECT_EQ(report.sweeps.size(), on_cpu.sweeps.size());
  EXPECT_EQ(report.stop, on_cpu.stop);
}

void expect_same(const TetMesh& a, const TetMesh& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.tets, b.tets);
  EXPECT_EQ(a.tet_tags, b.tet_tags);
  EXPECT_EQ(a.triangles, b.triangles);
}

}  // namespace tetune::test

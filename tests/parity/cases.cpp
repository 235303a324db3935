// SPDX-License-Identifier: Apache-2.0
#include "parity/cases.hpp"

#include <gtest/gtest.h>

#include "curved.hpp"
#include "periodic_cube.hpp"
#include "tetune/periodic.hpp"

namespace tetune::test {
namespace {

TetMesh with_patches(TetMesh m) {
  for (const SkinFace& f : skin(m)) {
    m.triangles.push_back(f.v);
    m.triangle_tags.push_back(m.points[static_cast<std::size_t>(f.v[0])][0] < 0.4 ? 7 : 9);
  }
  return m;
}

}  // namespace

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::vector<Case> cases() {
  std::vector<Case> all;
  const auto add = [&all](const std::string& name, TetMesh mesh) -> Options& {
    all.push_back({name, std::move(mesh), {}});
    return all.back().options;
  };
  const std::pair<const char*, Effort> efforts[] = {
      {"fast", Effort::fast}, {"standard", Effort::standard}, {"best", Effort::best}};
  for (const auto& [name, effort] : efforts) {
    Options& fixed = add(std::string("fixed_") + name, waved(cube(9, 0.2)));
    fixed.boundary = Boundary::fixed;
    fixed.effort = effort;
    add(std::string("preserve_") + name, scrambled(two_materials(10, 0.2), 3, 1)).effort = effort;
    Options& slide = add(std::string("slide_") + name, ball(9));
    slide.boundary = Boundary::slide;
    slide.effort = effort;
  }
  add("gradient", two_materials(8, 0.2)).relocation = Relocation::gradient;
  Options& gradient = add("gradient_slide", ball(7));
  gradient.relocation = Relocation::gradient;
  gradient.boundary = Boundary::slide;
  add("periodic", periodic_cube(7, 0.2)).effort = Effort::best;
  link_box_faces(all.back().mesh, {true, true, true});
  add("harmonic", cube(8, 0.2)).energy = Energy::harmonic;
  add("paper", cube(8, 0.2)).termination = Termination::paper;
  Options& bound = add("deviation", waved(cube(8, 0.15)));
  bound.boundary = Boundary::slide;
  bound.max_deviation = 2e-3;
  Options& patches = add("patches", with_patches(waved(two_materials(8, 0.15))));
  patches.boundary = Boundary::slide;
  patches.frozen_patches = {7};
  add("frozen_region", two_materials(8, 0.2)).frozen_regions = {2};
  Options& vertices = add("frozen_vertices", cube(8, 0.2));
  vertices.frozen_vertices.resize(all.back().mesh.points.size());
  for (std::size_t v = 0; v < vertices.frozen_vertices.size(); v += 5) vertices.frozen_vertices[v] = 1;
  add("required", cube(8, 0.2));
  for (Index t = 0; t < 200; t += 7) all.back().mesh.required_tets.push_back(t);
  add("edges", cube(8, 0.2));
  for (std::size_t t = 0; t < 100; t += 9) {
    TetMesh& m = all.back().mesh;
    m.edges.push_back({m.tets[t][0], m.tets[t][2]});
    m.edge_tags.push_back(3);
  }
  add("no_flips", cube(8, 0.2)).flips = false;
  add("no_boundary_flips", cube(8, 0.2)).boundary_flips = false;
  Options& rings = add("small_rings", cube(8, 0.2));
  rings.energy = Energy::harmonic;
  rings.termination = Termination::paper;
  rings.max_ring = 3;
  Options& vertices_kept = add("keep_vertices", two_materials(8, 0.2));
  vertices_kept.effort = Effort::best;
  vertices_kept.keep_vertices = true;
  Options& growing = add("max_growth", two_materials(4, 0.3));
  growing.effort = Effort::best;
  growing.boundary = Boundary::slide;
  growing.max_growth = 2;
  add("flips_alone", cube(8, 0.2)).max_iterations = 0;
  for (const auto boundary : {Boundary::preserve, Boundary::slide}) {
    Options& untangle = add(boundary == Boundary::slide ? "untangle_slide" : "untangle", tangled(8, 0.9, 7));
    untangle.boundary = boundary;
    untangle.untangle = true;
  }
  Options& untangle = add("untangle_best", tangled(8, 0.9, 7));
  untangle.effort = Effort::best;
  untangle.untangle = true;
  return all;
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

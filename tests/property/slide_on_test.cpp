// SPDX-License-Identifier: Apache-2.0
// Sliding on a surface that is given, as between the rounds of distributed runs.
#include <gtest/gtest.h>

#include "driver/distributed_interface.hpp"
#include "slide_fixture.hpp"
#include "tetune/optimize.hpp"
#include "tetune/validate.hpp"

namespace tetune {
namespace {

using test::curved;
using test::distance_to;
using test::kShapes;
using test::mean_edge;
using test::options_of;
using test::SkinFace;

TEST(SlideOn, ItsOwnSurfaceGivesTheSameBits) {
  for (int shape = 0; shape < kShapes; ++shape) {
    for (const double bound : {0.0, 0.01}) {
      Options options = options_of({shape, 2, Relocation::newton, Energy::shape, 45});
      // With a bound, and without operations on the surface, its own has flat patches (FlatPatches).
      options.effort = shape == 1 || bound > 0 ? Effort::best : Effort::standard;
      options.max_deviation = bound;
      TetMesh alone = curved(shape, 2);
      TetMesh given = alone;
      SlideSurface surface = find_slide_surface(given, options);
      optimize(alone, options);
      optimize(given, options, {}, surface);
      EXPECT_EQ(alone.points, given.points);
      EXPECT_EQ(alone.tets, given.tets);
    }
  }
}

TEST(SlideOn, TheSurfaceOfTheInputKeepsItHoweverOftenVerticesMove) {
  for (int shape = 0; shape < kShapes; ++shape) {
    for (const double part : {0.0, 0.03}) {
      const TetMesh before = curved(shape, 3);
      const std::vector<SkinFace> faces = test::skin(before);
      const auto old_skin = test::corners(before, faces);
      const auto lines = test::plain_features(before, faces, 45);
      Options options = options_of({shape, 3, Relocation::newton, Energy::shape, 45});
      options.boundary_flips = part == 0;
      options.max_deviation = part * mean_edge(old_skin);
      TetMesh mesh = before;
      SlideSurface surface = find_slide_surface(mesh, options);
      std::vector<Point3> last = mesh.points;
      for (std::uint32_t turn = 0; turn < 4; ++turn) {
        // Others are free each time, so that there is something left to do.
        options.frozen_vertices.assign(mesh.points.size(), 0);
        for (std::size_t v = 0; v < mesh.points.size(); ++v) options.frozen_vertices[v] = (v + turn) % 3 == 0 ? 1 : 0;
        optimize(mesh, options, {}, surface);
        EXPECT_NE(mesh.points, last);
        last = mesh.points;
      }
      EXPECT_TRUE(validate(mesh).ok());
      std::vector<Vec3> on_surface;
      for (const SkinFace& f : test::skin(mesh)) {
        for (const Index v : f.v) on_surface.push_back(test::at(mesh, v));
      }
      EXPECT_LT(distance_to(old_skin, on_surface), 1e-13);
      std::vector<Vec3> on_lines;
      for (const auto& e : lines.edges) {
        for (const Index v : e) on_lines.push_back(test::at(mesh, v));
      }
      if (!on_lines.empty()) {
        EXPECT_LT(distance_to(test::corners(before, lines.edges), on_lines), 1e-13);
      }
      if (part == 0) continue;
      const auto new_skin = test::corners(mesh, faces);
      EXPECT_LE(test::sampled_distance(new_skin, ClosestTriangle(old_skin), 6), options.max_deviation);
      EXPECT_LE(test::sampled_distance(old_skin, ClosestTriangle(new_skin), 6), options.max_deviation);
    }
  }
}

}  // namespace
}  // namespace tetune

// SPDX-License-Identifier: Apache-2.0
// Improves a mesh whose vertices may slide on the surface, and reports progress: improve IN OUT
#include <cstdio>

#include "tetune/tetune.hpp"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: improve IN OUT\n");
    return 2;
  }
  try {
    tetune::TetMesh mesh = tetune::read_mesh(argv[1]);
    const tetune::TetMesh before = mesh;

    tetune::Options options;
    options.boundary = tetune::Boundary::slide;
    options.effort = tetune::Effort::best;
    options.targets = {{tetune::Measure::min_dihedral, 15}};
    tetune::Context context;
    context.progress = [](const tetune::Progress& p) {
      std::printf("\r%3.0f %%  worst angle %.1f degrees", 100 * p.fraction, p.worst_angle);
      return true;  // false would stop the run, and leave the best mesh so far
    };
    const tetune::Report report = tetune::optimize(mesh, options, context);

    std::printf("\nsmallest dihedral angle %.1f -> %.1f degrees\n", tetune::quality(before).dihedral_min,
                tetune::quality(mesh).dihedral_min);
    std::printf("new surface to old: %.2g mean edges\n", tetune::compare(before, mesh).new_to_old);
    std::printf("elements below 15 degrees: %lld\n", static_cast<long long>(report.targets[0].missed));
    tetune::write_mesh(argv[2], mesh);
  } catch (const tetune::Error& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  }
}

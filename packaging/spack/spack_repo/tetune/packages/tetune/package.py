# SPDX-License-Identifier: Apache-2.0
import os
from pathlib import Path

from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Tetune(CMakePackage):
    """Improves tetrahedral meshes for simulation: command line and C++ library."""

    # There is no archive of a release yet: this builds the repository that TETUNE_REPOSITORY names; without it, the clone
    # that this file is in.
    git = os.environ.get("TETUNE_REPOSITORY", Path(__file__).resolve().parents[6].as_uri())

    license("Apache-2.0")

    version("main", branch="main")

    variant("mpi", default=False, description="Build tetune-mpi, for distributed meshes")
    variant("shared", default=True, description="Build a shared library")
    variant("vtk", default=False, description="Read and write .vtu, .pvtu, .vtk and Exodus")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("cli11", type="build")
    depends_on("nlohmann-json", type="build")
    depends_on("fmt")
    depends_on("tomlplusplus")
    depends_on("vtk@9:", when="+vtk")
    depends_on("mpi", when="+mpi")
    depends_on("petsc@3.18:+mpi", when="+mpi")
    depends_on("pkgconfig", type="build", when="+mpi")

    generator("ninja")

    # GCC's options; Spack's compiler wrapper adds those of the target processor.
    conflicts("%msvc")

    def cmake_args(self):
        return [
            self.define("TETUNE_DISPATCH", False),
            self.define_from_variant("TETUNE_MPI", "mpi"),
            self.define_from_variant("BUILD_SHARED_LIBS", "shared"),
            self.define("CMAKE_DISABLE_FIND_PACKAGE_VTK", self.spec.satisfies("~vtk")),
            self.define("GMSH_INCLUDE_DIR", "OFF"),
            self.define("OCCT_INCLUDE_DIR", "OFF"),
        ]

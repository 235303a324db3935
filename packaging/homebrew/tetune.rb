# SPDX-License-Identifier: Apache-2.0
# The command line and the C++ library. There is no archive of a release yet: `brew install --HEAD` builds the
# repository that HOMEBREW_TETUNE_REPOSITORY names; without it, the clone that this file is in.
class Tetune < Formula
  desc "Improves tetrahedral meshes for simulation"
  license "Apache-2.0"
  head ENV.fetch("HOMEBREW_TETUNE_REPOSITORY", "file://#{File.expand_path("../..", __dir__)}"),
       using: :git, branch: "main"

  depends_on "cli11" => :build
  depends_on "cmake" => :build
  depends_on "ninja" => :build
  depends_on "nlohmann-json" => :build
  depends_on "fmt"
  depends_on "tomlplusplus"

  def install
    system "cmake", "-S", ".", "-B", "build", "-G", "Ninja", "-DTETUNE_MPI=OFF",
           "-DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON", "-DGMSH_INCLUDE_DIR=OFF", "-DOCCT_INCLUDE_DIR=OFF", *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    (testpath/"in.mesh").write <<~MESH
      MeshVersionFormatted 2
      Dimension 3
      Vertices 4
      0 0 0 0
      1 0 0 0
      0 1 0 0
      0 0 1 0
      Tetrahedra 1
      1 2 3 4 0
      End
    MESH
    system bin/"tetune", "optimize", "in.mesh", "-o", "out.mesh"
    assert_path_exists testpath/"out.mesh"
  end
end

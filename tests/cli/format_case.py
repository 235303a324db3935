# SPDX-License-Identifier: Apache-2.0
"""Shared by the tests of formats: a folder with a mesh, in which tetune runs."""

import subprocess

import cli_case
from cli_case import CliTest

CUBE = """MeshVersionFormatted 2 Dimension 3
Vertices 5  0 0 0 0  1 0 0 0  0 1 0 0  0 0 1 0  1 1 1 0
Tetrahedra 2  1 2 3 4 1  2 3 4 5 2
Triangles 2  2 3 4 7  1 2 3 8
End
"""


class FormatTest(CliTest):
    def setUp(self):
        super().setUp()
        (self.folder / "cube.mesh").write_text(CUBE)

    def run_tetune(self, *arguments, program=None, env=None):
        return subprocess.run([program or cli_case.TETUNE, *arguments], cwd=self.folder, capture_output=True, text=True,
                              errors="replace", timeout=cli_case.HANG, env=env)


class ConversionTest(FormatTest):
    """With the plugins for other libraries."""

    def setUp(self):
        super().setUp()
        if not (cli_case.has_plugin("tetune-vtk") and cli_case.has_plugin("tetune-gmsh")):
            self.skipTest("built without VTK or Gmsh: install libvtk9-dev and libgmsh-dev")

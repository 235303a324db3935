# SPDX-License-Identifier: Apache-2.0
"""A rank that fails ends the run: one message, exit code 2, the old file as it was and no temporary one left."""

import os
import shlex
import subprocess
from pathlib import Path

import mpi_case
from mpi_case import MpiTest, cli_case


class Failures(MpiTest):
    def refused(self, *args, said):
        old = self.put("out.mesh", "old")
        files = sorted(os.listdir(self.folder))
        done = self.mpi(3, args[0], old, *args[1:], code=2)
        self.assertEqual(Path(old).read_text(), "old")
        self.assertEqual(sorted(os.listdir(self.folder)), files)
        ours = [line for line in done.stderr.splitlines() if line.startswith("tetune-mpi:")]
        self.assertEqual(len(ours), 1, done.stderr)
        for part in said:
            self.assertIn(part, done.stderr)

    def test_no_file(self):
        self.refused(self.path("none.mesh"), said=["none.mesh"])

    def test_a_folder(self):
        folder = self.path("folder.meshb")
        os.mkdir(folder)
        self.refused(folder, said=["folder.meshb: not a regular file"])

    def test_damaged_binary(self):
        damaged = self.path("damaged.meshb")
        Path(damaged).write_bytes(Path(mpi_case.BRACKET).read_bytes()[:100000])
        self.refused(damaged, said=["damaged.meshb", "byte"])

    def test_hdf5_that_is_none(self):
        self.refused(self.put("text.h5", "text"), said=["text.h5", "HDF5"])
        self.refused(self.put("grid.xmf", "<Xdmf/>"), said=["grid.xmf", ".h5 beside it"])
        done = self.mpi(2, mpi_case.BRACKET, self.path("nowhere/out.h5"), code=2)
        self.assertIn("nowhere/out.h5", done.stderr)

    def on_small_disk(self, limits, prepare, out):
        """Runs where the file system has limits. Returns the output, the exit code, and the files by name."""
        (self.folder / "disk").mkdir(exist_ok=True)
        words = shlex.join(mpi_case.command(2, mpi_case.BRACKET, "-o", out, "--effort", "fast", "--quiet"))
        script = (f"mount -t tmpfs -o {limits} none disk && {prepare} && {words} > log 2>&1; echo $? > code\n"
                  "rm -rf left; cp -r disk left")
        subprocess.run(["unshare", "-rm", "sh", "-c", script], cwd=self.folder, check=True, timeout=cli_case.HANG)
        left = {path.name: path.read_bytes() for path in (self.folder / "left").iterdir()}
        return (self.folder / "log").read_text(), int((self.folder / "code").read_text()), left

    @cli_case.needs_mount
    def test_a_full_disk(self):
        log, code, left = self.on_small_disk("size=600k", "printf old > disk/out.meshb", "disk/out.meshb")
        self.assertEqual(code, 2, log)
        self.assertIn("disk/out.meshb: could not be written (disk full?)", log)
        self.assertEqual(left, {"out.meshb": b"old"})

    @cli_case.needs_mount
    def test_hdf5_on_a_full_disk(self):
        """The file would have 9 MB. With the second size both ranks wait in HDF5, which has no error."""
        for size in ("size=64k", "size=8200k"):
            log, code, left = self.on_small_disk(size, "printf old > disk/out.h5 && printf old > disk/out.xmf", "disk/out.xmf")
            self.assertEqual(code, 2, log)
            self.assertEqual(log.count("tetune-mpi: disk/out.h5: could not be written (disk full?)"), 1, log)
            self.assertEqual(left, {"out.h5": b"old", "out.xmf": b"old"})

    @cli_case.needs_mount
    def test_xdmf_on_a_full_disk(self):
        # A file more, and not two.
        log, code, left = self.on_small_disk("size=100M,nr_inodes=3", "printf old > disk/out.xmf", "disk/out.xmf")
        self.assertEqual(code, 2, log)
        self.assertEqual(left, {"out.xmf": b"old"})

    @cli_case.needs_mount
    def test_xdmf_that_cannot_be_replaced(self):
        prepare = "printf old > disk/out.xmf && mount --bind disk/out.xmf disk/out.xmf"
        log, code, left = self.on_small_disk("size=100M", prepare, "disk/out.xmf")
        self.assertEqual(code, 2, log)
        self.assertEqual(len([line for line in log.splitlines() if line.startswith("tetune-mpi:")]), 1, log)
        self.assertRegex(log, "disk/out.xmf.*; disk/out.h5 was written")
        self.assertEqual(sorted(left), ["out.h5", "out.xmf"])
        self.assertEqual(left["out.xmf"], b"old")

    def test_other_elements_are_not_for_a_plex(self):
        prism = "Prisms\n1\n1 2 6 37 38 42 0\nEnd"
        source = self.put("prism.mesh", cli_case.cube(4).text().replace("End", prism))
        done = self.mpi(2, source, self.path("out.h5"), code=2)
        self.assertIn("other kinds", done.stderr)

    def test_wrong_vertex(self):
        cube = cli_case.cube(4)
        cube.tets[17] = (1, 2, 3, 40000)
        self.refused(self.put("wrong.mesh", cube), said=["wrong.mesh", "tetrahedron 18 has vertex 40001 (both counted from 1)"])

    def test_inverted_on_one_rank(self):
        mesh = cli_case.tangled(8)
        inverted = [i + 1 for i, volume in enumerate(mesh.volumes()) if volume < 0]
        source = self.put("tangled.mesh", mesh)
        said = ["tangled.mesh", "inverted", "untangle them (tetune optimize --untangle), or repair"]
        self.refused(source, said=said)
        numbers = ", ".join(map(str, inverted[:5]))
        self.assertIn(f"first, counted from 1: {numbers})", self.mpi(1, source, self.path("out.mesh"), code=2).stderr)
        sliding = self.mpi(2, source, self.path("out.mesh"), "--boundary", "slide", code=2)
        for part in ["counted from 1: ", *said]:
            self.assertIn(part, sliding.stderr)
        # The number is that of all ranks.
        for more in ([], ["--boundary", "slide"]):
            for ranks in (1, 2, 3):
                done = self.mpi(ranks, source, self.path("out.mesh"), *more, code=2)
                self.assertIn(f" {len(inverted)} of the tetrahedra are inverted", done.stderr)
                self.assertIn(f"first, counted from 1: {numbers})", done.stderr)

    def test_mesh_that_overlaps_itself(self):
        source = self.put("overlapping.mesh", cli_case.OVERLAPPING)
        done = self.mpi(1, source, self.path("out.mesh"), code=2)
        self.assertIn("overlaps itself", done.stderr)
        self.assertIn("first, counted from 1: ", done.stderr)
        self.assertIn("(--no-flips, --keep-vertices)", done.stderr)
        self.assertFalse(os.path.exists(self.path("out.mesh")))

    def test_triangle_that_is_none(self):
        cube = cli_case.cube(4)
        self.refused(self.put("none.mesh", cli_case.with_triangles(cube, [((0, 60, 124), 5)])),
                     said=["1 listed triangles", "first, counted from 1: 1"])

    def test_frozen_tag_that_nothing_has(self):
        self.refused(self.put("in.mesh", cli_case.cube(4)), "--freeze", "tag=99", said=["--freeze names tag 99", "no tetrahedron"])

    def test_folder_that_is_none(self):
        done = self.mpi(2, mpi_case.BRACKET, self.path("nowhere/out.meshb"), code=2)
        self.assertIn("nowhere", done.stderr)

    def test_a_name_of_mmg_is_not_the_help(self):
        self.refused(mpi_case.BRACKET, "-hausd", "0.1", said=["-hausd", "tetune-mpi --help"])

    def test_options_of_tetune_alone_are_named(self):
        for words, said in ((["--untangle"], "tetune-mpi does not"), (["--map=a"], "tetune-mpi does not"), (["--efort", "best"], "--efort: there is no such option; did you mean --effort?"),
                            (["--threads", "x"], "--threads: 'x' is not an integer")):
            self.refused(mpi_case.BRACKET, *words, said=["tetune-mpi: ", said, "tetune-mpi --help"])

    def test_endings_of_a_dmplex_are_known(self):
        self.refused(self.put("in.foo", ""), said=["tetune-mpi: ", "known endings: .mesh ", ".cgns .h5\n"])
        done = self.mpi(1, mpi_case.BRACKET, self.path("out.foo"), code=2)
        self.assertIn(".cgns .h5 .xmf\n", done.stderr)

    def test_help_is_of_options_as_they_are(self):
        done = subprocess.run(mpi_case.command(1, "--help"), capture_output=True, text=True, check=True)
        self.assertIn("--freeze tag=N,...,patch=N,...\n", done.stdout)

    def test_options_without_effect(self):
        done = self.mpi(3, mpi_case.BRACKET, self.path("out.mesh"), "--max-deviation", "1")
        self.assertIn("warning: --max-deviation 1 has no effect without --boundary slide", done.stderr)


mpi_case.main(__doc__)

# SPDX-License-Identifier: Apache-2.0
"""Writes a few small inputs for each fuzz target.   python3 make_seeds.py FOLDER"""

import random
import sys
from pathlib import Path

from seeds import decks, medit, msh, others
from seeds.meshes import MESHES

COMMAND_LINES = ("in.mesh out.mesh --boundary slide --feature-angle 30 --max-deviation 0.1%", "a.mesh b.mesh -o x/ --report {}.json",
                 "in.mesh -nr -nosurf -hausd 1e-3 -v 5 -m 100", "- - --freeze tag=1,2,patch=7 --target-quality 0.2 mean_ratio",
                 "in.mesh out.meshb --effort best --keep-vertices --target-dihedral 15 --time-limit 5")


def main(folder):
    def put(target, name, content):
        path = folder / target
        path.mkdir(parents=True, exist_ok=True)
        (path / name).write_bytes(content)

    for name, (points, tets) in MESHES.items():
        for extra in (False, True):
            stem = name + ("_all" if extra else "")
            put("medit_text", stem, medit.text(points, tets, extra))
            put("plugin_answer", stem, others.plugin_answer(points, tets, extra))
            for old in (False, True):
                for binary in (False, True):
                    put("msh", f"{stem}_{'22' if old else '41'}{'b' if binary else ''}", msh.msh(points, tets, extra, old, binary))
            put("msh", name + "_20", msh.msh_second_order(points))
            put("inp", stem, decks.inp(points, tets, extra))
            put("inp", name + "_parts", decks.inp_parts(points, tets))
            put("inp", name + "_10", decks.inp_second_order(points, tets))
            put("su2", stem, others.su2(points, tets, extra))
            put("nastran", stem, decks.nastran(points, tets, extra))
            put("nastran", name + "_10", decks.nastran_second_order(points, tets))
            put("unv", stem, decks.unv(points, tets, extra))
            put("unv", name + "_10", decks.unv_second_order(points, tets))
            put("netgen", stem, others.netgen(points, tets, extra))
            put("tetgen", stem, others.tetgen(points, tets, extra, int(extra)))
            for version in (1, 2, 3, 4):
                for order in "<>":
                    put("medit_binary", f"{stem}_{version}{'le' if order == '<' else 'be'}",
                        medit.binary(points, tets, extra, version, order))
    put("series", "two", b'<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n<!-- c -->\n'
        b'<DataSet timestep="0.5" group="" part="0" file="a &amp; b.vtu"/>\n<DataSet timestep="1" file="c.vtu"></DataSet>\n'
        b'</Collection>\n</VTKFile>\n')
    for i, line in enumerate(COMMAND_LINES):
        put("options", str(i), line.replace(" ", "\n").encode())
    for i in range(8):  # optimize() takes its mesh and options from bytes, whatever they are
        put("optimize", str(i), random.Random(i).randbytes(200 << i % 4))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))

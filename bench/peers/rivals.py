# SPDX-License-Identifier: Apache-2.0
"""The other programs: where they are, their versions, the relevant settings, how to run each and parse its output."""

import dataclasses
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import harness

HERE = pathlib.Path(__file__).resolve().parent
GMSH_PEER = HERE / "gmsh_peer.py"
MESHES = HERE / "meshes.py"
STELLAR = harness.ROOT / "build/peers-stellar/Stellar"


@dataclasses.dataclass
class Setting:
    """One row of the table. The words IN, OUT and STEM of the command stand for files."""
    tool: str
    name: str
    command: list
    skip: str = ""       # why it cannot run
    all_cores: bool = False


class Tools:
    """The installed tools: `paths`, `versions`, and in `missing` the reasons why others are not used."""

    def __init__(self, venv):
        self.paths, self.versions, self.missing = {}, {}, {}
        self.hxt = False
        self._add("tetune", harness.TETUNE, ["--version"], r"tetune (\S+)", "")
        # The program itself where it can be found, not mmgpy's Python script of the same name.
        inside = sorted(venv.glob("lib/python*/site-packages/mmgpy/bin/mmg3d_O3"))
        on_path = shutil.which("mmg3d_O3", path=f"{venv / 'bin'}:") or shutil.which("mmg3d_O3") or shutil.which("mmg3d")
        self._add("mmg", inside[0] if inside else on_path, ["-h"], r"Release (\S+)", "no mmg3d_O3 (PyPI: mmgpy)")
        self._add("tetgen", shutil.which("tetgen"), ["-h"], r"Version (\S+)", "no tetgen (Debian: tetgen)")
        stellar = STELLAR if STELLAR.is_file() else shutil.which("Stellar")
        self._add("stellar", stellar, ["-h"], r"Version (\S+)", "no Stellar (bench/peers/setup --stellar VMTK)")
        self.python = self._find_gmsh(venv)

    def _add(self, tool, path, arguments, pattern, missing):
        if path is None:
            self.missing[tool] = missing
            return
        self.paths[tool] = path
        line_by_line = ["stdbuf", "-oL"] if shutil.which("stdbuf") else []  # TetGen 1.5 aborts after its help
        found = re.search(pattern, harness.run([*line_by_line, path, *arguments], timeout=60)["output"])
        self.versions[tool] = found.group(1).rstrip(",") if found else "unknown"

    def _find_gmsh(self, venv):
        for python in (venv / "bin/python", pathlib.Path(sys.executable)):
            if not python.is_file():
                continue
            probe = last_json(harness.run([python, GMSH_PEER, "probe"], timeout=60))
            if probe:
                self.versions["gmsh"], self.hxt = probe["version"], probe["hxt"]
                return python
        self.missing["gmsh"] = "no Python with gmsh (PyPI: gmsh)"
        return None

    def settings(self):
        tetune = ["tetune", "optimize", "IN", "-o", "OUT"]
        rows = [Setting("tetune", " ".join(["tetune", *options]), [*tetune, *options], all_cores=True) for options in (
            [], ["--effort", "fast"], ["--effort", "best"], ["--effort", "best", "--keep-vertices"], ["--boundary", "fixed"],
            ["--boundary", "slide"], ["--boundary", "slide", "--effort", "fast"], ["--boundary", "slide", "--effort", "best"])]
        rows.append(Setting("tetune", "tetune --threads 1", [*tetune, "--threads", "1"]))
        for options in (["-optim"], ["-optim", "-nosurf"], ["-optim", "-nosurf", "-noinsert"]):
            rows.append(Setting("mmg", " ".join(["mmg", *options]), ["mmg", *options, "IN", "OUT"]))
        gmsh = ["gmsh", "optimize", "IN", "OUT"]
        for threshold in ("0.3", "0.6"):
            rows.append(Setting("gmsh", f"gmsh default {threshold}", [*gmsh, threshold, "default"]))
        rows.append(Setting("gmsh", "gmsh Netgen", [*gmsh, "0.3", "Netgen"]))
        rows.append(Setting("gmsh", "gmsh default 0.3 + Netgen", [*gmsh, "0.3", "default", "Netgen"]))
        no_hxt = f"Gmsh {self.versions.get('gmsh')} has no HXT optimizer for an existing mesh"
        for threshold in ("0.3", "0.35", "0.45"):
            rows.append(Setting("gmsh", f"gmsh HXT {threshold}", [*gmsh, threshold, "HXT"], "" if self.hxt else no_hxt,
                                all_cores=True))
        for angle in ("140", "120", "110"):
            switches = f"-rq1.4S0o/{angle}"
            rows.append(Setting("tetgen", f"tetgen {switches}", ["tetgen", switches, "STEM"]))
        for measure in ("sine", "biased-sine"):
            rows.append(Setting("stellar", f"stellar {measure}",
                                ["stellar", "-s", str(HERE / f"stellar-{measure}.cfg"), "-jL", "STEM"]))
        for row in rows:
            row.skip = self.missing.get(row.tool, row.skip)
        return rows

    def command(self, setting, files):
        tool = [self.python, GMSH_PEER] if setting.tool == "gmsh" else [self.paths[setting.tool]]
        return [*tool, *(files.get(word, word) for word in setting.command[1:])]


def mesh_tool(*arguments):
    """Runs one command of meshes.py. Returns its output; RuntimeError with the reason if it fails."""
    result = subprocess.run([sys.executable, MESHES, *arguments], capture_output=True, text=True)
    if result.returncode != 0:
        raise RuntimeError((result.stderr.strip().splitlines() or ["meshes.py failed"])[-1])
    return result.stdout.strip()


def last_json(record):
    try:
        return json.loads(record["output"].strip().splitlines()[-1])
    except (ValueError, IndexError):
        return None


TETUNE_REPORTS = re.compile(r"optimi[sz]ed ([\d.]+) s on .*\((\d+) threads?\)")


def optimize_seconds(tool, record):
    """Seconds between reading and writing, as the tool reports them; None if it does not."""
    text = record["output"]
    if tool == "tetune":
        return float(TETUNE_REPORTS.search(text).group(1))
    if tool == "gmsh":
        return (last_json(record) or {}).get("seconds")
    if tool == "mmg":
        found = re.search(r"MMG3DLIB: ELAPSED TIME\s+([\d.]+)s", text)
        return float(found.group(1)) if found else None
    total = re.search(r"Total running seconds:\s*([\d.]+)", text)  # does not hold TetGen's reading
    output = re.search(r"Output seconds:\s*([\d.]+)", text)
    return float(total.group(1)) - float(output.group(1)) if total and output else None


def threads(setting, record):
    if setting.tool == "tetune":
        return int(TETUNE_REPORTS.search(record["output"]).group(2))
    return os.cpu_count() if setting.all_cores else 1


def collect(setting, files):
    """Moves the result to OUT if the tool wrote another file. False if there is none."""
    if setting.tool == "tetgen":
        stem = f"{files['STEM']}.1"
        if not all(pathlib.Path(stem + ending).is_file() for ending in (".node", ".ele", ".face", ".edge")):
            return False
        mesh_tool("from-tetgen", files["STEM"], files["IN"], files["OUT"])
    if setting.tool == "stellar":
        stem = files["OUT"].parent / "stellar"  # "fileprefix" of the settings
        if not pathlib.Path(f"{stem}.ele").is_file():
            return False
        mesh_tool("from-stellar", stem, files["IN"], files["OUT"])
    return files["OUT"].is_file()


def clear(files):
    """Removes the results of an earlier run."""
    folder = files["STEM"].parent
    for path in [files["OUT"], *folder.glob(files["STEM"].name + ".1.*"), *folder.glob("stellar.*")]:
        path.unlink(missing_ok=True)

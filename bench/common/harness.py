# SPDX-License-Identifier: Apache-2.0
"""Functions of all benchmarks: run a program and measure it, evaluate a mesh, record where a figure comes from."""

import datetime
import json
import os
import pathlib
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
TETUNE = ROOT / "build/release/bin/tetune"


def provenance():
    """Commit, machine, command and time: part of every JSON file."""
    def git(*args):
        if shutil.which("git") is None:
            return "unknown"
        result = subprocess.run(["git", "-C", str(ROOT), *args], capture_output=True, text=True)
        return result.stdout.strip()

    model = "unknown"
    try:
        for line in open("/proc/cpuinfo"):
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return {
        "commit": git("rev-parse", "--short", "HEAD") + ("+changes" if git("status", "--porcelain", "-uno") else ""),
        "cpu": model,
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "command": " ".join(["python3", os.path.relpath(sys.argv[0], ROOT), *sys.argv[1:]]),
        "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
    }


def build(*targets, packages=(), options=("-DTETUNE_NATIVE=ON",), preset="release"):
    """Installs `packages` and what every build needs, builds the targets of a preset, and returns its folder."""
    subprocess.run([ROOT / "scripts/install-packages", "g++", "cmake", "ninja-build", "libcli11-dev", "libfmt-dev",
                    "nlohmann-json3-dev", *packages], check=True)
    subprocess.run(["cmake", "--preset", preset, *options], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", "--preset", preset, "--target", *targets], cwd=ROOT, check=True,
                   stdout=subprocess.DEVNULL)
    return ROOT / "build" / preset


def run(command, timeout=None, env=None, cwd=None):
    """Runs a command to its end. Returns its exit code (None after a timeout), wall seconds, processor seconds and peak
    memory in MiB (by the kernel's accounting, of the process or the largest that it waited for) and what it printed."""
    with tempfile.TemporaryFile() as out:
        start = time.perf_counter()
        process = subprocess.Popen([str(c) for c in command], stdout=out, stderr=subprocess.STDOUT,
                                   env={**os.environ, **(env or {})}, cwd=cwd, start_new_session=True)
        deadline = start + timeout if timeout else None
        code, peak, cpu = None, 0, 0
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG if deadline else 0)
            if pid != 0:
                code, peak = os.waitstatus_to_exitcode(status), usage.ru_maxrss / 1024
                cpu = usage.ru_utime + usage.ru_stime
                break
            if time.perf_counter() > deadline:
                os.killpg(process.pid, signal.SIGKILL)  # with the processes that it has started, as Mmg's of PyPI does
                os.wait4(process.pid, 0)
                break
            time.sleep(0.002)
        process.returncode = code if code is not None else -9
        seconds = time.perf_counter() - start
        out.seek(0)
        text = out.read().decode(errors="replace")
    return {"code": code, "seconds": seconds, "cpu_seconds": cpu, "peak_mib": peak, "output": text}


def failure(record):
    """Why a run gave no result, or None."""
    if record["code"] is None:
        return f"no result after {record['seconds']:.0f} s"
    if record["code"] < 0:
        return f"crashed ({signal.Signals(-record['code']).name})"
    if record["code"] > 0:
        lines = record["output"].strip().splitlines()
        return f"exit code {record['code']}" + (f": {lines[-1].strip()[:120]}" if lines else "")
    return None


def info(mesh):
    """Counts, validity and quality of a mesh by tetune info."""
    result = subprocess.run([str(TETUNE), "info", "--json", str(mesh)], capture_output=True, text=True)
    if not result.stdout:
        raise RuntimeError(f"tetune info {mesh}: {result.stderr.strip()}")
    return json.loads(result.stdout)


def compare(before, after):
    """The changes between two meshes: validity and quality of both, volume, surface distance, tags."""
    result = subprocess.run([str(TETUNE), "compare", "--json", str(before), str(after)], capture_output=True, text=True)
    if not result.stdout:
        raise RuntimeError(f"tetune compare {before} {after}: {result.stderr.strip()}")
    return json.loads(result.stdout)


def lost_tags(change):
    kinds = {"V": "vertex_tags_kept", "E": "edge_tags_kept", "T": "triangle_tags_kept", "R": "tetrahedron_tags_kept"}
    lost = "".join(letter for letter, key in kinds.items() if not change[key])
    return f"not {lost}" if lost else "yes"


def write_json(path, data):
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(path.suffix + ".tmp")
    temporary.write_text(json.dumps(data, indent=2) + "\n")
    temporary.rename(path)

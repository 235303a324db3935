# SPDX-License-Identifier: Apache-2.0
import os
import re
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import tetune
from meshes import shaken_box


def test_progress_is_reported_and_cancels():
    points, tets = shaken_box()
    events = []
    whole = tetune.optimize(points, tets, progress=lambda p: events.append((p.phase, p.iteration, p.energy)))
    assert {phase for phase, _, _ in events} >= {"flips", "sweep"}
    assert events[-1][2] == pytest.approx(whole.report.energy_after)

    calls = []
    r = tetune.optimize(points, tets, progress=lambda p: calls.append(p) is not None or len(calls) < 3)
    assert len(calls) == 3 and r.report.stop == "cancelled"
    assert tetune.validate(r.mesh) == ""
    assert whole.report.energy_after < r.report.energy_after < r.report.energy_before


def test_what_the_callback_raises_comes_through():
    points, tets = shaken_box(2, 2, 2)

    def fail(_):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        tetune.optimize(points, tets, progress=fail)


@pytest.fixture
def interruptible():
    """Python's handler of SIGINT, which Gmsh replaces by the default action in processes that use it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_interrupt_without_callback(interruptible):
    points, tets = shaken_box(28, 28, 28)
    mesh = tetune.TetMesh(points, tets)
    timer = threading.Timer(0.15, lambda: os.kill(os.getpid(), signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        timer.start()
        for _ in range(100):
            tetune.optimize(mesh, effort="best")
    timer.join()
    assert np.array_equal(mesh.points, points) and np.array_equal(mesh.tets, tets)


def test_other_threads_run_meanwhile():
    points, tets = shaken_box(20, 20, 20)
    ticks, done = [], threading.Event()

    def tick():
        while not done.wait(0.002):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    before = len(ticks)
    tetune.optimize(points, tets)
    during = len(ticks) - before
    done.set()
    thread.join()
    assert during > 5  # hundreds where nobody disturbs, one or two where the lock is held


def test_progress_bar():
    pytest.importorskip("rich")
    points, tets = shaken_box()
    code = "import tetune; from meshes import shaken_box; tetune.optimize(*shaken_box(12, 12, 12), progress=True)"
    run = subprocess.run(
        ["script", "-qec", f'"{sys.executable}" -c "{code}"', "/dev/null"],
        capture_output=True, text=True, cwd=os.path.dirname(__file__), env={**os.environ, "TERM": "xterm"},
    )
    assert run.returncode == 0 and re.search(r"\d+ %  \w+, sweep \d+, \d+\.\d degrees, \d+ s left", run.stdout), run.stdout
    quiet = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=os.path.dirname(__file__))
    assert quiet.returncode == 0 and quiet.stdout == quiet.stderr == ""

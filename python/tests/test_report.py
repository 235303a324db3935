# SPDX-License-Identifier: Apache-2.0
"""The page, in a browser."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys

import pytest

import tetune
from meshes import BRACKET, shaken_box

pytest.importorskip("plotly")


CRITERIA = """
[min_dihedral_deg]
warn = 60
fail = 1

[mean_ratio]
fail = 0.001
"""


def data_of(page):
    """What the page shows."""
    found = re.search('<script type="application/json" id="data">(.*?)</script>', page.read_text(encoding="utf-8"), re.DOTALL)
    return json.loads(found[1])


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    (folder / "criteria.toml").write_text(CRITERIA)
    run = subprocess.run(
        [sys.executable, "-m", "tetune", "optimize", BRACKET, "-o", "out.mesh", "--report-html", "page.html", "--effort", "best",
         "--target-dihedral", "1", "--criteria", "criteria.toml"],
        cwd=folder, capture_output=True, text=True,
    )
    assert run.returncode == 0, run.stderr
    return folder / "page.html"


def test_it_is_small_and_whole(page):
    assert 2e6 < page.stat().st_size < 5e6
    assert [f.name for f in page.parent.iterdir() if f.suffix == ".tmp"] == []
    head = page.read_text(encoding="utf-8")[:3000]
    assert "<title>tetune: bracket.meshb → out.mesh</title>" in head and "src=" not in head


def test_in_a_browser(page):
    sync = pytest.importorskip("playwright.sync_api")
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("chromium is not installed: apt-get install chromium")
    with sync.sync_playwright() as p:
        browser = p.chromium.launch(
            executable_path=chromium, args=["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        )
        tab = browser.new_page(viewport={"width": 1300, "height": 900}, color_scheme="dark")
        tab.set_default_timeout(120_000)
        errors, requests = [], []
        tab.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
        tab.on("pageerror", lambda e: errors.append(str(e)))
        tab.on("request", lambda r: requests.append(r.url))
        tab.goto(page.as_uri())
        tab.wait_for_selector("html[data-ready=true]", state="attached")

        q = tetune.quality(tetune.read_mesh(str(BRACKET)))
        assert f"{q.dihedral_min:.2f}°" in tab.locator("#figures").inner_text()
        assert tab.locator("#worst0 tbody tr").count() == 12
        assert tab.locator("#worst0 tbody tr").first.inner_text().startswith(str(q.worst[0].tet + 1))
        assert tab.locator("#histograms .main-svg .bars").count() == 6
        assert tab.locator("#h-acceptance").inner_text() == "Acceptance: criteria.toml"
        assert tab.locator("#verdicts").inner_text() == "Before: fail; after: warn."
        assert tab.locator("#criteria tbody tr").count() == 2
        assert tab.locator("#targets tbody tr").first.inner_text().startswith("min_dihedral_deg\t1\tmet\t0 of")
        assert tab.locator("#warnings").is_hidden()
        assert "vertices inserted" in tab.locator("#summary").inner_text()
        assert tab.locator("#charts .chart").count() == 4
        assert "Smallest dihedral angle over sweeps" in tab.locator("#charts").inner_text()

        drawn = lambda which, kind: int(tab.locator(f"#view{which}").get_attribute(f"data-{kind}"))
        until = tab.wait_for_function
        pixels = lambda which: tab.locator(f"#view{which}").screenshot()

        half = drawn(0, "triangles")
        where = tab.locator("#where").inner_text()
        assert half > 0 and where.startswith("x = ")
        tab.locator("#plane").focus()
        tab.keyboard.press("ArrowLeft")
        until(f"() => document.getElementById('view0').dataset.triangles != {half}")
        assert tab.locator("#where").inner_text() != where
        tab.locator("#axis").select_option("-1")
        until("() => document.getElementById('where').textContent === 'whole'")
        until(f"() => document.getElementById('view0').dataset.triangles > {half}")
        surface = drawn(0, "triangles")
        by_angle = pixels(1)
        assert tab.locator("#highest").inner_text().startswith("70.53°")
        tab.locator("#color").select_option("mean_ratio")
        until("() => document.getElementById('highest').textContent.startsWith('1,')")
        assert pixels(1) != by_angle

        tab.locator(f"button[aria-label='Show element {q.worst[0].tet + 1} before']").click()
        until("() => document.getElementById('view0').dataset.triangles == 4 && document.getElementById('view0').dataset.lines > 6")
        assert f"Element {q.worst[0].tet + 1} before" in tab.locator("#shown").inner_text()
        assert tab.locator("#worst0 tr[aria-current=true]").count() == 1
        tab.locator("#whole").click()
        until(f"() => document.getElementById('view0').dataset.triangles == {surface}")

        back = lambda: tab.evaluate("() => getComputedStyle(document.body).backgroundColor")
        dark = back()
        tab.locator("#theme").click()
        until("() => document.documentElement.dataset.theme === 'light'")
        assert back() == "rgb(255, 255, 255)" != dark
        tab.locator("#log").check()
        # The views share one camera.
        other = pixels(1)
        tab.locator("#view0").focus()
        tab.keyboard.press("ArrowRight")
        assert pixels(1) != other
        tab.set_viewport_size({"width": 400, "height": 800})
        tab.wait_for_function("() => document.documentElement.scrollWidth <= 400")
        browser.close()
    assert errors == []
    assert [r for r in requests if not r.startswith(("file:", "data:", "blob:"))] == []


def test_report_of_two_files(page, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "tetune", "report", BRACKET, page.parent / "out.mesh", "-o", tmp_path / "r.html"],
        capture_output=True, text=True,
    )
    assert done.returncode == 0, done.stderr
    assert '"optimization": null' in (tmp_path / "r.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["no.mesh", str(BRACKET), "-o", "r.html"], "no.mesh"),
        ([str(BRACKET), str(BRACKET), "-o", "nowhere/r.html"], "there is no folder nowhere"),
        ([str(BRACKET), str(BRACKET), "-o", "r.html", "--run", str(BRACKET)], "this is not what `tetune optimize --report"),
    ],
)
def test_errors(words, message, tmp_path):
    done = subprocess.run([sys.executable, "-m", "tetune", "report", *words], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 2 and message in done.stderr and "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def run(folder, *words):
    return subprocess.run([sys.executable, "-m", "tetune", *words], capture_output=True, text=True, cwd=folder)


def test_files_that_are_read_are_not_replaced(tmp_path):
    shutil.copy(BRACKET, tmp_path / "in.meshb")
    (tmp_path / "link.html").symlink_to("in.meshb")
    mesh = (tmp_path / "in.meshb").read_bytes()
    for words, message in (
        (["--report-html", "in.meshb"], "in.meshb would be written for in.meshb, but is read as well"),
        (["--report-html=./in.meshb"], "would be written for in.meshb, but is read as well"),
        (["-report-html", "link.html"], "link.html would be written for in.meshb, but is read as well"),
        (["--report-html", "out.meshb"], "out.meshb would be written twice"),
        (["--report", "r", "--report-html", "r"], "r would be written twice"),
        (["--criteria", "c.toml", "--report-html", "c.toml"], "c.toml"),
    ):
        done = run(tmp_path, "optimize", "in.meshb", "out.meshb", *words)
        assert done.returncode == 2 and message in done.stderr and "temp" not in done.stderr, done.stderr
    for words in (["in.meshb", "in.meshb"], ["in.meshb", str(BRACKET)], [str(BRACKET), "in.meshb"]):
        done = run(tmp_path, "report", *words, "-o", "link.html")
        assert done.returncode == 2 and "link.html would be written, but is read as well" in done.stderr
    assert sorted(f.name for f in tmp_path.iterdir()) == ["in.meshb", "link.html"]
    assert (tmp_path / "in.meshb").read_bytes() == mesh


@pytest.mark.skipif(sys.platform == "win32", reason="there are no such files")
def test_special_files_are_not_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for words in (["optimize", str(BRACKET), "out.meshb", "--report-html", "pipe"], ["report", str(BRACKET), str(BRACKET), "-o", "pipe"]):
        done = run(tmp_path, *words)
        assert done.returncode == 2 and "pipe: exists and is not a regular file" in done.stderr, done.stderr
    assert [f.name for f in tmp_path.iterdir()] == ["pipe"] and (tmp_path / "pipe").is_fifo()
    from tetune.report import write_page

    mesh = tetune.read_mesh(BRACKET)
    with pytest.raises(tetune.FileError, match="not a regular file"):
        write_page(tmp_path / "pipe", mesh, mesh)


def test_errors_come_before_the_run(tmp_path):
    for words, message in (
        ([str(BRACKET), "out.meshb", "--report-html", "nowhere/p.html"], "nowhere"),
        ([str(BRACKET), str(BRACKET), "-o", "{}.meshb", "--report-html", "p.html"], "the page shows one mesh"),
        ([str(BRACKET), "-o", "-", "--report-html", "p.html"], "not of the standard input or output"),
        ([str(BRACKET), "out.meshb", "--report-html"], "--report-html"),
    ):
        done = run(tmp_path, "optimize", *words)
        assert done.returncode == 2 and message in done.stderr and "pip install" not in done.stderr, done.stderr
    done = run(tmp_path, "optimize", str(BRACKET), "--dry-run", "--report-html", "p.html")
    assert done.returncode == 0 and "--report-html has no effect with --dry-run" in done.stderr
    code = "import sys; sys.modules['plotly'] = None; from tetune.__main__ import main; sys.exit(main())"
    words = ["optimize", str(BRACKET), "out.meshb", "--report-html", "p.html"]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 2 and "--report-html: the report needs the package plotly" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_page_beside_the_report(tmp_path):
    points, tets = shaken_box(2, 2, 2)
    tetune.write_mesh(tmp_path / "in.mesh", tetune.TetMesh(points, tets))
    done = run(tmp_path, "optimize", "in.mesh", "out.mesh", "-report-html={}.html", "--report", "{}.json")
    assert done.returncode == 0, done.stderr
    assert '"optimization": {' in (tmp_path / "in.html").read_text(encoding="utf-8")
    tetune.write_mesh(tmp_path / "to.mesh", tetune.TetMesh(points + 0.1, tets))
    done = run(tmp_path, "move", "in.mesh", "--to", "to.mesh", "-o", "moved.mesh", "--report-html", "moved.html")
    assert done.returncode == 0, done.stderr
    assert sorted(f.name for f in tmp_path.iterdir()) == ["in.html", "in.json", "in.mesh", "moved.html", "moved.mesh", "out.mesh", "to.mesh"]


def test_what_a_run_missed(tmp_path):
    points, tets = shaken_box(2, 2, 2)
    tetune.write_mesh(tmp_path / "in.mesh", tetune.TetMesh(points, tets))
    (tmp_path / "c.toml").write_text(CRITERIA.replace("60", "66").replace("fail = 1", "fail = 65"))
    words = ["--criteria", "c.toml", "--target-dihedral", "65", "--max-deviation", "1%", "--report", "run.json"]
    done = run(tmp_path, "optimize", "in.mesh", "out.mesh", "--report-html", "p.html", *words)
    assert done.returncode == 1, done.stderr
    data = data_of(tmp_path / "p.html")
    ratio, angle = data["acceptance"]["rows"]
    assert data["acceptance"]["criteria"] == "c.toml" and data["acceptance"]["verdicts"] == ["fail", "fail"]
    assert ratio[:3] == ["mean_ratio", "none", "0.001"] and ratio[5].startswith("pass: worst 0.")
    assert angle[:4] == ["min_dihedral_deg", "66", "65", "0 %"]
    assert re.fullmatch(r"fail: [0-9]+ of [0-9]+ fail, .*worst [0-9.]+", angle[5])
    (target,) = data["targets"]
    assert target[:3] == ["min_dihedral_deg", "65", "missed"] and re.fullmatch(r"[0-9]+ of [0-9]+", target[3])
    assert re.search(r"\([0-9]+\)", target[4])
    assert any("--max-deviation 1% has no effect" in w for w in data["warnings"])

    # The same from the files.
    assert run(tmp_path, "report", "in.mesh", "out.mesh", "-o", "r.html", "--run", "run.json").returncode == 0
    again = data_of(tmp_path / "r.html")
    assert all(again[key] == data[key] for key in ("acceptance", "targets", "warnings", "figures"))
    assert run(tmp_path, "report", "in.mesh", "out.mesh", "-o", "r.html").returncode == 0
    plain = data_of(tmp_path / "r.html")
    assert plain["acceptance"] is None and plain["targets"] == plain["warnings"] == []


def test_criteria_of_a_motion(tmp_path):
    points, tets = shaken_box(2, 2, 2)
    tetune.write_mesh(tmp_path / "in.mesh", tetune.TetMesh(points, tets))
    tetune.write_mesh(tmp_path / "to.mesh", tetune.TetMesh(points + 0.1, tets))
    (tmp_path / "c.toml").write_text(CRITERIA)
    done = run(tmp_path, "move", "in.mesh", "--to", "to.mesh", "-o", "m.mesh", "--report-html", "m.html", "--criteria", "c.toml")
    assert done.returncode == 0, done.stderr
    judged = data_of(tmp_path / "m.html")["acceptance"]
    assert judged["verdicts"] == ["warn", "warn"] and re.fullmatch("warn: [0-9]+ of [0-9]+ warn, worst [0-9.]+", judged["rows"][1][5])


def test_curved_elements(tmp_path):
    points, tets = shaken_box(2, 2, 2)
    edge = tets[0][:2]
    middle = points[edge].mean(axis=0)
    for name, offset in (("a", 0.0), ("b", 3.0)):
        mesh = tetune.TetMesh(points, tets, curved_edges=[edge], curved_middles=[middle + offset])
        tetune.write_mesh(tmp_path / f"{name}.msh", mesh)
    assert run(tmp_path, "report", "a.msh", "b.msh", "-o", "r.html").returncode == 0
    figures = {title: values for title, *values in data_of(tmp_path / "r.html")["figures"]}
    assert figures["Curved tetrahedra"][0] == "0" and int(figures["Curved tetrahedra"][1]) > 0
    assert figures["Curved tetrahedra not proved valid"][0] == "0" and int(figures["Curved tetrahedra not proved valid"][1]) > 0
    smallest = [float(v) for v in figures["Scaled Jacobian, smallest"]]
    assert smallest[0] > 0 > smallest[1]


def test_other_volumes_are_a_warning(tmp_path):
    points, tets = shaken_box(2, 2, 2)
    for name, scale in (("a", 1.0), ("b", 10.0)):
        tetune.write_mesh(tmp_path / f"{name}.mesh", tetune.TetMesh(scale * points, tets))
    assert run(tmp_path, "report", "a.mesh", "b.mesh", "-o", "r.html").returncode == 0
    (warning,) = data_of(tmp_path / "r.html")["warnings"]
    assert warning.startswith("The volumes differ by more than a factor of 2 (")
    assert "Curved" not in str(data_of(tmp_path / "r.html")["figures"])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_run_with_mesh_and_page(tmp_path, number):
    points, tets = shaken_box(30, 30, 30)
    tetune.write_mesh(tmp_path / "in.meshb", tetune.TetMesh(points, tets))
    command = [sys.executable, "-m", "tetune", "optimize", "in.meshb", "-o", "out.meshb", "--effort", "best", "--report-html",
               "page.html", "--progress", "json"]
    # All processes of the group get the signal, as from a terminal.
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True) as run:
        assert any(json.loads(line)["event"] == "progress" for line in run.stderr)
        os.killpg(run.pid, number)
        lines = [json.loads(line) for line in run.stderr]
        assert run.wait(100) == 1
    assert lines[-1]["event"] == "end" and lines[-1]["result"] == "interrupted"
    assert tetune.validate(tetune.read_mesh(tmp_path / "out.meshb")) == ""
    assert data_of(tmp_path / "page.html")["optimization"]["stopped"] == "interrupted"


def test_without_plotly(tmp_path):
    points, tets = shaken_box(2, 2, 2)
    for name in "ab":
        tetune.write_mesh(str(tmp_path / f"{name}.mesh"), tetune.TetMesh(points, tets))
    code = "import sys; sys.modules['plotly'] = None; from tetune.report.__main__ import main; sys.exit(main(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-c", code, "a.mesh", "b.mesh", "-o", "r.html"], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 2 and "pip install plotly" in done.stderr
    assert not os.path.exists(tmp_path / "r.html")


def test_the_program_alone_says_what_to_install(tmp_path):
    from tetune.__main__ import PROGRAM

    for words in (["report", "a", "b", "-o", "c"], ["optimize", "a", "-o", "b.mesh", "--report-html", "c.html"]):
        done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 2 and "pip install '.[report]'" in done.stderr

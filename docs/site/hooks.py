# SPDX-License-Identifier: Apache-2.0
"""What the site is made of beside docs/: pages of the repository, the examples, and the reference of Python and C++."""

import importlib.util
import re
from html import unescape
from pathlib import Path
from posixpath import dirname, join, normpath, relpath

import latex2mathml.converter
from mkdocs.exceptions import Abort
from mkdocs.structure.files import File

ROOT = Path(__file__).parents[2]
# Formulas need a font with measures for them, which few systems have.
FONT = Path("/usr/share/texmf/fonts/opentype/public/lm-math/latinmodern-math.otf")
# Files of the repository that are pages, and folders that one stands for.
PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "changes.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "bench/peers/README.md": "benchmarks/peers-harness.md",
    "bench/motion/README.md": "benchmarks/motion-harness.md",
    "bench/paper/shapes/README.md": "benchmarks/paper-shapes.md",
    "packaging/README.md": "packaging.md",
    "plugins/gmsh/LICENSE-NOTE.md": "gmsh-license.md",
    "examples": "examples.md",
    "examples/improve.cpp": "examples.md",
    "examples/python": "examples.md",
    "examples/petsc/poisson.cpp": "examples.md",
    "include/tetune": "api/cpp/optimize.md",
    "mpi/include/tetune/mpi.hpp": "api/cpp/mpi.md",
}
PYTHON = """# Python

`import tetune`; how to install it and a first use are [at the start](../index.md#in-python).

## Optimize
{tetune.optimize tetune.Options tetune.Result tetune.Progress}
## Move
{tetune.move tetune.LiveMesh tetune.MoveResult tetune.MoveReport tetune.MoveStep tetune.InvertedOthers tetune.conserve_data}
## CAD models
{tetune.Geometry}
## Second-order tetrahedra
{tetune.curve tetune.CurveResult}
## Measure and compare
{tetune.quality tetune.measure_each tetune.measure_curved_each tetune.compare tetune.validate tetune.check}
## Meshes and files
{tetune.TetMesh tetune.read_mesh tetune.write_mesh tetune.read_series tetune.write_series}
## Methods of a pyvista grid: `grid.tetune`
{tetune._pyvista.TetuneAccessor}
## HTML report
{tetune.report.write_page}
## Result types
{tetune.Report tetune.SweepReport tetune.FlipReport tetune.WorstReport tetune.TargetReport tetune.MissedTet tetune.Quality tetune.MeasureSummary tetune.WorstTet tetune.Comparison tetune.AcceptanceReport tetune.CriterionResult tetune.CriteriaReport tetune.CriteriaRound tetune.CriterionLimits tetune.GeometryReport tetune.GeometryMatch tetune.GeometryDeviation tetune.FaceDeviation tetune.DistanceSummary tetune.CurvedQuality tetune.CurvedTet tetune.CurveReport tetune.StraightenedEdge}
## Errors
{tetune.Error tetune.MeshError tetune.UntangleError tetune.CurvedError tetune.OverlapError tetune.OptionError tetune.FileError tetune.DeviceError}
"""


def python_page():
    return re.sub(r"^\{(.*)\}$", lambda m: "\n" + "\n".join(f"::: {name}" for name in m[1].split()) + "\n", PYTHON, flags=re.M)


def example_page():
    parts = ["# Examples", "Whole programs, run by the tests."]
    for file in sorted(ROOT.glob("examples/python/*.py")) + sorted(ROOT.glob("examples/*.cpp")) + sorted(
            ROOT.glob("examples/petsc/*.cpp")):
        language = "python" if file.suffix == ".py" else "cpp"
        parts += [f"## {file.name}", f"```{language}\n{file.read_text().strip()}\n```"]
    return "\n\n".join(parts)


def cpp_pages():
    spec = importlib.util.spec_from_file_location("cpp_api", Path(__file__).with_name("cpp_api.py"))
    cpp_api = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(cpp_api)
    return cpp_api.pages(ROOT / "include" / "tetune") | cpp_api.pages(ROOT / "mpi" / "include" / "tetune")


def on_files(files, config):
    texts = {page: (ROOT / source).read_text() for source, page in PAGES.items() if source.endswith(".md")}
    texts |= {"examples.md": example_page(), "api/python.md": python_page()}
    texts |= {f"api/cpp/{Path(header).stem}.md": text for header, text in cpp_pages().items()}
    for page, text in texts.items():
        files.append(File.generated(config, page, content=text))
    if not FONT.is_file():
        raise Abort(f"{FONT} is missing; install Debian's fonts-lmodern, as scripts/docs does")
    files.append(File.generated(config, f"site/{FONT.name}", abs_src_path=str(FONT)))
    return files


def on_page_markdown(markdown, page, config, files):
    here = page.file.src_uri
    source = next((s for s, p in PAGES.items() if p == here), join("docs", here))

    def of_site(link):
        target, mark, anchor = link[1].partition("#")
        if not target or "://" in target:
            return link[0]
        path = normpath(join(dirname(source), target))
        page = PAGES.get(path, path.removeprefix("docs/"))
        return f"]({relpath(page, dirname(here) or '.')}{mark}{anchor})"

    # The workflows' badges have their addresses on GitHub alone.
    markdown = re.sub(r"^\[!\[.*badge\.svg\).*\n\n", "", markdown, flags=re.M)
    return re.sub(r"\]\(([^)\s]+)\)", of_site, markdown).replace("<details>", '<details markdown="1">')


def on_page_content(html, page, config, files):
    """Formulas as MathML, which browsers show without a script."""
    def formula(match):
        block = match[2] == "["
        mathml = latex2mathml.converter.convert(unescape(match[3]).strip(), display="block" if block else "inline")
        return f'<{match[1]} class="formula">{mathml}</{match[1]}>'

    return re.sub(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', formula, html, flags=re.S)

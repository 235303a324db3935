# SPDX-License-Identifier: Apache-2.0
"""Assembles the page."""

from __future__ import annotations

import base64
import html
import json
import os
import zlib
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from .. import Comparison, FileError, MeshError, Quality, TetMesh, __version__, compare
from ._outcome import acceptance, targets, warnings
from ._scene import COLORS, Measured, Scene, cuts_per_axis, worst_places

# Measure, title, first and last edge of the bins, their number.
HISTOGRAMS = [
    ("min_dihedral_deg", "Smallest dihedral angle of each element, degrees", 0.0, 72.0, 72),
    ("max_dihedral_deg", "Largest dihedral angle of each element, degrees", 60.0, 180.0, 60),
    ("mean_ratio", "Mean ratio of each element", 0.0, 1.0, 50),
]


def _deflated(data: bytes) -> str:
    return base64.b64encode(zlib.compress(data, 6)).decode()


def _jsonable(value: Any) -> Any:
    """Arrays as {type, packed bytes}."""
    if isinstance(value, np.ndarray):
        return {"type": value.dtype.name, "data": _deflated(np.ascontiguousarray(value).tobytes())}
    if isinstance(value, dict):
        return {k: _jsonable(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_jsonable(v) for v in value]
    return value


def _figures(before: Measured, after: Measured) -> list[tuple[str, str, str]]:
    def row(title: str, form: str, value: Any) -> tuple[str, str, str]:
        return title, form.format(value(before)), form.format(value(after))

    def of(get: Any) -> Any:
        def figure(m: Measured) -> Any:
            q: Quality = m.quality
            return get(q)

        return figure

    rows = [
        row("Vertices", "{:,}", lambda m: len(m.mesh.points)),
        row("Tetrahedra", "{:,}", lambda m: len(m.mesh.tets)),
        row("Smallest dihedral angle", "{:.2f}°", of(lambda q: q.dihedral_min)),
        row("1 % of the angles are below", "{:.2f}°", of(lambda q: q.dihedral_p1)),
        row("5 % of the angles are below", "{:.2f}°", of(lambda q: q.dihedral_p5)),
        row("Largest dihedral angle", "{:.2f}°", of(lambda q: q.dihedral_max)),
        row("Mean ratio, mean", "{:.4f}", of(lambda q: q.mean_ratio)),
        row("Mean ratio, smallest", "{:.4f}", of(lambda q: q.mean_ratio_min)),
        row("Mean ratio, 1 % are below", "{:.4f}", of(lambda q: q.measures["mean_ratio"].p1)),
        row("Radius ratio, largest", "{:.4g}", of(lambda q: q.measures["radius_ratio"].max)),
        row("Volume", "{:.6g}", of(lambda q: q.volume)),
    ]
    if before.quality.curved.tets == after.quality.curved.tets == 0:
        return rows
    return [
        *rows,
        row("Curved tetrahedra", "{:,}", of(lambda q: q.curved.tets)),
        row("Curved tetrahedra not proved valid", "{:,}", of(lambda q: q.curved.tets - q.curved.valid)),
        row("Scaled Jacobian, smallest", "{:.4f}", of(lambda q: q.curved.min_scaled_jacobian)),
    ]


def _changes(c: Comparison) -> list[tuple[str, str]]:
    kept = [c.vertex_tags_kept, c.edge_tags_kept, c.triangle_tags_kept, c.tet_tags_kept]
    return [
        ("Change of volume", f"{c.volume_change:+.1e}"),
        ("Change of the surface's area", f"{c.area_change:+.1e}"),
        ("Distance, new surface to old", f"{c.new_to_old:.1e} mean edges"),
        ("Distance, old surface to new", f"{c.old_to_new:.1e} mean edges"),
        ("Tags kept", "all" if all(kept) else "not all: see tetune compare"),
    ]


def _histograms(before: Measured, after: Measured) -> list[dict[str, Any]]:
    charts = []
    for name, title, low, high, bins in HISTOGRAMS:
        shares = [
            (100 * np.histogram(np.clip(m.each[name], low, high), bins, (low, high))[0] / len(m.mesh.tets)).tolist()
            for m in (before, after)
        ]
        charts.append({"title": title, "low": low, "width": (high - low) / bins, "shares": shares})
    return charts


def plotly_script() -> bytes:
    """The library that draws. Raises ImportError where it is missing."""
    try:
        return files("plotly").joinpath("package_data", "plotly.min.js").read_bytes()
    except ImportError as error:
        raise ImportError("the report needs the package plotly: pip install plotly") from error


def check_page(path: str | os.PathLike[str]) -> None:
    """Raises FileError where the page cannot have this name."""
    place = Path(path).absolute()
    if not place.parent.is_dir():
        raise FileError(f"{os.fspath(path)}: there is no folder {Path(path).parent}; make it first")
    if place.exists() and not place.is_file():
        raise FileError(f"{os.fspath(path)}: exists and is not a regular file; give another name")


def write_page(
    path: str | os.PathLike[str],
    before: TetMesh,
    after: TetMesh,
    *,
    names: tuple[str, str] = ("before", "after"),
    run: dict[str, Any] | None = None,
) -> None:
    """Writes one HTML page that shows `before` and `after`; it opens offline in any browser.

    `run` is what `tetune optimize --report` wrote. The page is written under a temporary name and renamed. Raises
    FileError where the folder does not exist, or where the name is that of something else than a regular file,
    MeshError for a mesh without tetrahedra or with wild indices, ImportError where plotly is missing.
    """
    check_page(path)
    plotly = plotly_script()
    for mesh, name in ((before, names[0]), (after, names[1])):
        if len(mesh.tets) == 0:
            raise MeshError(f"{name}: there is no tetrahedron to show")
    low = np.minimum(before.points.min(axis=0), after.points.min(axis=0))
    size = np.maximum(before.points.max(axis=0), after.points.max(axis=0)) - low
    cuts = cuts_per_axis(max(len(before.tets), len(after.tets)))
    with ThreadPoolExecutor() as pool:  # the slow functions release the GIL
        changes = pool.submit(compare, before, after)
        measured = Measured.of(before), Measured.of(after)
        worst = pool.submit(worst_places, measured)
        scenes = list(pool.map(lambda m: Scene(m, low, size, cuts), measured))
    data = {
        "names": names,
        "figures": _figures(*measured),
        "changes": _changes(changes.result()),
        "acceptance": acceptance(run),
        "targets": targets(run),
        "warnings": warnings(run, (measured[0].quality.volume, measured[1].quality.volume)),
        "histograms": _histograms(*measured),
        "optimization": None if run is None else run["optimization"],
        "low": low.tolist(),
        "size": size.tolist(),
        "planes": cuts,
        "colors": COLORS,
        "scenes": [{"surface": s.surface, "cuts": s.cuts} for s in scenes],
        "worst": worst.result(),
    }
    text = files(__package__).joinpath("page.html").read_text(encoding="utf-8")
    fill = {
        "title": html.escape(f"{Path(names[0]).name} → {Path(names[1]).name}"),
        "version": __version__,
        "style": files(__package__).joinpath("page.css").read_text(encoding="utf-8"),
        # "</" ends a script wherever it stands.
        "data": json.dumps(_jsonable(data)).replace("</", "<\\/"),
        "plotly": _deflated(plotly),
        "viewer": files(__package__).joinpath("viewer.js").read_text(encoding="utf-8"),
        "script": files(__package__).joinpath("page.js").read_text(encoding="utf-8"),
    }
    for name, value in fill.items():
        text = text.replace("{{" + name + "}}", value)
    temporary = Path(f"{os.fspath(path)}.{os.getpid()}.tmp")
    try:
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)

# SPDX-License-Identifier: Apache-2.0
"""optimize() for arrays and for the meshes of other packages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload
from warnings import warn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._adapter import Adapter
from ._arguments import Criteria, Float64s, check_data, criteria_of, model_of, prepared, with_progress
from ._core import CriteriaReport, Geometry, GeometryReport, OptionError, Progress, Report, TetMesh
from ._options import Options
from ._tags import Tags

if TYPE_CHECKING:
    from typing import Unpack

    import meshio
    import pyvista as pv

M = TypeVar("M")


@dataclass(frozen=True)
class Result(Generic[M]):
    """The result of optimize()."""

    mesh: M
    """The improved mesh, of the same type as the argument."""
    report: Report
    """The account of the run: energies, flips, sweeps, times, targets."""
    vertex_map: NDArray[np.int32]
    """For each vertex of the result that of the input, -1 for an inserted one; likewise for mid-side nodes."""
    parent: NDArray[np.int32]
    """For each tetrahedron of the result one of the input in the same region: itself, or one that was replaced near it."""
    moved: NDArray[np.bool_] = field(repr=False)
    """For each vertex of the result whether its position differs from that in the input."""
    criteria: CriteriaReport | None
    """With the argument `criteria`: the verdicts before and after, and the constraints of what fails."""
    geometry: GeometryReport | None
    """With the argument `geometry`: where vertices are on it, and distances from it."""


def _vertex_map(report: Report, vertices: int) -> NDArray[np.int32]:
    listed = report.vertex2original
    return listed if len(listed) > 0 else np.arange(vertices, dtype=np.int32)


@overload
def optimize(
    mesh: ArrayLike,
    tets: ArrayLike,
    *,
    progress: bool | Callable[[Progress], object] = False,
    criteria: Criteria | None = None,
    geometry: Geometry | str | PathLike[str] | None = None,
    snap: bool = True,
    **options: Unpack[Options],
) -> Result[TetMesh]: ...
@overload
def optimize(
    mesh: pv.UnstructuredGrid,
    *,
    tags: Tags = None,
    progress: bool | Callable[[Progress], object] = False,
    criteria: Criteria | None = None,
    geometry: Geometry | str | PathLike[str] | None = None,
    snap: bool = True,
    **options: Unpack[Options],
) -> Result[pv.UnstructuredGrid]: ...
@overload
def optimize(
    mesh: TetMesh,
    *,
    progress: bool | Callable[[Progress], object] = False,
    criteria: Criteria | None = None,
    geometry: Geometry | str | PathLike[str] | None = None,
    snap: bool = True,
    **options: Unpack[Options],
) -> Result[TetMesh]: ...
@overload
def optimize(
    mesh: meshio.Mesh,
    *,
    tags: Tags = None,
    progress: bool | Callable[[Progress], object] = False,
    criteria: Criteria | None = None,
    geometry: Geometry | str | PathLike[str] | None = None,
    snap: bool = True,
    **options: Unpack[Options],
) -> Result[meshio.Mesh]: ...
def optimize(
    mesh: Any,
    tets: ArrayLike | None = None,
    *,
    tags: Tags = None,
    progress: bool | Callable[[Progress], object] = False,
    criteria: Criteria | None = None,
    geometry: Geometry | str | PathLike[str] | None = None,
    snap: bool = True,
    **options: Unpack[Options],
) -> Result[Any]:
    """Improves a tetrahedral mesh; the argument is not changed.

    Args:
        mesh: points of shape (n, 3) with `tets` of shape (m, 4), zero-based; or a TetMesh, meshio.Mesh or
            pyvista.UnstructuredGrid. Point data follow their vertex, cell data the parent tetrahedron; with
            data="interpolate" point data are evaluated at the new places in the input, and with data="conserve"
            floating-point data of vertices and tetrahedra keep their integrals. An inserted vertex has means of its
            neighbors' floating-point data (by mean value coordinates, which reproduce linear fields exactly), and other
            data of the nearest vertex of the input. Second-order cells (tetra10, triangle6, line3; VTK types 24, 22,
            21) stay so, with the curved surface unmoved; data of a mid-side node follow its edge, and are means of both
            ends, or the integers of one, on a new edge. Arrays of required entities, such as `mmg_required_vertices`,
            hold these as in a file of VTK (docs/formats.md).
        tags: of a meshio or pyvista mesh, the name of the cell data that number regions, patches and lines: faces
            between regions are kept. By default the first of `medit:ref`, `gmsh:physical`, `tetgen:ref`, `refs`,
            `gmsh:geometrical` that the mesh has and that holds integers; False: none.
        progress: True shows a progress bar on a terminal; or a function that is called between passes and stops the
            run by returning False: the result is then the best mesh so far, and valid.
        criteria: acceptance criteria, as in check(). The run then works on the tetrahedra that fail, in rounds
            (docs/quality.md, "Acceptance"), and `result.criteria` has the verdicts and what constrains the rest.
        geometry: the CAD model of the part, a Geometry or the name of a STEP, IGES or BREP file in mm, with
            boundary="slide": vertices of the surface end on its faces and edges (docs/cad.md), and `result.geometry`
            has the account. Not together with criteria.
        snap: whether vertices that are off the geometry are moved onto it first.
        options: see Options.

    Raises:
        FileError: the file of the criteria or of the geometry cannot be read, or names what is unknown.
        MeshError: the mesh is not valid: it has inverted elements, indices out of range or the like.
        CurvedError: second-order elements are not proved valid; the option untangle may repair them.
        OverlapError: the mesh overlaps itself, and flips would make faces that three or more tetrahedra share.
        UntangleError: the option untangle could not make every volume positive, or every second-order element valid.
        OptionError: an option is out of its range, or names a tag that no element has. (Options
            without effect are a UserWarning.)
    """
    work, adapter = prepared(mesh, tets, tags)
    check_data(adapter, options)
    before = np.asarray(mesh if tets is not None else adapter.points(), dtype=np.float64)
    if geometry is not None:
        if criteria is not None:
            raise OptionError("criteria and geometry exclude each other: make two calls")
        model = model_of(geometry, options.get("threads", 0))
        run = lambda hook: _core.improve_on_geometry(work, model, dict(options), bool(snap), hook)
        on_model = with_progress(progress, run)
        return result_of(work, adapter, on_model.optimization, before, dict(options), geometry=on_model)
    if criteria is None:
        report = with_progress(progress, lambda hook: _core.improve(work, dict(options), hook))
        return result_of(work, adapter, report, before, dict(options))
    given = criteria_of(criteria)
    judged = with_progress(progress, lambda hook: _core.improve_towards(work, given, dict(options), hook))
    return result_of(work, adapter, judged.optimization, before, dict(options), criteria=judged)


def result_of(
    work: TetMesh,
    adapter: Adapter[Any],
    report: Report,
    before: Float64s,
    options: Mapping[str, Any],
    displacement: str = "",
    criteria: CriteriaReport | None = None,
    geometry: GeometryReport | None = None,
) -> Result[Any]:
    vertex_map = _vertex_map(report, len(work.points))
    nodes = adapter.nodes(work, report, vertex_map)
    moved = (nodes.origin < 0) | np.any(nodes.points != before[nodes.origin], axis=1)
    adapter.conserves = options.get("data") == "conserve"
    moved_along = [name for name in adapter.fields() if name != displacement]
    if len(moved_along) > 0 and options.get("data", "carry") == "carry" and any(s.moved > 0 for s in report.sweeps):
        warn(
            f"the values of {', '.join(moved_along)} moved with their vertices; if they sample a field, "
            "data='interpolate' or data='conserve' evaluates it at the new positions",
            stacklevel=3,
        )
    return Result(adapter.result(work, report, nodes), report, nodes.origin, report.tet2original, moved, criteria, geometry)

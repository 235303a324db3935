# SPDX-License-Identifier: Apache-2.0
"""optimize(), move() and quality() for arrays and for the meshes of other packages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, Generic, TypeVar, Union, overload
from warnings import warn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._adapters import Adapter, adapter_of
from ._core import (
    AcceptanceReport,
    CriteriaReport,
    CurvedTet,
    CurveReport,
    Geometry,
    GeometryReport,
    MoveReport,
    OptionError,
    Progress,
    Quality,
    Report,
    TetMesh,
)
from ._options import Options
from ._tags import Tags

if TYPE_CHECKING:
    from typing import TypeAlias, Unpack

    import meshio
    import pyvista as pv

Float64s = NDArray[np.float64]
Targets: TypeAlias = Union[ArrayLike, Sequence[ArrayLike]]
Criteria: TypeAlias = Union[str, PathLike[str], Mapping[str, Mapping[str, float]]]
M = TypeVar("M")
R = TypeVar("R")


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


def _model(geometry: Geometry | str | PathLike[str], threads: int) -> Geometry:
    return geometry if isinstance(geometry, Geometry) else Geometry(geometry, threads=threads)


def _prepared(mesh: Any, tets: Any, tags: Tags) -> tuple[TetMesh, Adapter[Any]]:
    """A TetMesh with its own memory, and the adapter that converts the result back."""
    if tets is not None:
        if tags is not None:
            raise TypeError("tags names data of a meshio or pyvista mesh; with arrays use TetMesh(points, tets, tet_tags=...)")
        return TetMesh(mesh, tets), Adapter()
    adapter = adapter_of(mesh, tags)
    return adapter.tet_mesh(), adapter


def _check_data(adapter: Adapter[Any], options: Mapping[str, Any]) -> None:
    if options.get("data") == "conserve" and adapter.vertices() is not None:
        raise OptionError("data='conserve' is for linear cells, and these have mid-side nodes; use data='interpolate'")


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
        OverlapError: the mesh overlaps itself, and flips would make faces that three or more tetrahedra share.
        UntangleError: the option untangle could not make every volume positive, or every second-order element valid.
        OptionError: an option is out of its range, or names a tag that no element has. (Options
            without effect are a UserWarning.)
    """
    work, adapter = _prepared(mesh, tets, tags)
    _check_data(adapter, options)
    before = np.asarray(mesh if tets is not None else adapter.points(), dtype=np.float64)
    if geometry is not None:
        if criteria is not None:
            raise OptionError("criteria and geometry exclude each other: make two calls")
        model = _model(geometry, options.get("threads", 0))
        run = lambda hook: _core.improve_on_geometry(work, model, dict(options), bool(snap), hook)
        on_model = _with_progress(progress, run)
        return _result(work, adapter, on_model.optimization, before, dict(options), geometry=on_model)
    if criteria is None:
        report = _with_progress(progress, lambda hook: _core.improve(work, dict(options), hook))
        return _result(work, adapter, report, before, dict(options))
    given = _criteria(criteria)
    judged = _with_progress(progress, lambda hook: _core.improve_towards(work, given, dict(options), hook))
    return _result(work, adapter, judged.optimization, before, dict(options), criteria=judged)


def _criteria(given: Criteria) -> str | dict[str, Mapping[str, float]]:
    return dict(given) if isinstance(given, Mapping) else fspath(given)


def _with_progress(
    progress: bool | Callable[[Progress], object], run: Callable[[Callable[[Progress], object] | None], R]
) -> R:
    if callable(progress) or not progress:
        return run(progress if callable(progress) else None)
    from ._progress import ProgressBar

    bar = ProgressBar()
    with bar:
        return run(bar)


def _result(
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


@dataclass(frozen=True)
class MoveResult(Result[M]):
    """The result of move()."""

    motion: MoveReport
    """How far the motion went, its steps, and what blocked it."""


@overload
def move(
    mesh: ArrayLike,
    tets: ArrayLike,
    to: Targets,
    *,
    surface: bool = False,
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> MoveResult[TetMesh]: ...
@overload
def move(
    mesh: pv.UnstructuredGrid,
    *,
    to: Targets | str,
    tags: Tags = None,
    surface: bool = False,
    patches: Sequence[int] = (),
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> MoveResult[pv.UnstructuredGrid]: ...
@overload
def move(
    mesh: TetMesh,
    *,
    to: Targets,
    surface: bool = False,
    patches: Sequence[int] = (),
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> MoveResult[TetMesh]: ...
@overload
def move(
    mesh: meshio.Mesh,
    *,
    to: Targets | str,
    tags: Tags = None,
    surface: bool = False,
    patches: Sequence[int] = (),
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> MoveResult[meshio.Mesh]: ...
def move(
    mesh: Any,
    tets: ArrayLike | None = None,
    to: Targets | str | None = None,
    *,
    tags: Tags = None,
    surface: bool = False,
    patches: Sequence[int] = (),
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> MoveResult[Any]:
    """Moves vertices of a mesh to prescribed positions; the others follow, and every volume stays positive. The argument
    is not changed.

    Args:
        mesh: as in optimize(), also `tets`, `tags`, `progress` and `options`.
        to: the positions of all vertices, of shape (n, 3), with three NaN for a vertex that follows the others:
            for a displacement `points + displacement`. Or a list of such arrays, which are reached one after the other.
            Or, of a meshio or pyvista mesh, the name of point data that hold a displacement.
        surface: True: of `to`, only the positions of the vertices of the boundary, of interfaces between regions,
            of listed triangles and tagged edges, and of other listed vertices count; the others follow.
        patches: as `surface`, for the vertices of the listed triangles with these tags alone.

    A target that cannot be reached is no error: `result.motion.reached` is False, the mesh is the valid one of the last
    fraction, and `result.motion.blocking_tets` says where it ended. Prescribed vertices that reached their target are
    there bit for bit. With boundary="slide" the rest of
    the surface slides on that of the input; max_deviation must then be 0.

    Raises:
        OptionError: `to` is not usable, or as in optimize().
        MeshError, OverlapError, UntangleError: as in optimize().
    """
    work, adapter = _prepared(mesh, tets, tags)
    _check_data(adapter, options)
    before = np.array(mesh if tets is not None else adapter.points(), dtype=np.float64)
    displacement = to if isinstance(to, str) else ""
    if isinstance(to, str):
        to = before + adapter.point_data(to)
    if to is None:
        raise TypeError("move() needs targets: an array of positions, or a list of them")
    if isinstance(to, (list, tuple)) and len(to) == 0:
        raise OptionError("to is an empty list; it must be an array of positions, or a list of such arrays")
    listed = list(to) if isinstance(to, (list, tuple)) and np.ndim(to[0]) == 2 else [to]
    arrays = [np.asarray(t, dtype=np.float64) for t in listed]
    if (vertices := adapter.vertices()) is not None:
        arrays = [t[vertices] if t.ndim == 2 and len(t) == len(before) else t for t in arrays]
    if surface or len(patches) > 0:
        arrays = [_core.surface_targets(work, t, list(patches)) for t in arrays]
    motion = _with_progress(progress, lambda hook: _core.move(work, arrays, dict(options), hook))
    r = _result(work, adapter, motion.optimization, before, dict(options), displacement)
    return MoveResult(r.mesh, r.report, r.vertex_map, r.parent, r.moved, r.criteria, r.geometry, motion)


@dataclass(frozen=True)
class CurveResult(Generic[M]):
    """The result of curve()."""

    mesh: M
    """The second-order mesh, of the same type as the argument."""
    report: CurveReport
    """Numbers of curved elements, and the edges that are straighter than the surface."""


def curve(
    mesh: Any,
    tets: ArrayLike | None = None,
    *,
    tags: Tags = None,
    feature_angle: float = 45,
    surface: Any = None,
    geometry: Geometry | str | PathLike[str] | None = None,
    threads: int = 0,
) -> CurveResult[Any]:
    """Second-order tetrahedra from linear ones, with mid-side nodes on the curved surface that the triangles
    approximate; each is proved valid. The argument, given as in optimize(), is not changed.

    A meshio or pyvista mesh becomes one of tetra10, triangle6 and line3, whose mid-side nodes follow the vertices; data
    of a mid-side node are means of both ends, or integers of one. A TetMesh has them in `curved_edges` and
    `curved_middles`.

    Args:
        feature_angle: the surface is not smooth at edges where it turns by a larger angle, in degrees.
        surface: a finer mesh of the same part, given as in optimize(), on whose surface the mid-side nodes are put.
        geometry: the CAD model of the part, a Geometry or the name of a STEP, IGES or BREP file in mm, on whose faces
            and edges they are put.

    Raises:
        MeshError: the mesh is not valid, has curved edges already, has elements other than tetrahedra, triangles,
            lines and points, or is not near the finer surface or the geometry.
        OptionError: the angle is out of its range, or both a surface and a geometry are given.
        FileError: the geometry cannot be read.
    """
    work, adapter = _prepared(mesh, tets, tags)
    finer = None if surface is None else _measured(surface, None)
    model = None if geometry is None else _model(geometry, threads)
    report = _core.curve(work, feature_angle=feature_angle, threads=threads, surface=finer, geometry=model)
    return CurveResult(adapter.second_order(work), report)


def quality(mesh: Any, tets: ArrayLike | None = None, *, worst: int = 10, threads: int = 0) -> Quality:
    """Element quality of a mesh, given as in optimize(), with its `worst` worst tetrahedra."""
    return _core.measure_all(_measured(mesh, tets), worst=worst, threads=threads)


def measure_curved_each(mesh: Any, tets: ArrayLike | None = None, *, threads: int = 0) -> list[CurvedTet]:
    """Validity and measures of each second-order tetrahedron with a curved edge of a mesh, given as in optimize()."""
    return _core.measure_curved_each(_measured(mesh, tets), threads=threads)


def measure_each(mesh: Any, tets: ArrayLike | None = None, *, threads: int = 0) -> dict[str, Float64s]:
    """All measures of each tetrahedron of a mesh, given as in optimize(), by name."""
    return _core.measure_each(_measured(mesh, tets), threads=threads)


def check(
    mesh: Any,
    criteria: Criteria,
    *,
    tets: ArrayLike | None = None,
    threads: int = 0,
) -> AcceptanceReport:
    """The verdict of acceptance criteria on a mesh, given as in optimize().

    `criteria`: "abaqus", "ansys", "calculix", "fluent", "nastran", "openfoam"; the name of a TOML file; or limits by
    measure, as {"mean_ratio": {"warn": 0.2, "fail": 0.05, "allowed_percent": 0.1}}.

    Raises:
        FileError: the file cannot be read, or names what is unknown.
        OptionError: a limit is not usable.
    """
    return _core.check(_measured(mesh, tets), _criteria(criteria), threads=threads)


def _measured(mesh: Any, tets: ArrayLike | None) -> TetMesh:
    if isinstance(mesh, TetMesh) and tets is None:
        return mesh
    return _prepared(mesh, tets, None)[0]

# SPDX-License-Identifier: Apache-2.0
"""optimize() and quality() for arrays and for the meshes of other packages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeVar, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._adapters import Adapter, Tags, adapter_of
from ._core import Progress, Quality, Report, TetMesh
from ._options import Options

if TYPE_CHECKING:
    import meshio
    import pyvista as pv

Float64s = NDArray[np.float64]
M = TypeVar("M")


@dataclass(frozen=True)
class Result(Generic[M]):
    """The result of optimize()."""

    mesh: M
    """The improved mesh, of the same type as the argument."""
    report: Report
    """The account of the run: energies, flips, sweeps, times, targets."""
    vertex_map: NDArray[np.int32]
    """For each vertex of the result that of the input, -1 for an inserted one."""
    parent: NDArray[np.int32]
    """For each tetrahedron of the result one of the input in the same region: itself, or one that was replaced near it."""
    moved: NDArray[np.bool_] = field(repr=False)
    """For each vertex of the result whether its position differs from that in the input."""


def _prepared(mesh: Any, tets: Any, tags: Tags) -> tuple[TetMesh, Adapter[Any]]:
    """A TetMesh with its own memory, and the adapter that converts the result back."""
    if tets is not None:
        if tags is not None:
            raise TypeError("tags names data of a meshio or pyvista mesh; with arrays use TetMesh(points, tets, tet_tags=...)")
        return TetMesh(mesh, tets), Adapter()
    adapter = adapter_of(mesh, tags)
    return adapter.tet_mesh(), adapter


def _vertex_map(report: Report, vertices: int) -> NDArray[np.int32]:
    listed = report.vertex2original
    return listed if len(listed) > 0 else np.arange(vertices, dtype=np.int32)


@overload
def optimize(
    mesh: ArrayLike,
    tets: ArrayLike,
    *,
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> Result[TetMesh]: ...
@overload
def optimize(
    mesh: pv.UnstructuredGrid,
    *,
    tags: Tags = None,
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> Result[pv.UnstructuredGrid]: ...
@overload
def optimize(
    mesh: TetMesh,
    *,
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> Result[TetMesh]: ...
@overload
def optimize(
    mesh: meshio.Mesh,
    *,
    tags: Tags = None,
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> Result[meshio.Mesh]: ...
def optimize(
    mesh: Any,
    tets: ArrayLike | None = None,
    *,
    tags: Tags = None,
    progress: bool | Callable[[Progress], object] = False,
    **options: Unpack[Options],
) -> Result[Any]:
    """Improves a tetrahedral mesh; the argument is not changed.

    Args:
        mesh: points of shape (n, 3) with `tets` of shape (m, 4), zero-based; or a TetMesh, meshio.Mesh or
            pyvista.UnstructuredGrid. Point data follow their vertex, cell data the parent tetrahedron. An inserted
            vertex has means of its neighbors' floating-point data (by mean value coordinates, which reproduce linear
            fields exactly), and other data of the nearest vertex of the input.
        tags: of a meshio or pyvista mesh, the name of the cell data that number regions, patches and lines: faces
            between regions are kept. By default the first of `medit:ref`, `gmsh:physical`, `gmsh:geometrical` that the
            mesh has; False: none.
        progress: True shows a progress bar on a terminal; or a function that is called between passes and stops the
            run by returning False: the result is then the best mesh so far, and valid.
        options: see Options.

    Raises:
        MeshError: the mesh is not valid: it has inverted elements, indices out of range or the like.
        OverlapError: the mesh overlaps itself, and flips would make faces that three or more tetrahedra share.
        UntangleError: the option untangle could not make every volume positive.
        OptionError: an option is out of its range, or names a tag that no element has. (Options
            without effect are a UserWarning.)
    """
    work, adapter = _prepared(mesh, tets, tags)
    before = np.asarray(mesh if tets is not None else adapter.points(), dtype=np.float64)
    if progress is True:
        from ._progress import ProgressBar

        bar = ProgressBar()
        with bar:
            report = _core.improve(work, dict(options), bar)
    else:
        report = _core.improve(work, dict(options), progress if callable(progress) else None)
    vertex_map = _vertex_map(report, len(work.points))
    moved = (vertex_map < 0) | np.any(work.points != before[vertex_map], axis=1)
    return Result(adapter.result(work, report, vertex_map), report, vertex_map, report.tet2original, moved)


def quality(mesh: Any, tets: ArrayLike | None = None, *, worst: int = 10, threads: int = 0) -> Quality:
    """Element quality of a mesh, given as in optimize(), with its `worst` worst tetrahedra."""
    return _core.measure_all(_measured(mesh, tets), worst=worst, threads=threads)


def measure_each(mesh: Any, tets: ArrayLike | None = None, *, threads: int = 0) -> dict[str, Float64s]:
    """All measures of each tetrahedron of a mesh, given as in optimize(), by name."""
    return _core.measure_each(_measured(mesh, tets), threads=threads)


def _measured(mesh: Any, tets: ArrayLike | None) -> TetMesh:
    if isinstance(mesh, TetMesh) and tets is None:
        return mesh
    return _prepared(mesh, tets, None)[0]

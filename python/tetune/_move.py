# SPDX-License-Identifier: Apache-2.0
"""move() for arrays and for the meshes of other packages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._arguments import Targets, check_data, prepared, with_progress
from ._core import MoveReport, OptionError, Progress, TetMesh
from ._optimize import Result, result_of
from ._options import Options
from ._tags import Tags

if TYPE_CHECKING:
    from typing import Unpack

    import meshio
    import pyvista as pv

M = TypeVar("M")


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
    there bit for bit. With boundary="slide" the rest of the surface slides on that of the input; max_deviation must then
    be 0.

    Raises:
        OptionError: `to` is not usable, or as in optimize().
        MeshError, CurvedError, OverlapError, UntangleError: as in optimize().
    """
    work, adapter = prepared(mesh, tets, tags)
    check_data(adapter, options)
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
    motion = with_progress(progress, lambda hook: _core.move(work, arrays, dict(options), hook))
    r = result_of(work, adapter, motion.optimization, before, dict(options), displacement)
    return MoveResult(r.mesh, r.report, r.vertex_map, r.parent, r.moved, r.criteria, r.geometry, motion)

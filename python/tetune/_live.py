# SPDX-License-Identifier: Apache-2.0
"""A mesh that a simulation changes step after step."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._core import MoveReport, Progress, Report, TetMesh
from ._arguments import prepared, with_progress
from ._options import Options

if TYPE_CHECKING:
    from typing import Unpack


class LiveMesh:
    """A mesh that stays in memory while a simulation changes it: each call works on the part that was disturbed and its
    neighborhood, and all else keeps its positions and numbers bit for bit.

        live = tetune.LiveMesh(points, tets)
        for step in range(1000):
            report = live.move(targets(live.points))

    Args:
        mesh: arrays of points and `tets`, a TetMesh, or a meshio or pyvista mesh, as in optimize(). It is copied.
        neighborhood: the number of rings of tetrahedra around a disturbed one that may change, 1 to 100.
        options: as in optimize(), for all calls; without only_below.

    Not for calls from several threads at a time, nor from its own progress function.
    """

    def __init__(self, mesh: Any, tets: ArrayLike | None = None, *, neighborhood: int = 3, **options: Unpack[Options]) -> None:
        work, adapter = prepared(mesh, tets, None)
        if adapter.vertices() is not None:
            raise _core.MeshError("LiveMesh holds no mid-side nodes; give it the vertices and linear tetrahedra alone")
        self._core = _core.LiveMesh(work, dict(options), neighborhood)

    @property
    def mesh(self) -> TetMesh:
        """A copy of the mesh."""
        return self._core.mesh

    @property
    def points(self) -> NDArray[np.float64]:
        """A copy of the positions, of shape (n, 3)."""
        return self._core.points

    @property
    def tets(self) -> NDArray[np.int32]:
        """A copy of the tetrahedra, of shape (m, 4)."""
        return self._core.tets

    @property
    def disturbed(self) -> int:
        """The number of vertices disturbed since the last optimize()."""
        return self._core.disturbed

    def set_points(self, vertices: ArrayLike, points: ArrayLike) -> None:
        """Sets positions of the listed vertices, and marks these as disturbed. Tetrahedra may become inverted: then
        optimize() requires the option untangle.

        Raises:
            OptionError: a vertex does not exist, or a position is not finite; the mesh is then unchanged.
        """
        ids = np.atleast_1d(np.asarray(vertices))
        if ids.size > 0 and not np.issubdtype(ids.dtype, np.integer):
            raise TypeError(f"vertices must be integers, the numbers of vertices, and not {ids.dtype}")
        positions = np.atleast_2d(np.asarray(points, dtype=np.float64))
        if positions.size == 0:
            positions = positions.reshape(0, 3)
        if positions.shape != (len(ids), 3):
            raise _core.OptionError(f"points has the shape {positions.shape} for {len(ids)} vertices; it must be ({len(ids)}, 3)")
        self._core.set_points(ids.tolist(), positions)

    def optimize(self, *, everything: bool = False, progress: bool | Callable[[Progress], object] = False) -> Report:
        """Optimizes the tetrahedra with a disturbed vertex and their neighborhood; with `everything` the whole mesh,
        whose tetrahedra then get other numbers. Raises as optimize()."""
        return with_progress(progress, lambda hook: self._core.optimize(everything, hook))

    def move(self, to: ArrayLike, *, progress: bool | Callable[[Progress], object] = False) -> MoveReport:
        """Moves vertices to prescribed positions: `to` has one row per vertex, with three NaN for one that follows. The
        neighborhood of those that move follows and is improved; it is doubled while the target cannot be reached. Raises
        as move()."""
        target = np.asarray(to, dtype=np.float64)
        return with_progress(progress, lambda hook: self._core.move(target, hook))

# SPDX-License-Identifier: Apache-2.0
"""`grid.tetune` of a pyvista.UnstructuredGrid. pyvista imports this by the entry point `pyvista.accessors`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from typing import TYPE_CHECKING

import pyvista as pv

from ._arguments import Criteria, Float64s, Targets
from ._core import AcceptanceReport, Geometry, Progress, Quality
from ._measure import check, measure_each, quality
from ._move import MoveResult, move
from ._optimize import Result, optimize
from ._options import Options

if TYPE_CHECKING:
    from typing import Unpack

    from ._tags import Tags


@pv.register_dataset_accessor("tetune", pv.UnstructuredGrid)  # type: ignore[untyped-decorator, unused-ignore]
class TetuneAccessor:
    """Optimizes, moves and measures the tetrahedra of a grid."""

    def __init__(self, grid: pv.UnstructuredGrid) -> None:
        self._grid = grid

    def optimize(
        self,
        *,
        tags: Tags = None,
        progress: bool | Callable[[Progress], object] = False,
        criteria: Criteria | None = None,
        geometry: Geometry | str | PathLike[str] | None = None,
        snap: bool = True,
        **options: Unpack[Options],
    ) -> pv.UnstructuredGrid:
        """The improved grid: `tetune.optimize(grid, ...).mesh`."""
        return self.run(tags=tags, progress=progress, criteria=criteria, geometry=geometry, snap=snap, **options).mesh

    def run(
        self,
        *,
        tags: Tags = None,
        progress: bool | Callable[[Progress], object] = False,
        criteria: Criteria | None = None,
        geometry: Geometry | str | PathLike[str] | None = None,
        snap: bool = True,
        **options: Unpack[Options],
    ) -> Result[pv.UnstructuredGrid]:
        """`tetune.optimize(grid, ...)`, with the report and the maps."""
        return optimize(self._grid, tags=tags, progress=progress, criteria=criteria, geometry=geometry, snap=snap, **options)

    def move(
        self,
        to: Targets | str,
        *,
        tags: Tags = None,
        surface: bool = False,
        patches: Sequence[int] = (),
        progress: bool | Callable[[Progress], object] = False,
        **options: Unpack[Options],
    ) -> MoveResult[pv.UnstructuredGrid]:
        """`tetune.move(grid, to=to, ...)`."""
        return move(
            self._grid, to=to, tags=tags, surface=surface, patches=patches, progress=progress, **options
        )

    def quality(self, *, worst: int = 10, threads: int = 0) -> Quality:
        """`tetune.quality(grid)`."""
        return quality(self._grid, worst=worst, threads=threads)

    def check(self, criteria: Criteria, *, threads: int = 0) -> AcceptanceReport:
        """`tetune.check(grid, criteria)`."""
        return check(self._grid, criteria, threads=threads)

    def measure_each(self, *, threads: int = 0) -> dict[str, Float64s]:
        """`tetune.measure_each(grid)`: all measures of each tetrahedron, in the order of the grid's tetrahedra."""
        return measure_each(self._grid, threads=threads)

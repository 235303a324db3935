# SPDX-License-Identifier: Apache-2.0
"""The arguments of optimize(), move() and the like."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, TypeVar, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._adapter import Adapter
from ._adapters import adapter_of
from ._core import Geometry, OptionError, Progress, TetMesh
from ._tags import Tags

if TYPE_CHECKING:
    from typing import TypeAlias

Float64s = NDArray[np.float64]
Targets: TypeAlias = Union[ArrayLike, Sequence[ArrayLike]]
Criteria: TypeAlias = Union[str, PathLike[str], Mapping[str, Mapping[str, float]]]
R = TypeVar("R")


def prepared(mesh: Any, tets: Any, tags: Tags) -> tuple[TetMesh, Adapter[Any]]:
    """A TetMesh with its own memory, and the adapter that converts the result back."""
    if tets is not None:
        if tags is not None:
            raise TypeError("tags names data of a meshio or pyvista mesh; with arrays use TetMesh(points, tets, tet_tags=...)")
        return TetMesh(mesh, tets), Adapter()
    adapter = adapter_of(mesh, tags)
    return adapter.tet_mesh(), adapter


def measured(mesh: Any, tets: ArrayLike | None) -> TetMesh:
    if isinstance(mesh, TetMesh) and tets is None:
        return mesh
    return prepared(mesh, tets, None)[0]


def check_data(adapter: Adapter[Any], options: Mapping[str, Any]) -> None:
    if options.get("data") == "conserve" and adapter.vertices() is not None:
        raise OptionError("data='conserve' is for linear cells, and these have mid-side nodes; use data='interpolate'")


def model_of(geometry: Geometry | str | PathLike[str], threads: int) -> Geometry:
    return geometry if isinstance(geometry, Geometry) else Geometry(geometry, threads=threads)


def criteria_of(given: Criteria) -> str | dict[str, Mapping[str, float]]:
    return dict(given) if isinstance(given, Mapping) else fspath(given)


def with_progress(
    progress: bool | Callable[[Progress], object], run: Callable[[Callable[[Progress], object] | None], R]
) -> R:
    if callable(progress) or not progress:
        return run(progress if callable(progress) else None)
    from ._progress import ProgressBar

    bar = ProgressBar()
    with bar:
        return run(bar)

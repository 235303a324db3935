# SPDX-License-Identifier: Apache-2.0
"""A mesh as the caller gives it: conversion to a TetMesh, and of the result back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._core import Report, TetMesh
from ._point_data import Unchanged
from ._second_order import Nodes

if TYPE_CHECKING:
    from typing import TypeAlias

M = TypeVar("M")
Array: TypeAlias = NDArray[Any]


class Adapter(Generic[M]):
    """A mesh given as arrays, for which the result is a TetMesh. Base of the other adapters."""

    conserves = False
    """Whether the result is of a run with data="conserve"."""

    def tet_mesh(self) -> TetMesh:
        raise NotImplementedError

    def points(self) -> Array:
        raise NotImplementedError

    def point_data(self, name: str) -> Array:
        """A displacement: point data with three numbers per vertex."""
        raise TypeError(f"to is {name!r}, the name of point data, which a meshio or pyvista mesh has; "
                        "give the positions as an array")

    def fields(self) -> list[str]:
        """The names of floating-point data of the vertices."""
        return []

    def vertices(self) -> Array | None:
        """The points that are vertices, or None for all: the others are mid-side nodes."""
        return None

    def nodes(self, work: TetMesh, report: Report | Unchanged, vertex_map: NDArray[np.int32]) -> Nodes:
        """The nodes of the result."""
        return Nodes(work.points, vertex_map)

    def result(self, work: TetMesh, report: Report | Unchanged, nodes: Nodes) -> Any:
        return work

    def second_order(self, work: TetMesh) -> Any:
        """The result for the mesh of which curve() has made `work`."""
        return work


class OwnAdapter(Adapter[TetMesh]):
    def __init__(self, mesh: TetMesh) -> None:
        self._mesh = mesh

    def tet_mesh(self) -> TetMesh:
        return self._mesh.copy()

    def points(self) -> Array:
        return self._mesh.points

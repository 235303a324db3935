# SPDX-License-Identifier: Apache-2.0
"""curve() for arrays and for the meshes of other packages."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import Any, Generic, TypeVar

from numpy.typing import ArrayLike

from . import _core
from ._arguments import measured, model_of, prepared
from ._core import CurveReport, Geometry
from ._tags import Tags

M = TypeVar("M")


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
    work, adapter = prepared(mesh, tets, tags)
    finer = None if surface is None else measured(surface, None)
    model = None if geometry is None else model_of(geometry, threads)
    report = _core.curve(work, feature_angle=feature_angle, threads=threads, surface=finer, geometry=model)
    return CurveResult(adapter.second_order(work), report)

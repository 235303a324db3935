# SPDX-License-Identifier: Apache-2.0
"""optimize() and quality() for arrays and for the meshes of other packages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, Literal, TypedDict, TypeVar, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._adapters import Adapter, Tags, adapter_of
from ._core import Progress, Quality, Report, TetMesh

if TYPE_CHECKING:
    import meshio
    import pyvista as pv

Float64s = NDArray[np.float64]
M = TypeVar("M")


class Options(TypedDict, total=False):
    """Options of optimize(): names, meaning and defaults as in C++ (`tetune/optimize.hpp`)."""

    device: Literal["automatic", "cpu", "cuda"]
    """Where to compute; cpu (default); automatic: cuda for a million tetrahedra or more where that can be, else cpu."""
    boundary: Literal["preserve", "slide", "fixed"]
    """preserve (default): vertices move in the surface's planes and along its straight lines; slide: on the input
    surface and along its feature lines; fixed: not at all."""
    energy: Literal["shape", "harmonic"]
    """shape (default): scale-free; harmonic: the paper's."""
    effort: Literal["fast", "standard", "best"]
    """fast: a little less quality in less time; standard (default); best: more work on the smallest dihedral angles,
    vertices are inserted and removed there."""
    keep_vertices: bool
    """With effort best: no vertex is inserted or removed."""
    relocation: Literal["newton", "gradient"]
    """gradient: as in the paper, slower."""
    termination: Literal["relative", "paper"]
    """paper: conditions C1 to C3."""
    untangle: bool
    """Inverted and flat tetrahedra are made positive before all else, instead of refused."""
    feature_angle: float
    """With boundary slide: edges where the surface turns by more degrees than this (45) are features."""
    max_deviation: float
    """With boundary slide: most distance between the old and the new surface; a length, 0 (default) for no bound."""
    open_boundaries: bool
    """Whether tagged triangles inside a region stay faces of the mesh (default)."""
    frozen_regions: ArrayLike
    """Tags of tetrahedra that stay as they are to the last bit."""
    frozen_patches: ArrayLike
    """Tags of listed triangles that stay as they are to the last bit."""
    frozen_vertices: ArrayLike
    """For each vertex whether it must not move."""
    max_iterations: int
    """Most relocation sweeps (100); 0: flips alone."""
    threads: int
    """CPU threads; 0 (default): all. The result does not depend on it."""
    max_ring: int
    """Largest ring of tetrahedra around an edge that flips remove or make, 3 to 7 (default)."""
    flips: bool
    """False: vertices alone are moved."""
    boundary_flips: bool
    """Whether edges within flat parts of the boundary may be flipped (default)."""
    targets: Mapping[str, float]
    """What every element is to reach, by measure: {'min_dihedral_deg': 15}. Changes nothing in what is done;
    Report.targets says which elements miss it, and why."""
    trace_angles: bool
    """Whether the smallest dihedral angle is measured after each sweep and round, for the report."""


@dataclass(frozen=True)
class Result(Generic[M]):
    """What optimize() hands back."""

    mesh: M
    """The mesh, of the kind that was given."""
    report: Report
    """What was done: energies, flips, sweeps, times, targets."""
    vertex_map: NDArray[np.int32]
    """For each vertex of the result the one of the input, -1 for an inserted one."""
    parent: NDArray[np.int32]
    """For each tetrahedron of the result one of the input, of the same region, whose place it took."""
    moved: NDArray[np.bool_] = field(repr=False)
    """For each vertex of the result whether it is elsewhere than in the input."""


def _prepared(mesh: Any, tets: Any, tags: Tags) -> tuple[TetMesh, Adapter[Any]]:
    """A TetMesh of its own memory, and the way back."""
    if tets is not None:
        if tags is not None:
            raise TypeError("tags names data of a meshio or pyvista mesh; for arrays use TetMesh(points, tets, tet_tags=...)")
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
    """Improves a tetrahedral mesh; what is given stays as it is.

    Args:
        mesh: points of shape (n, 3) with `tets` of shape (m, 4), zero-based; or a TetMesh, meshio.Mesh or
            pyvista.UnstructuredGrid. Point data follow their vertex, cell data the parent tetrahedron. An inserted
            vertex has means of its neighbours' floating-point data (mean value coordinates: linear fields exactly);
            of other data, what the nearest vertex of the input has.
        tags: of a meshio or pyvista mesh, the name of the cell data that number regions, patches and lines: faces
            between regions stay. By default the first of `medit:ref`, `gmsh:physical`, `gmsh:geometrical` that is
            there; False: none.
        progress: True shows a progress bar on a terminal; or a function that is called between passes and stops the
            run by returning False: the mesh is then the best so far, and valid.
        options: see Options.

    Raises:
        MeshError: the mesh is not valid: inverted elements, wild indices and the like.
        OverlapError: flips would make faces that three or more tetrahedra share, as the mesh overlaps itself.
        UntangleError: the option untangle could not make every volume positive.
        OptionError: an option out of its range, or one that cannot take effect.
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

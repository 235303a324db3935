# SPDX-License-Identifier: Apache-2.0
# Generated from the library's table of options by: tetune_option_reference python
# ruff: noqa: E501
"""The options of optimize()."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypedDict

from numpy.typing import ArrayLike


class Options(TypedDict, total=False):
    """Options of optimize(), with the names, meanings and defaults of C++ (`tetune/options.hpp`)."""

    boundary: Literal["preserve", "slide", "fixed"]
    """How vertices of the boundary may move; preserve: vertices move within planes and along straight lines of the surface, whose shape does not change; slide: vertices move on the input surface and along its feature lines, and the surface changes a little; fixed: no vertex of the boundary moves. Default: preserve."""
    feature_angle: float
    """With boundary=slide, edges where the surface turns by a larger angle are feature lines, which vertices do not leave, except for lines that end in the middle of the surface and nowhere turn by more than 4/3 of the angle; 180: no edge is a feature by its angle. Default: 45."""
    max_deviation: float
    """With boundary=slide, maximum distance of the new surface from the old one and of the old one from the new one; 0: no bound. Default: 0."""
    frozen_regions: ArrayLike
    """Tags of the regions whose tetrahedra do not change. Default: none."""
    frozen_patches: ArrayLike
    """Tags of the patches whose listed triangles do not change. Default: none."""
    frozen_vertices: ArrayLike
    """One flag per vertex, or none: a vertex with a flag other than 0 does not move. Default: none."""
    open_boundaries: bool
    """Tagged triangles with the same region on both sides stay faces of the mesh; otherwise they are dropped. Default: True."""
    boundary_flips: bool
    """Edges between coplanar triangles of one patch of the boundary, or of one interface, may be flipped; with max_deviation, unless vertices of the surface are inserted and removed, in patches that lie in a plane. Default: True."""
    effort: Literal["fast", "standard", "best"]
    """How much is done; fast: flips are searched for once, and sweeps end when one lowers the energy by less than 2 %; standard: sweeps end at 0.2 %, then the worst elements and the smallest dihedral angles are improved; best: sweeps end at 0.01 %, then there is more of that work, and vertices are inserted and removed. Default: standard."""
    keep_vertices: bool
    """No vertex is inserted or removed, as effort=best and surface_vertices=edit do otherwise, and untangle=true in curved meshes. Default: False."""
    max_growth: float
    """Vertices are inserted while the ratio of the numbers of tetrahedra of result and input is below this. A larger value allows insertion around more of the worst tetrahedra, at proportional cost. Flips are not limited: in a mesh of a few dozen tetrahedra they may add one more. With untangle=true it limits splits of valid curved elements too, whatever the other options are. Default: 1.1."""
    surface_vertices: Literal["auto", "keep", "edit"]
    """Whether vertices of the surface and of interfaces are inserted and removed; auto: as edit with effort=best, else as keep; keep: none is inserted or removed; edit: vertices are inserted and removed, inside the mesh too; with boundary=preserve in flat parts of a patch and along straight feature lines, so that the surface keeps its shape; with boundary=slide on the input surface and its feature lines, and edges of the surface are flipped. Default: auto."""
    restarts: int
    """With effort=best, the maximum number of rounds of restarts: a round optimizes the neighborhoods of at most four of the worst elements again, without regard to the angles reached, and keeps a result that improves the worst element in it. At most as many rounds follow that lower the largest dihedral angle and leave the smallest; 0: none; -1: 10 of each, of the first kind one per 400 tetrahedra in smaller meshes. Default: -1."""
    untangle: bool
    """Inverted and flat tetrahedra are made positive first, instead of refused. Curved second-order elements that the surface alone makes invalid are split, and within max_growth those that it makes nearly so. Default: False."""
    straighten: bool
    """Where mid-side nodes of a curved surface make elements invalid, they move toward the middle of their chord, as little as makes the elements valid, instead of being refused. Default: False."""
    flips: bool
    """Edges and faces are flipped; otherwise vertices are moved, and with effort=best inserted and removed. Default: True."""
    energy: Literal["shape", "harmonic"]
    """Energy per tetrahedron, the sum of which is minimized; shape: (eta / eta_r)^(3/2), scale-free: small elements count as much as large ones; harmonic: eta, the energy of the paper, a length: large elements count for more. Default: shape."""
    relocation: Literal["newton", "gradient"]
    """How a vertex is moved; newton: over-relaxed Newton steps; gradient: steepest descent with a line search, as in the paper (Alg. 1); slower. Default: newton."""
    termination: Literal["relative", "paper"]
    """When sweeps end; relative: when a sweep lowers the energy by less than the part that effort sets; paper: by the conditions C1 to C3 of the paper (Sect. 4.5). Default: relative."""
    max_iterations: int
    """Maximum number of relocation sweeps; 0: only flips. Default: 100."""
    max_ring: int
    """Maximum number of tetrahedra around an edge that a flip removes or creates; 3: only 3-2 and 2-3 flips, as in the paper. Default: 7."""
    targets: Mapping[str, float]
    """Quality that every element should have, by measure. It does not change the result: the report lists the elements that miss it and what constrains them. Default: none."""
    only_below: Mapping[str, float]
    """Limits of quality, by measure: only tetrahedra that miss one, and those around them, may change; all others stay bit for bit, and in their order. Default: none."""
    rings: int
    """How far around the tetrahedra of only_below others may change: each ring is the tetrahedra that share a vertex with those before. Default: 2."""
    threads: int
    """Number of CPU threads; 0: all. The result does not depend on it. Default: 0."""
    device: Literal["auto", "cpu", "cuda"]
    """Where to compute; auto: as cuda for 500000 tetrahedra or more if there is a GPU with enough memory, else as cpu; cpu: on CPU threads; cuda: on the current NVIDIA GPU, compute capability 7.5 or newer. Default: cpu."""
    data: Literal["carry", "interpolate", "conserve"]
    """What data are on the result; carry: those of the vertex of the input, wherever it has moved; interpolate: those of the input at the place of the vertex: floating-point numbers linearly, integers of the nearest vertex; conserve: floating-point data of vertices and of tetrahedra keep their integrals and get no new extremes, by the overlap of old and new tetrahedra; integers are those of the largest overlap; not for inverted or curved elements. Default: carry."""
    trace_angles: bool
    """The smallest dihedral angle is measured after each sweep and round, for the report; takes a twelfth of the time. Default: False."""

# SPDX-License-Identifier: Apache-2.0
"""quality(), check() and the like, for arrays and for the meshes of other packages."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from . import _core
from ._arguments import Criteria, Float64s, criteria_of, measured
from ._core import AcceptanceReport, CurvedTet, Quality


def quality(mesh: Any, tets: ArrayLike | None = None, *, worst: int = 10, threads: int = 0) -> Quality:
    """Element quality of a mesh, given as in optimize(), with its `worst` worst tetrahedra."""
    return _core.measure_all(measured(mesh, tets), worst=worst, threads=threads)


def measure_curved_each(mesh: Any, tets: ArrayLike | None = None, *, threads: int = 0) -> list[CurvedTet]:
    """Validity and measures of each second-order tetrahedron with a curved edge of a mesh, given as in optimize()."""
    return _core.measure_curved_each(measured(mesh, tets), threads=threads)


def measure_each(mesh: Any, tets: ArrayLike | None = None, *, threads: int = 0) -> dict[str, Float64s]:
    """All measures of each tetrahedron of a mesh, given as in optimize(), by name."""
    return _core.measure_each(measured(mesh, tets), threads=threads)


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
    return _core.check(measured(mesh, tets), criteria_of(criteria), threads=threads)

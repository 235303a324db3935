# SPDX-License-Identifier: Apache-2.0
"""Data of the vertices of a mesh of another package, on the result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._core import OptionError, Report, TetMesh
from ._core import carry_point_data as carried

if TYPE_CHECKING:
    from typing import TypeAlias

Array: TypeAlias = NDArray[Any]


class Unchanged:
    """A report on a mesh with the same vertices and elements as before."""

    vertex2original = tet2original = triangle2original = edge2original = np.array([], dtype=np.int32)
    place_vertices = np.array([], dtype=np.int32)
    place_weights = np.array([], dtype=np.float64)


def displacement_of(data: Mapping[str, Any], name: str) -> Array:
    if name not in data:
        raise OptionError(f"to is {name!r}; the point data of this mesh are: {', '.join(data) or 'none'}")
    values = np.asarray(data[name])
    if values.ndim != 2 or values.shape[1] != 3:
        raise OptionError(f"to is {name!r}, which has the shape {values.shape}; a displacement has three numbers per vertex")
    return values


def is_smooth(values: Array) -> bool:
    """Whether these are floating-point data, in either byte order: meshio reads legacy files of VTK without swapping."""
    return values.size > 0 and values.dtype.newbyteorder("=") in (np.float64, np.float32)


def as_rows(values: Array) -> Array:
    """An array of two dimensions with one row per entry, in the byte order of the processor."""
    return np.ascontiguousarray(values, values.dtype.newbyteorder("=")).reshape(len(values), -1)


def transfer_point_data(
    data: Mapping[str, Any], work: TetMesh, report: Report | Unchanged, vertex_map: NDArray[np.int32], vertices: int
) -> dict[str, Array]:
    """Data of the vertices of the result, as the option `data` says."""
    if len(report.place_weights) == 0:
        return carry_point_data(data, work, vertex_map, vertices)
    places, weights = report.place_vertices, report.place_weights
    return {name: interpolated(np.asarray(values), places, weights) for name, values in data.items()}


def interpolated(values: Array, places: Array, weights: Array) -> Array:
    """Floating-point data at places in the input, within the values of their four vertices; other data of the vertex of
    the largest weight."""
    nearest: Array = values[places[np.arange(len(places)), weights.argmax(axis=1)]]
    if not is_smooth(values):
        return nearest
    corners = values.reshape(len(values), -1)[places].astype(np.float64)
    w = weights[:, :, None]
    counts = w > 0
    with np.errstate(invalid="ignore"):
        mean = np.where(counts, w * corners, 0).sum(axis=1)
    low = np.where(counts, corners, np.inf).min(axis=1)
    high = np.where(counts, corners, -np.inf).max(axis=1)
    mean = np.clip(mean, low, high).reshape(nearest.shape)
    result: Array = np.where(np.isfinite(mean), mean, nearest).astype(values.dtype)
    return result


def carry_point_data(
    data: Mapping[str, Any], work: TetMesh, vertex_map: NDArray[np.int32], vertices: int
) -> dict[str, Array]:
    """Data of the vertices of the result. An inserted vertex gets means of its neighbors' floating-point data, and
    other data of the nearest vertex of the input."""
    old = {name: np.asarray(values) for name, values in data.items()}
    if len(old) == 0 or (vertex_map >= 0).all():
        return {name: values[vertex_map] for name, values in old.items()}
    smooth = [name for name, values in old.items() if is_smooth(values)]
    rows = np.arange(vertices, dtype=np.int32)
    source, *means = carried(
        work, vertex_map, [as_rows(v) for v in (rows, *(old[name] for name in smooth))]
    )
    mean_of = dict(zip(smooth, means))
    return {
        name: mean_of[name].reshape(-1, *values.shape[1:]) if name in mean_of else values[source[:, 0]]
        for name, values in old.items()
    }

# SPDX-License-Identifier: Apache-2.0
"""Tags and required entities in the data of a mesh of another package: the arrays that have a meaning in VTK's files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Union
from warnings import warn

import numpy as np
from numpy.typing import NDArray

from ._core import OptionError
from ._vtk_stream import CELL_FLAGS, CELLS, POINT_FLAGS, SIMPLICES, TAG_NAMES, whole_numbers

if TYPE_CHECKING:
    from typing import TypeAlias

Tags: TypeAlias = Union[str, Literal[False], None]
Array: TypeAlias = NDArray[Any]
# The values of the cell data of a name, one array per block.
Values: TypeAlias = Callable[[str], Sequence[Any]]


def tags_of(tags: Tags, names: Sequence[str], values_of: Values) -> list[Array] | None:
    """The tags of each block that the argument `tags` chooses, or None."""
    if tags is False:
        return None
    if tags is not None:
        if tags not in names:
            raise OptionError(f"tags is {tags!r}; the cell data of this mesh are: {', '.join(names) or 'none'}")
        return [_as_tags(tags, values) for values in values_of(tags)]
    for name in TAG_NAMES:
        if name not in names:
            continue
        numbers = [whole_numbers(np.asarray(values)) for values in values_of(name)]
        found = [n for n in numbers if n is not None]
        if len(found) == len(numbers):
            return found
        warn(f'"{name}" does not hold integers of 32 bits: kept as data, not as tags', stacklevel=7)
    return None


def _as_tags(name: str, values: Any) -> Array:
    values = np.asarray(values)
    if values.ndim != 1:
        raise OptionError(f"tags is {name!r}, which has {values.shape[1]} numbers per cell; it must have one")
    if values.dtype.kind not in "biuf":
        raise OptionError(f"tags is {name!r}, which holds no numbers; tags must be whole ones")
    with np.errstate(invalid="ignore"):
        whole: Array = values.astype(np.int64)
    if not np.array_equal(whole, values):
        raise OptionError(f"tags is {name!r}, which has numbers that are not whole; tags must be")
    return whole


def _flags(values: Any) -> Array | None:
    """One boolean per entry; None if there is not one number per entry."""
    values = np.asarray(values)
    if values.dtype.kind not in "biuf" or values.size != len(values):
        return None
    flags: Array = values.reshape(-1) != 0
    return flags


def required_of(
    point_data: Mapping[str, Any], vertices: Array | None, kinds: Sequence[str], names: Sequence[str], values_of: Values
) -> dict[str, Any]:
    """Arguments of TetMesh(): the corners, ridges and required entities. `vertices`: the points that are vertices, or
    None for all; `kinds`: the linear kind of each block."""
    required: dict[str, Any] = {}
    for argument, name in POINT_FLAGS.items():
        flags = _flags(point_data[name]) if name in point_data else None
        if flags is not None:
            required[argument] = np.flatnonzero(flags if vertices is None else flags[vertices])
    for argument, (name, simplex) in CELL_FLAGS.items():
        if name not in names:
            continue
        kind = CELLS[SIMPLICES[simplex][1]][1]
        parts = [_flags(values) for values, k in zip(values_of(name), kinds) if k == kind]
        found = [p for p in parts if p is not None]
        if 0 < len(found) == len(parts):
            required[argument] = np.flatnonzero(np.concatenate(found))
    return required


def without_inserted(new: dict[str, Array], old: Mapping[str, Any], origin: NDArray[np.int32]) -> dict[str, Array]:
    """Point data with the flags of the input's nodes: an inserted node is neither a corner nor required, whatever its
    neighbors are."""
    for name in POINT_FLAGS.values():
        if name in new:
            flags = np.asarray(old[name])[np.maximum(origin, 0)]
            flags[origin < 0] = 0
            new[name] = flags
    return new

# SPDX-License-Identifier: Apache-2.0
"""The adapter for each kind of mesh."""

from __future__ import annotations

import sys
from typing import Any

from ._adapter import Adapter, OwnAdapter
from ._core import TetMesh
from ._meshio_adapter import MeshioAdapter
from ._pyvista_adapter import PyvistaAdapter
from ._tags import Tags


def adapter_of(mesh: Any, tags: Tags) -> Adapter[Any]:
    """The adapter for `mesh`. It imports no package that is not imported already."""
    if isinstance(mesh, TetMesh):
        if tags is not None:
            raise TypeError("tags names data of a meshio or pyvista mesh; a TetMesh has tet_tags")
        return OwnAdapter(mesh)
    for package, kind, adapter in (
        ("meshio", "Mesh", MeshioAdapter),
        ("pyvista", "UnstructuredGrid", PyvistaAdapter),
    ):
        module = sys.modules.get(package)
        if module is not None and isinstance(mesh, getattr(module, kind)):
            return adapter(mesh, tags)
    raise TypeError(
        "a mesh is given as points and tets, or as a tetune.TetMesh, meshio.Mesh or pyvista.UnstructuredGrid; "
        f"this is a {type(mesh).__module__}.{type(mesh).__qualname__}"
    )

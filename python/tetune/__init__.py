# SPDX-License-Identifier: Apache-2.0
"""Improves tetrahedral meshes.

    result = tetune.optimize(points, tets)            # numpy arrays
    result = tetune.optimize(mesh)                    # meshio.Mesh, pyvista.UnstructuredGrid, tetune.TetMesh
    result.mesh, result.report, result.vertex_map, result.parent, result.moved
"""

from importlib.metadata import version

from ._core import (
    Comparison,
    DeviceError,
    Error,
    FileError,
    FlipReport,
    MeasureSummary,
    MeshError,
    MissedTet,
    OptionError,
    OverlapError,
    Progress,
    Quality,
    Report,
    SweepReport,
    TargetReport,
    TetMesh,
    UntangleError,
    WorstReport,
    WorstTet,
    compare,
    read_mesh,
    validate,
    write_mesh,
)
from ._optimize import Result, measure_each, optimize, quality
from ._options import Options

__version__ = version("tetune")

__all__ = [
    "Comparison",
    "DeviceError",
    "Error",
    "FileError",
    "FlipReport",
    "MeasureSummary",
    "MeshError",
    "MissedTet",
    "OptionError",
    "OverlapError",
    "Options",
    "Progress",
    "Quality",
    "Report",
    "Result",
    "SweepReport",
    "TargetReport",
    "TetMesh",
    "UntangleError",
    "WorstReport",
    "WorstTet",
    "__version__",
    "compare",
    "measure_each",
    "optimize",
    "quality",
    "read_mesh",
    "validate",
    "write_mesh",
]

# SPDX-License-Identifier: Apache-2.0
"""Improves tetrahedral meshes.

    result = tetune.optimize(points, tets)            # numpy arrays
    result = tetune.move(points, tets, targets)       # prescribed vertices, the others follow
    result = tetune.optimize(mesh)                    # meshio.Mesh, pyvista.UnstructuredGrid, tetune.TetMesh
    result.mesh, result.report, result.vertex_map, result.parent, result.moved
"""

from importlib.metadata import version

from ._core import (
    AcceptanceReport,
    Comparison,
    CriteriaReport,
    CriteriaRound,
    CriterionLimits,
    CriterionResult,
    CurveReport,
    CurvedQuality,
    CurvedTet,
    DeviceError,
    DistanceSummary,
    Error,
    FaceDeviation,
    FileError,
    FlipReport,
    Geometry,
    GeometryDeviation,
    GeometryMatch,
    GeometryReport,
    MeasureSummary,
    MeshError,
    MissedTet,
    MoveReport,
    MoveStep,
    OptionError,
    OverlapError,
    Progress,
    Quality,
    Report,
    StraightenedEdge,
    SweepReport,
    TargetReport,
    TetMesh,
    UntangleError,
    WorstReport,
    WorstTet,
    compare,
    conserve_data,
    read_mesh,
    read_series,
    validate,
    write_mesh,
    write_series,
)
from ._curve import CurveResult, curve
from ._live import LiveMesh
from ._measure import check, measure_curved_each, measure_each, quality
from ._move import MoveResult, move
from ._optimize import Result, optimize
from ._options import Options

__version__ = version("tetune")

__all__ = [
    "AcceptanceReport",
    "Comparison",
    "CriteriaReport",
    "CriteriaRound",
    "CriterionLimits",
    "CriterionResult",
    "CurveReport",
    "CurveResult",
    "CurvedQuality",
    "CurvedTet",
    "DeviceError",
    "DistanceSummary",
    "Error",
    "FaceDeviation",
    "FileError",
    "FlipReport",
    "Geometry",
    "GeometryDeviation",
    "GeometryMatch",
    "GeometryReport",
    "LiveMesh",
    "MeasureSummary",
    "MeshError",
    "MissedTet",
    "MoveReport",
    "MoveResult",
    "MoveStep",
    "OptionError",
    "OverlapError",
    "Options",
    "Progress",
    "Quality",
    "Report",
    "Result",
    "StraightenedEdge",
    "SweepReport",
    "TargetReport",
    "TetMesh",
    "UntangleError",
    "WorstReport",
    "WorstTet",
    "__version__",
    "check",
    "compare",
    "conserve_data",
    "curve",
    "measure_curved_each",
    "measure_each",
    "move",
    "optimize",
    "quality",
    "read_mesh",
    "read_series",
    "validate",
    "write_mesh",
    "write_series",
]

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The typed face of the C++ module: bundle adjustment, mesh queries, pairs of features.

Nothing else imports hullrecon._native. The module is built by the (editable) installation and found
through it, from whatever folder or PYTHONPATH Python is started; a checkout that was never
installed has no hullrecon._native. Importing this package does not load it yet.
"""

from hullrecon.native.columns import IDENTITY
from hullrecon.native.curvature import curvature_difference, curvature_information
from hullrecon.native.descriptors import describe_keypoints
from hullrecon.native.drawing import draw_triangles
from hullrecon.native.feature_pairs import best_and_next, descriptor_distances, pairs_in_regions
from hullrecon.native.links import LinkKernel, LinkTable, bearing_basis
from hullrecon.native.mesh_index import Closest, Hits, MeshIndex
from hullrecon.native.pair_motion import (
    ReducedFeatures,
    StereoRows,
    linearise_stereo,
    normal_of_reprojections,
    reduce_stereo,
    squared_reprojections,
)
from hullrecon.native.planes import PlanePairTable, PlaneRangeTable, PlaneSightingTable, PlaneTable
from hullrecon.native.problem import (
    LENS_DEGREE,
    LENS_MODES,
    AttitudeTable,
    CadMesh,
    FieldNodes,
    LensTable,
    LeverArms,
    MonoTable,
    MotionPrior,
    OdometryTable,
    PosePriors,
    PositionTable,
    Priors,
    Problem,
    RangeTable,
    SparseRows,
    StereoTable,
    SurfaceTable,
    TrayTable,
    Unknowns,
    VelocityTable,
)
from hullrecon.native.solver import (
    FACTORS,
    GRAPH_FACTORS,
    Covariance,
    Evaluation,
    IterationRecord,
    Options,
    PairCovariance,
    Result,
    covariance,
    evaluate,
    pair_covariance,
    solve,
)
from hullrecon.native.views import (
    BlendSums,
    incidence,
    insert_view,
    least_tangents,
    project_into,
)

__all__ = [
    "FACTORS",
    "GRAPH_FACTORS",
    "IDENTITY",
    "LENS_DEGREE",
    "LENS_MODES",
    "AttitudeTable",
    "BlendSums",
    "CadMesh",
    "Closest",
    "Covariance",
    "Evaluation",
    "FieldNodes",
    "Hits",
    "IterationRecord",
    "LensTable",
    "LeverArms",
    "LinkKernel",
    "LinkTable",
    "MeshIndex",
    "MonoTable",
    "MotionPrior",
    "OdometryTable",
    "Options",
    "PairCovariance",
    "PlanePairTable",
    "PlaneRangeTable",
    "PlaneSightingTable",
    "PlaneTable",
    "PosePriors",
    "PositionTable",
    "Priors",
    "Problem",
    "RangeTable",
    "ReducedFeatures",
    "Result",
    "SparseRows",
    "StereoRows",
    "StereoTable",
    "SurfaceTable",
    "TrayTable",
    "Unknowns",
    "VelocityTable",
    "bearing_basis",
    "best_and_next",
    "covariance",
    "curvature_difference",
    "curvature_information",
    "describe_keypoints",
    "descriptor_distances",
    "draw_triangles",
    "evaluate",
    "incidence",
    "insert_view",
    "least_tangents",
    "linearise_stereo",
    "normal_of_reprojections",
    "pair_covariance",
    "pairs_in_regions",
    "project_into",
    "reduce_stereo",
    "solve",
    "squared_reprojections",
]

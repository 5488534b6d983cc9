# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solve a Problem in C++, and evaluate its residuals, Jacobian and marginal covariances."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hullrecon.native.problem import LENS_MODES, Problem, Unknowns
from hullrecon.typing import Array, Ints, Ints32, Mask

# Factors of the pose graph, and the order of all factors in records and evaluations
GRAPH_FACTORS = ("link", "plane", "plane_pair", "plane_range", "velocity", "position")
FACTORS = (
    "prior",
    "attitude",
    "tray",
    "odometry",
    "stereo",
    "mono",
    "range",
    "surface",
    "deviation",
    *GRAPH_FACTORS,
)


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of `solve`.

    Huber thresholds apply to the norm of a factor's whitened rows, which grows with their number:
    with 2.508 for four rows and 1.856 for two, the same 17.9 % of normally distributed measurements
    are in the linear branch as with the customary 1.345 for one row. inf: no robust loss.
    """

    method: str = "maxmix"  # naive | geva | maxmix
    # schur: our own solver, which eliminates the landmarks; ceres: Ceres, the reference in tests,
    # with the same steps and optimum, several times slower
    core: str = "schur"
    sigma_on: float = 0.02  # m, label 1
    sigma_off: float = 1.0  # m, label 0
    huber_stereo: float = 2.508  # norm of 4 rows
    huber_mono: float = 1.856  # norm of 2 rows
    huber_range: float = 1.345  # 1 row
    huber_position: float = 1.856  # norm of 2 rows
    link_phi: float = 5.0  # of LinkKernel, in units of a link's whitened square
    max_iterations: int = 100
    # as of ceres::Solver::Options: when a solve has converged, and the first trust region
    function_tolerance: float = 1e-6
    gradient_tolerance: float = 1e-10
    parameter_tolerance: float = 1e-8
    initial_radius: float = 1e4
    threads: int = 1
    # False: labels are held during the solve (the outer loop of hard EM refreshes them)
    labels_in_solve: bool = True


DEFAULTS = Options()


@dataclass(frozen=True, kw_only=True)
class IterationRecord:
    """The solver's record: a row for each of k iterations, the start first.

    In a row of a step that was not accepted, cost_by_factor and the counts are those of the last
    accepted point.
    """

    cost: Array  # robustified, at the point that was tried
    cost_change: Array  # by how much the step lowered the cost
    step_norm: Array
    gradient_norm: Array  # largest entry
    radius: Array  # of the trust region
    accepted: Mask
    seconds: Array  # since the start
    cost_by_factor: dict[str, Array]  # name -> (k,)
    on_surface: Ints  # number of landmarks with label 1
    label_changes: Ints  # number of labels that changed
    rays_missed: Ints  # number of beams that miss the CAD model


@dataclass(frozen=True, kw_only=True)
class Result:
    """The solution: the unknowns, with labels and hits of surface and range rows."""

    unknowns: Unknowns
    label: Ints32  # (m,) of each row of the surface table, 1 = on the hull
    distance: Array  # (m,) m signed, to the CAD model without the field
    ray_hit: Mask  # (m,) of each row of the ranges
    iterations: IterationRecord
    converged: bool
    message: str  # of the solver
    seconds: dict[str, float]  # by part


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """All factors at the start values, whitened and linear in the tangent of the free unknowns.

    Columns: poses 7 each (6 when "tray" is held), landmarks 3 each, then, where free, T_g_M,
    T_s_ct, T_ct_cb, T_s_d 6 each, navigation 6, intrinsics_top, intrinsics_bottom 9 each, world 3,
    lens_top, lens_bottom 2 LENS_MODES each, the deviation's nodes 1 each, planes 3 each, links'
    switches 1 each.
    """

    residual: Array  # (R,) whitened
    weight: Array  # (R,) square root of rho', by which the loss multiplies residual and row
    factor: Ints32  # (R,) index into FACTORS
    table_row: Ints32  # (R,) in the factor's table
    jacobian_start: Ints  # (R + 1,) of compressed rows
    jacobian_column: Ints  # (e,) of each entry that is not zero
    jacobian_value: Array  # (e,)
    width: int  # number of columns
    # a block's name ("pose 0", "landmark 3", "T_g_M", "deviation 2", "plane 4", "link_switch 1") to
    # (first column, count)
    columns: dict[str, tuple[int, int]]
    cost_by_factor: dict[str, float]  # robustified


@dataclass(frozen=True, kw_only=True)
class Covariance:
    """Marginal covariances in tangent coordinates at the start values. Zero where a block is held.

    For those at a solution, the problem must start from the unknowns of `solve`.
    """

    pose: Array  # (n, 7, 7)
    pose_T_g_M: Array  # (n, 7, 6) cross covariance with T_g_M
    landmark: Array  # (L, 3, 3), L = 0 if landmarks were not asked for
    landmark_T_g_M: Array  # (L, 3, 6) cross covariance with T_g_M
    T_g_M: Array  # (6, 6)
    T_s_ct: Array  # (6, 6)
    T_ct_cb: Array  # (6, 6)
    T_s_d: Array  # (6, 6)
    navigation: Array  # (6, 6)
    intrinsics_top: Array  # (9, 9)
    intrinsics_bottom: Array  # (9, 9)
    world: Array  # (3, 3)
    deviation: Array  # (F,) variances
    deviation_T_g_M: Array  # (F, 6) cross covariance with T_g_M
    # Number of unknowns that each kind of factor (FACTORS) determines, of kinds that meet no
    # landmark. The expected chi-square of a kind is the number of its rows less its leverage.
    leverage_by_factor: dict[str, float]
    # (2 LENS_MODES, 2 LENS_MODES) px2
    lens_top: Array = field(default_factory=lambda: np.zeros((2 * LENS_MODES, 2 * LENS_MODES)))
    lens_bottom: Array = field(default_factory=lambda: np.zeros((2 * LENS_MODES, 2 * LENS_MODES)))


@dataclass(frozen=True, kw_only=True)
class PairCovariance:
    """Joint covariances of pairs of poses and T_s_ct in tangent coordinates at the start values.

    Zero where a block is held.
    """

    # (m, 14, 14) of (translation 3, rotation 3, tray 1) of the first pose, then of the second
    pose: Array
    pose_T_s_ct: Array  # (m, 14, 6)
    T_s_ct: Array  # (6, 6)


def solve(problem: Problem, options: Options = DEFAULTS) -> Result:
    """Find the unknowns of least cost by Levenberg-Marquardt with the landmarks eliminated.

    With the core schur, the same input gives the same bytes for any number of threads, with ceres
    only for one thread. Ctrl-C is honoured between iterations. Tables that are NumPy arrays of the
    right type are read in place, and never written to. Raises InputError or UsageError that names
    the table or option, and StageError when the start values cannot be evaluated.
    """
    from hullrecon.native.compiled import native  # loads the solver's libraries

    got = native.solve(problem, options)
    unknowns, iterations = Unknowns(**got.pop("unknowns")), IterationRecord(**got.pop("iterations"))
    return Result(unknowns=unknowns, iterations=iterations, **got)


def evaluate(problem: Problem, options: Options = DEFAULTS, *, jacobian: bool = True) -> Evaluation:
    """Evaluate residuals and their sparse Jacobian at the start values.

    jacobian: False leaves the Jacobian and `columns` empty, which takes a tenth of the memory.
    Raises as `solve`.
    """
    from hullrecon.native.compiled import native

    return Evaluation(**native.evaluate(problem, options, jacobian))


def covariance(
    problem: Problem, options: Options = DEFAULTS, *, of_landmarks: bool = True
) -> Covariance:
    """Compute marginals of the inverse of the information at the start values.

    Rows with Huber's loss are weighted by rho', surface rows by their label. Landmarks are
    eliminated, the rest is factored sparse, and only entries in the factor's pattern are inverted.
    Raises StageError that names the unknowns that nothing determines, otherwise as `solve`.

    of_landmarks: False leaves the covariances of landmarks out, which takes a third of the time.
    """
    from hullrecon.native.compiled import native

    return covariance_from(native.covariance(problem, options, of_landmarks))


def covariance_from(marginals: dict[str, Any]) -> Covariance:
    """Build a Covariance from the solver's marginals.

    With a held hull pose, the solver leaves out the landmarks' cross covariances, which are zero.
    """
    if not len(marginals["landmark_T_g_M"]):
        marginals["landmark_T_g_M"] = np.zeros((len(marginals["landmark"]), 3, 6))
    return Covariance(**marginals)


def pair_covariance(problem: Problem, pairs: Ints32, options: Options = DEFAULTS) -> PairCovariance:
    """Compute the joint covariances of pairs (m, 2) of poses at the start values.

    The information is that of `covariance`. Two poses of a pair need no factor between them. There
    may be many pairs: of each pair the pose that is in more pairs is taken, each such pose costs
    one sparse solve along its path in the elimination tree, and each pair one product.

    The innovation of a candidate link follows from it. Add the link to the problem without a
    kernel, and take its rows J and r from `evaluate`. Then r' (J S J' + 1)^-1 r is a chi-square
    with as many degrees of freedom as rows, where S is the joint covariance of the problem without
    the link.

    Raises as `covariance`, and InputError that names "pairs".
    """
    from hullrecon.native.compiled import native

    return PairCovariance(**native.pair_covariance(problem, pairs, options))

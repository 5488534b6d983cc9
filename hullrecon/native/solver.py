# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solving a Problem in C++: the optimum, residuals with their Jacobian, marginal covariances."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hullrecon.native.problem import LENS_MODES, Problem, Unknowns
from hullrecon.typing import Array, Ints, Ints32, Mask

# apart in the record of a solve
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
    2.508 of four rows and 1.856 of two leave the same 17.9 % of normal measurements in the linear
    branch as the customary 1.345 of one row; inf switches one off.
    """

    method: str = "maxmix"  # naive | geva | maxmix
    # schur: landmarks eliminated by our own code, the fastest; ceres: the oracle, the same steps
    # and optimum, several times slower
    core: str = "schur"
    sigma_on: float = 0.02  # m, label 1
    sigma_off: float = 1.0  # m, label 0
    huber_stereo: float = 2.508  # norm of 4 rows
    huber_mono: float = 1.856  # norm of 2 rows
    huber_range: float = 1.345  # 1 row
    huber_position: float = 1.856  # norm of 2 rows
    link_phi: float = 5.0  # of LinkKernel, in units of a link's whitened square
    max_iterations: int = 100
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
    """What the solver did, one row an iteration (k,), the start first.

    Of a step that was not accepted, cost_by_factor and the counts are those of the last accepted
    point.
    """

    cost: Array  # at the point tried, robustified
    cost_change: Array
    step_norm: Array
    gradient_norm: Array  # largest entry
    radius: Array
    accepted: Mask
    seconds: Array  # since the start
    cost_by_factor: dict[str, Array]  # name -> (k,)
    on_surface: Ints  # landmarks labelled 1
    label_changes: Ints
    rays_missed: Ints


@dataclass(frozen=True, kw_only=True)
class Result:
    """The unknowns at the end, and what became of rows."""

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
    jacobian_column: Ints
    jacobian_value: Array
    width: int  # number of columns
    # a block's name ("pose 0", "landmark 3", "T_g_M", "deviation 2", "plane 4", "link_switch 1") to
    # (first column, count)
    columns: dict[str, tuple[int, int]]
    cost_by_factor: dict[str, float]  # robustified


@dataclass(frozen=True, kw_only=True)
class Covariance:
    """Marginal covariances in tangent coordinates at the start values; zero where a block is held.

    Give `solve`'s unknowns as start.
    """

    pose: Array  # (n, 7, 7)
    pose_T_g_M: Array  # (n, 7, 6) with T_g_M
    landmark: Array  # (L, 3, 3), none unless asked for, as are the next
    landmark_T_g_M: Array  # (L, 3, 6)
    T_g_M: Array  # (6, 6) as are the next four
    T_s_ct: Array
    T_ct_cb: Array
    T_s_d: Array
    navigation: Array
    intrinsics_top: Array  # (9, 9)
    intrinsics_bottom: Array  # (9, 9)
    world: Array  # (3, 3)
    deviation: Array  # (F,) variances
    deviation_T_g_M: Array  # (F, 6)
    # unknowns determined by a kind of factors (FACTORS) that meet no landmark: the squares of their
    # whitened residuals are expected to sum up to their rows less that
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

    Core schur: the same input gives the same bytes for any number of threads. Core ceres: for one
    thread only; more differ in the last digits. Ctrl-C is honoured between iterations. Tables that
    are NumPy arrays of the right type are read in place and never written to. Raises InputError or
    UsageError naming the table or option, StageError when the start cannot be evaluated.
    """
    import hullrecon._native as _native  # compiled; loads the solver's libraries

    got = _native.solve(problem, options)
    unknowns, iterations = Unknowns(**got.pop("unknowns")), IterationRecord(**got.pop("iterations"))
    return Result(unknowns=unknowns, iterations=iterations, **got)


def evaluate(problem: Problem, options: Options = DEFAULTS, *, jacobian: bool = True) -> Evaluation:
    """Evaluate residuals and their sparse Jacobian at the start values.

    jacobian: False leaves its rows empty and `columns` too, which takes a tenth of the memory.
    Raises as `solve`.
    """
    import hullrecon._native as _native

    return Evaluation(**_native.evaluate(problem, options, jacobian))


def covariance(
    problem: Problem, options: Options = DEFAULTS, *, of_landmarks: bool = True
) -> Covariance:
    """Compute marginals of the inverse of the information at the start values.

    Huber rows are weighted by rho', surface rows by their label. Landmarks are eliminated, the rest
    factored sparse, and only the entries on the factor's pattern are inverted. Raises StageError
    naming the unknowns that nothing determines; else as `solve`.

    of_landmarks: False leaves those of landmarks out, a third of the time.
    """
    import hullrecon._native as _native

    return covariance_from(_native.covariance(problem, options, of_landmarks))


def covariance_from(marginals: dict[str, Any]) -> Covariance:
    """Build the covariance, zero of landmarks with a hull that is held."""
    if not len(marginals["landmark_T_g_M"]):
        marginals["landmark_T_g_M"] = np.zeros((len(marginals["landmark"]), 3, 6))
    return Covariance(**marginals)


def pair_covariance(problem: Problem, pairs: Ints32, options: Options = DEFAULTS) -> PairCovariance:
    """Compute the joint covariance of any pairs (m, 2) of poses.

    From the information at the start as `covariance` has it. Pairs need no factor between them and
    may be many: each pose to which pairs are given, that end which more pairs have, costs one
    sparse solve along its path in the elimination tree, each pair one product. A candidate link's
    innovation: add it to the problem's links without a kernel, take its rows J and r from
    `evaluate`; then r' (J S J' + 1)^-1 r is chi-square with as many degrees of freedom as rows, S
    being the joint covariance here of the problem without it. Raises as `covariance`; InputError
    naming "pairs".
    """
    import hullrecon._native as _native

    return PairCovariance(**_native.pair_covariance(problem, pairs, options))

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solving a Problem in C++: the optimum, its residuals with their Jacobian, and marginal
covariances.
"""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.native.problem import Problem, Unknowns
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
    """Of `solve`. method: naive | geva | maxmix. core: schur (landmarks eliminated by our own code,
    the fastest) | ceres (the oracle: the same steps and optimum, several times slower).

    Huber thresholds apply to the norm of a factor's whitened rows, which grows with their number:
    2.508 of four rows and 1.856 of two leave the same 17.9 % of normal measurements in the linear
    branch as the customary 1.345 of one row; inf switches one off.
    """

    method: str = "maxmix"
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

    cost: at the point tried, robustified; of a step that was not accepted, cost_by_factor (name ->
    (k,)) and the counts are those of the last accepted point. gradient_norm: largest entry.
    seconds: since the start. on_surface: landmarks labelled 1.
    """

    cost: Array
    cost_change: Array
    step_norm: Array
    gradient_norm: Array
    radius: Array
    accepted: Mask
    seconds: Array
    cost_by_factor: dict[str, Array]
    on_surface: Ints
    label_changes: Ints
    rays_missed: Ints


@dataclass(frozen=True, kw_only=True)
class Result:
    """The unknowns at the end. label (m,) of each row of the surface table (1 = on the hull),
    distance (m,) signed, to the CAD model without the field; ray_hit (m,) of each row of the
    ranges; message of the solver; seconds by part.
    """

    unknowns: Unknowns
    label: Ints32
    distance: Array
    ray_hit: Mask
    iterations: IterationRecord
    converged: bool
    message: str
    seconds: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """All factors at the start values, whitened and linear in the tangent coordinates of the free
    unknowns.

    residual (R,), whitened; weight (R,): square root of rho', by which the loss multiplies residual
    and row; factor (R,): index into FACTORS; table_row (R,) in the factor's table; jacobian_*:
    compressed rows, start (R + 1,), column, value; width: how many columns. Columns: poses 7 each
    (6 when "tray" is held), landmarks 3 each, then, where free, T_g_M, T_s_ct, T_ct_cb, T_s_d 6
    each, navigation 6, intrinsics_top, intrinsics_bottom 9 each, world 3, the deviation's nodes 1
    each, planes 3 each, links' switches 1 each; `columns` maps a block's name ("pose 0", "landmark
    3", "T_g_M", "deviation 2", "plane 4", "link_switch 1") to (first column, count).
    cost_by_factor: robustified.
    """

    residual: Array
    weight: Array
    factor: Ints32
    table_row: Ints32
    jacobian_start: Ints
    jacobian_column: Ints
    jacobian_value: Array
    width: int
    columns: dict[str, tuple[int, int]]
    cost_by_factor: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class Covariance:
    """Marginal covariances in tangent coordinates at the start values (give `solve`'s unknowns);
    zero where a block is held.

    pose (n, 7, 7) and pose_T_g_M (n, 7, 6): with T_g_M; landmark (L, 3, 3) and landmark_T_g_M (L,
    3, 6); T_g_M, T_s_ct, T_ct_cb, T_s_d, navigation (6, 6); intrinsics_top, intrinsics_bottom (9,
    9); world (3, 3); deviation (F,): variances; deviation_T_g_M (F, 6). leverage_by_factor: of the
    factors of a kind (FACTORS) that meet no landmark, how many unknowns they determine: the squares
    of their whitened residuals are expected to sum up to their rows less that.
    """

    pose: Array
    pose_T_g_M: Array
    landmark: Array
    landmark_T_g_M: Array
    T_g_M: Array
    T_s_ct: Array
    T_ct_cb: Array
    T_s_d: Array
    navigation: Array
    intrinsics_top: Array
    intrinsics_bottom: Array
    world: Array
    deviation: Array
    deviation_T_g_M: Array
    leverage_by_factor: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class PairCovariance:
    """Joint covariances of pairs of poses and T_s_ct, in tangent coordinates at the start values;
    zero where a block is held.

    pose (m, 14, 14): of (translation 3, rotation 3, tray 1) of the first pose, then of the second.
    pose_T_s_ct (m, 14, 6); T_s_ct (6, 6).
    """

    pose: Array
    pose_T_s_ct: Array
    T_s_ct: Array


def solve(problem: Problem, options: Options = DEFAULTS) -> Result:
    """Return the unknowns of least cost, by Levenberg-Marquardt with the landmarks eliminated.

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
    """Return residuals and their sparse Jacobian at the start values. jacobian: False leaves its
    rows empty and `columns` too, which takes a tenth of the memory. Raises as `solve`.
    """
    import hullrecon._native as _native

    return Evaluation(**_native.evaluate(problem, options, jacobian))


def covariance(problem: Problem, options: Options = DEFAULTS) -> Covariance:
    """Return marginals of the inverse of the information at the start values: Huber rows weighted
    by rho', surface rows by their label.

    Landmarks are eliminated, the rest factored sparse, and only the entries on the factor's pattern
    are inverted. Raises StageError naming the unknowns that nothing determines; else as `solve`.
    """
    import hullrecon._native as _native

    return Covariance(**_native.covariance(problem, options))


def pair_covariance(problem: Problem, pairs: Ints32, options: Options = DEFAULTS) -> PairCovariance:
    """Return the joint covariance of any pairs (m, 2) of poses, from the information at the start
    as `covariance` has it.

    Pairs need no factor between them and may be many: each pose to which pairs are given, that end
    which more pairs have, costs one sparse solve along its path in the elimination tree, each pair
    one product. A candidate link's innovation: add it to the problem's links without a kernel, take
    its rows J and r from `evaluate`; then r' (J S J' + 1)^-1 r is chi-square with as many degrees
    of freedom as rows, S being the joint covariance here of the problem without it. Raises as
    `covariance`; InputError naming "pairs".
    """
    import hullrecon._native as _native

    return PairCovariance(**_native.pair_covariance(problem, pairs, options))

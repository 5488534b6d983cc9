# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Solve, evaluate and query in C++: the typed interface of the compiled module; nothing else imports hullrecon._native.

The module is built by the (editable) installation and found through it, from whatever folder or PYTHONPATH Python is started;
a checkout that was never installed has no hullrecon._native.

Conventions of `Problem`: quaternions x y z w; motions are 7 numbers, x y z qx qy qz qw. Tangent of a motion: (translation,
rotation) with the rotation perturbed on the right and the translation added in the parent frame. Tangent of a pose block:
(translation 3, rotation 3, tray 1). The hull frame of a Problem may be shifted from M to the middle of the survey by the
caller; the mesh is given in that frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from dataclasses import field as default

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.errors import InputError
from hullrecon.typing import Array, Ints32, Mask


def _floats(*shape: int) -> Array:
    return default(default_factory=lambda: np.zeros(shape))


def _ints(*shape: int) -> Ints32:
    return default(default_factory=lambda: np.zeros(shape, np.int32))


@dataclass
class Problem:
    """Hold unknowns (start values) and factors as tables. m differs from table to table; empty tables are left out.

    Unknowns:
      pose (n, 8)          T_g_v and the tray's angle: x y z qx qy qz qw tray
      landmark (L, 3)      in g
      T_g_M, T_s_ct, T_ct_cb, T_s_d (7,)
      navigation (6,)      DVL scale error, heading drift rad/s, roll bias rad, pitch bias rad, depth bias m, tray backlash rad
      deviation (F,)       m, normal offsets (outward positive) at the nodes of the deviation field; empty: no field
      intrinsics_top, intrinsics_bottom (9,)   fx fy cx cy k1 k2 p1 p2 k3
    `constant` names the blocks held: any of "T_g_M", "T_s_ct", "T_ct_cb", "T_s_d", "navigation", "deviation", "intrinsics_top",
    "intrinsics_bottom", "tray" (every pose's tray angle). The prior of a held block is left out.
    """

    pose: Array
    landmark: Array = _floats(0, 3)
    T_g_M: Array = default(default_factory=lambda: np.array([0, 0, 0, 0, 0, 0, 1.0]))
    T_s_ct: Array = default(default_factory=lambda: np.array([0, 0, 0, 0, 0, 0, 1.0]))
    T_ct_cb: Array = default(default_factory=lambda: np.array([0, 0, 0, 0, 0, 0, 1.0]))
    T_s_d: Array = default(default_factory=lambda: np.array([0, 0, 0, 0, 0, 0, 1.0]))
    navigation: Array = _floats(6)
    deviation: Array = _floats(0)
    intrinsics_top: Array = default(default_factory=lambda: np.array([1.0, 1, 0, 0, 0, 0, 0, 0, 0]))
    intrinsics_bottom: Array = default(default_factory=lambda: np.array([1.0, 1, 0, 0, 0, 0, 0, 0, 0]))
    constant: tuple[str, ...] = ()

    # the CAD model
    vertices: Array = _floats(0, 3)
    faces: Ints32 = _ints(0, 3)
    tray_origin: Array = _floats(3)  # in vehicle
    pressure_origin: Array = _floats(3)  # in vehicle

    # full priors [Ozog2016 4.8]: residual = sqrt_information (6, 6) @ (translation, rotation vector) of prior^-1 . x, so the
    # translation reads in the axes of the prior
    prior_pose_node: Ints32 = _ints(0)
    prior_pose: Array = _floats(0, 7)
    prior_pose_sqrt: Array = _floats(0, 6, 6)
    prior_T_g_M: Array | None = None  # (7,)
    prior_T_g_M_sqrt: Array | None = None  # (6, 6)
    prior_T_s_ct: Array | None = None
    prior_T_s_ct_sqrt: Array | None = None
    prior_T_ct_cb: Array | None = None
    prior_T_ct_cb_sqrt: Array | None = None
    prior_T_s_d: Array | None = None
    prior_T_s_d_sqrt: Array | None = None
    prior_navigation_sigma: Array = default(default_factory=lambda: np.ones(6))  # about zero
    prior_intrinsics_sigma: Array = default(default_factory=lambda: np.ones(9))  # about the start, when not constant

    # depth, roll, pitch [Ozog2016 4.9]: z of the pressure sensor + depth bias, roll + roll bias, pitch + pitch bias, less
    # measured
    attitude_node: Ints32 = _ints(0)
    attitude_measured: Array = _floats(0, 3)  # depth, roll, pitch
    attitude_sigma: Array = _floats(0, 3)

    # tray [Ozog2016 4.10]: (theta + backlash * direction - measured) / sigma
    tray_node: Ints32 = _ints(0)
    tray_measured: Array = _floats(0)
    tray_direction: Array = _floats(0)
    tray_sigma: Array = _floats(0)

    # odometry [Ozog2016 4.11]: sqrt @ (e - by_navigation @ (scale, drift) - by_mount @ Log(R_mount^-1 R_s_d) - by_tray * (mean
    # tray angle - tray)), e = (t_ij - t_z in the axes of vehicle i, Log(R_z^-1 R_ij)), T_ij = T_i^-1 T_j; each by_* is a
    # derivative of the measured motion z in these same coordinates
    odometry_first: Ints32 = _ints(0)
    odometry_second: Ints32 = _ints(0)
    odometry_measured: Array = _floats(0, 7)
    odometry_sqrt: Array = _floats(0, 6, 6)
    odometry_by_navigation: Array = _floats(0, 6, 2)  # by DVL scale error, heading drift
    odometry_by_mount: Array = _floats(0, 6, 3)  # by the rotation of T_s_d away from odometry_mount
    odometry_by_tray: Array = _floats(0, 6)  # by the mean tray angle of the two nodes away from odometry_tray
    odometry_tray: Array = _floats(0)  # rad, mean tray angle that dead reckoning used
    odometry_mount: Array = default(default_factory=lambda: np.array([0, 0, 0, 0, 0, 0, 1.0]))  # T_s_d that it used

    # stereo [Ozog2016 4.12] and mono [Ozog2016 4.13], raw pixels through the full camera model; one Huber loss on the norm of a
    # factor's 4 or 2 rows (Options.huber_stereo, huber_mono); a point behind its camera costs 10^4 px a row, without derivative
    stereo_node: Ints32 = _ints(0)
    stereo_landmark: Ints32 = _ints(0)
    stereo_pixel: Array = _floats(0, 4)  # top u v, bottom u v
    mono_node: Ints32 = _ints(0)
    mono_landmark: Ints32 = _ints(0)
    mono_camera: Ints32 = _ints(0)  # 0 top, 1 bottom
    mono_pixel: Array = _floats(0, 2)
    sigma_px: float = 1.0

    # ray-cast ranges [Ozog2016 4.14]: (predicted - measured) / sigma; predicted is the distance to the CAD model moved outward
    # by the field: cast - field / cos(incidence)
    range_node: Ints32 = _ints(0)
    range_offset: Array = _floats(0, 7)  # vehicle at the ping in vehicle at the node
    range_tray_offset: Array = _floats(0)
    range_beam: Array = _floats(0, 3)  # unit, in dvl
    range_measured: Array = _floats(0)
    range_sigma: Array = _floats(0)
    range_field_index: Ints32 = _ints(0, 4)  # nodes of the field, with their weights; (m, 4) or empty without a field
    range_field_weight: Array = _floats(0, 4)

    # surface [Ozog2016 4.4, 4.5, 4.7]: signed distance of the landmark to the CAD model minus the field
    surface_landmark: Ints32 = _ints(0)
    surface_weight: Array = _floats(0)  # multiplies the mixture's cost
    surface_field_index: Ints32 = _ints(0, 4)
    surface_field_weight: Array = _floats(0, 4)

    # prior of the field: rows of a sparse whitening operator, CSR
    field_prior_start: Ints32 = _ints(0)  # (rows + 1,)
    field_prior_index: Ints32 = _ints(0)
    field_prior_value: Array = _floats(0)


@dataclass(frozen=True)
class Options:
    """Set what `solve` minimises and when it stops.

    method: surface factors of no landmark (naive), of all (geva), or by hidden label (maxmix). core: schur (docs/schur.md) or
    ceres, which takes the same steps to the same optimum several times slower and checks it.

    Huber thresholds apply to the norm of a factor's whitened rows, which grows with their number: 2.508 of four rows and 1.856
    of two leave the same 17.9 % of normal measurements in the linear branch as the customary 1.345 of one row; inf switches one
    off."""

    method: str = "maxmix"
    core: str = "schur"
    sigma_on: float = 0.02  # m, label 1
    sigma_off: float = 1.0  # m, label 0
    huber_stereo: float = 2.508  # norm of 4 rows
    huber_mono: float = 1.856  # norm of 2 rows
    huber_range: float = 1.345  # 1 row
    max_iterations: int = 100
    function_tolerance: float = 1e-6
    gradient_tolerance: float = 1e-10
    parameter_tolerance: float = 1e-8
    initial_radius: float = 1e4
    threads: int = 1
    labels_in_solve: bool = True  # False: labels are held during the solve (the outer loop of hard EM refreshes them)


DEFAULTS = Options()


@dataclass(frozen=True)
class IterationRecord:
    """Record what the solver did, one row an iteration (k,), the start first.

    cost: at the point tried, robustified; of a step that was not accepted, cost_by_factor (name -> (k,)) and the counts are
    those of the last accepted point. gradient_norm: largest entry. seconds: since the start.
    """

    cost: Array
    cost_change: Array
    step_norm: Array
    gradient_norm: Array
    radius: Array
    accepted: Mask
    seconds: Array
    cost_by_factor: dict[str, Array]
    on_surface: Ints32  # landmarks labelled 1
    label_changes: Ints32
    rays_missed: Ints32


@dataclass(frozen=True)
class Result:
    """Hold the unknowns at the end, in the shapes of Problem.

    label (m,): of each surface row, 1 = on the hull; distance (m,): m, signed, to the CAD model without the field; ray_hit
    (m,): of each range row; message: of the solver; seconds: by part.
    """

    unknowns: dict[str, Array]
    label: Ints32
    distance: Array
    ray_hit: Mask
    iterations: IterationRecord
    converged: bool
    message: str
    seconds: dict[str, float]


@dataclass(frozen=True)
class Closest:
    """Hold closest points: distance (n,) m, positive outside by the angle-weighted pseudonormal of the closest feature (face,
    edge or vertex); point (n, 3) on the mesh; gradient (n, 3) unit, of the signed distance (the pseudonormal where the distance
    is nothing); face (n,)."""

    distance: Array
    point: Array
    gradient: Array
    face: Ints32


@dataclass(frozen=True)
class Hits:
    """Hold what rays hit: range (n,) m, inf on a miss; face (n,), -1 on a miss; normal (n, 3) unit, outward by the corners'
    order, 0 on a miss."""

    range: Array
    face: Ints32
    normal: Array


class MeshIndex:
    """Find closest points and cast rays against a mesh: vertices (n, 3) m, faces (m, 3) int32, counter-clockwise from outside.

    Corners at equal coordinates count as one. `threads`: 0 = all cores; the answer does not depend on it.
    Raises InputError for shapes, indices or numbers that cannot be."""

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, *, threads: int = 0) -> None:
        corners = np.asarray(faces)
        if corners.dtype.kind not in "iu":
            raise InputError("faces must be integers", where="faces")
        from hullrecon import _native  # type: ignore[attr-defined]  # compiled; loads the solver's libraries

        self._index = _native.MeshIndex(np.asarray(vertices, float), corners)
        self._threads = threads

    def __len__(self) -> int:
        """Return the number of faces."""
        return len(self._index)

    def closest(self, points: ArrayLike) -> Closest:
        """Return the closest point on the mesh of each of points (n, 3), m."""
        return Closest(*self._index.closest(np.asarray(points, float), self._threads))

    def cast(self, origins: ArrayLike, directions: ArrayLike) -> Hits:
        """Return the first crossing of rays (n, 3), (n, 3), either side of a face; directions need not be unit, ranges are
        metres."""
        return Hits(*self._index.cast(np.asarray(origins, float), np.asarray(directions, float), self._threads))


def solve(problem: Problem, options: Options = DEFAULTS) -> Result:
    """Move the unknowns to the least cost by Levenberg-Marquardt with the landmarks eliminated.

    Core schur: the same input gives the same bytes for any number of threads. Core ceres: for one thread only; more differ in
    the last digits. Ctrl-C stops it between iterations. Tables that are NumPy arrays of the right type are read in place and
    never written to.
    Raises InputError or UsageError naming the table or option, StageError when the start cannot be evaluated.
    """
    from hullrecon import _native  # type: ignore[attr-defined]

    got = _native.solve(problem, options)
    return Result(**(got | {"iterations": IterationRecord(**got["iterations"])}))


FACTORS = ("prior", "attitude", "tray", "odometry", "stereo", "mono", "range", "surface", "deviation")


@dataclass(frozen=True)
class Evaluation:
    """Hold all factors at the start values, whitened and linear in the tangent coordinates of the free unknowns.

    residual (R,), whitened; weight (R,): square root of rho', by which the loss multiplies residual and row; factor (R,):
    index into FACTORS; table_row (R,) in the factor's table; jacobian_*: compressed rows, start (R + 1,), column, value; width:
    how many columns. Columns: poses 7 each (6 when "tray" is held), landmarks 3 each, then, where free, T_g_M, T_s_ct, T_ct_cb,
    T_s_d 6 each, navigation 6, intrinsics_top, intrinsics_bottom 9 each, the deviation's nodes 1 each; `columns` maps a block's
    name ("pose 0", "landmark 3", "T_g_M", "deviation 2") to (first column, count). cost_by_factor: robustified.
    """

    residual: Array
    weight: Array
    factor: Ints32
    table_row: Ints32
    jacobian_start: Ints32
    jacobian_column: Ints32
    jacobian_value: Array
    width: int
    columns: dict[str, tuple[int, int]]
    cost_by_factor: dict[str, float]


def evaluate(problem: Problem, options: Options = DEFAULTS) -> Evaluation:
    """Return residuals and sparse Jacobian at the start values. Raises as `solve`."""
    from hullrecon import _native  # type: ignore[attr-defined]

    return Evaluation(**_native.evaluate(problem, options))


@dataclass(frozen=True)
class Covariance:
    """Hold marginal covariances in tangent coordinates at the start values (give `solve`'s unknowns); zero where a block is
    held.

    pose (n, 7, 7) and pose_T_g_M (n, 7, 6): with T_g_M; landmark (L, 3, 3) and landmark_T_g_M (L, 3, 6); T_g_M, T_s_ct,
    T_ct_cb, T_s_d, navigation (6, 6); intrinsics_top, intrinsics_bottom (9, 9); deviation (F,): variances; deviation_T_g_M
    (F, 6).
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
    deviation: Array
    deviation_T_g_M: Array


def covariance(problem: Problem, options: Options = DEFAULTS) -> Covariance:
    """Return marginal covariances: the inverse of the information at the start values, Huber rows weighted by rho', surface
    rows by their label.

    Landmarks are eliminated, the rest factored sparse, and only the entries on the factor's pattern are inverted. Raises
    StageError naming the unknowns that nothing determines; else as `solve`.
    """
    from hullrecon import _native  # type: ignore[attr-defined]

    return Covariance(**_native.covariance(problem, options))

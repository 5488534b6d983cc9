# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The second survey's offset in the first survey's hull frame, from what both saw.

Each dive knows its hull pose to centimetres, along a parallel side to decimetres. So two surveys
are offset, which is no change of the hull. The offset is estimated as one rigid motion from form
and structures. First its part along the hull and in girth is found by trying all shifts that the
hull poses leave open. Then all six numbers are fitted by robust least squares on the heights of one
survey over the other, with the hull poses' covariances as prior (docs/methods.md 19).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.change.relief import Relief, blur, local_median
from hullrecon.errors import StageError
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.lattice import Lattice
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.poses import Poses, identity
from hullrecon.geometry.robust import robust_sigma
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.records.change import HullSurvey, SurveyOffset
from hullrecon.records.solution import HullPose
from hullrecon.typing import Array, Ints, Mask

GATE_SIGMAS = 4.0  # largest shift that is tried, in sigmas of the hull poses
MIN_SHARED_SHARE = 0.25  # least share of the smaller survey that both saw
MIN_SHARED_CELLS = 200  # least number of cells that both saw
SCALE_M = 0.004  # scale of differences of height: about their sigma where nothing changed
# Differences of more than this many SCALE_M count as change and cost no more. In the fit, weights
# reach zero at twice this many robust sigmas of the residuals.
TRUNCATED = 3.0
# Correlation length of a hull as found: a square of this side counts as one measurement
CORRELATED_M = 0.15
STARTS, APART_M = 6, 0.1  # number of shifts from which the motion is fitted, their least distance
# Side of a block of hull over which errors of form are fully correlated in the covariance
BLOCK_M = 0.8
BLURS = (2.0, 1.0, 1.0)  # sigma of the blur of both surveys in each round of fits, cells
STEPS = 6  # iteratively reweighted steps of a fit


@dataclass(frozen=True, kw_only=True)
class _Samples:
    """Points of the second survey in its own M."""

    points: Array  # (n, 3)
    axes: Array  # (3, n, 3): unit vectors along, in girth and outward at each point
    weight: float  # number of independent measurements that a point is weighted as
    block: Ints  # (n,) block of hull that each point belongs to
    shared_m: float  # one sigma of the errors of both surveys that a block shares


@dataclass(frozen=True, kw_only=True)
class _Solved:
    """A fitted motion."""

    motion: Poses  # first_from_second, a batch of one
    covariance: Array  # (6, 6) of translation and rotation about the center


@dataclass(frozen=True, kw_only=True)
class _Fit:
    """Robust least squares of a rigid motion, docs/methods.md (68)."""

    chart: Chart
    lattice: Lattice
    center: Array  # (3,) point about which rotations are counted
    prior: Array  # (6, 6) covariance of the motion by both hull poses

    def solve(self, motion: Poses, samples: _Samples, height: Array) -> _Solved:
        """Fit the motion of samples onto heights (a, g) m of the first survey, with covariance.

        Raises StageError where the two share too few cells. Iteratively reweighted least squares
        with Tukey's biweight, from the given motion. It does not use geometry.pose_solver: the
        cells that both surveys saw, and the weights, change from step to step, so that costs cannot
        be compared.
        """
        held: Array = np.asarray(np.linalg.inv(self.prior), float)
        covariance = self.prior
        for _ in range(STEPS):
            residual, jacobian, known = self._residuals(
                motion.apply(samples.points), samples.axes, height
            )
            if known.sum() < MIN_SHARED_CELLS / 4:
                raise _too_little_error()
            r, rows = residual[known], jacobian[known]
            scale = max(0.5 * SCALE_M, robust_sigma(r))
            # Tukey's weights: hull that changed does not pull the fit
            share = np.maximum(0.0, 1 - ((r - np.median(r)) / (2 * TRUNCATED * scale)) ** 2) ** 2
            weight = samples.weight * share / scale**2
            gradient = rows.T @ (weight * r)
            information = np.asarray(rows.T @ (weight[:, None] * rows) + held)
            # The step lowers the residuals, and the motion itself, which by the hull poses is zero
            step = np.linalg.solve(information, gradient + held @ _as_vector(motion, self.center))
            motion = _apply_step(motion, np.asarray(-step), self.center)
            by_error = np.asarray(rows * weight[:, None]) * samples.shared_m
            covariance = _covariance(
                np.asarray(information, float), held, by_error, samples.block[known]
            )
        return _Solved(motion=motion, covariance=covariance)

    def cost(self, motion: Poses, samples: _Samples, height: Array) -> float:
        """Compute the chi-square of a motion of samples onto heights (a, g) m, and of its prior.

        Residuals are truncated: a part of the hull that changed costs no more than the largest
        error.
        """
        r, _, known = self._residuals(motion.apply(samples.points), samples.axes, height)
        x = _as_vector(motion, self.center)
        return len(r) * samples.weight * _truncated_square(r[known]) + float(
            x @ np.linalg.solve(self.prior, x)
        )

    def _residuals(self, at: Array, axes: Array, height: Array) -> tuple[Array, Array, Mask]:
        """Compute heights of points above the first survey, with derivatives by the motion.

        Parameters
        ----------
        at
            Points (n, 3) of the second survey, moved.
        axes
            Unit vectors (3, n, 3) along, in girth and outward at the points.
        height
            Heights (a, g) of the first survey.

        Returns
        -------
        residual
            (n,) m along the normal.
        jacobian
            (n, 6) by translation and rotation about the center.
        known
            (n,) rows at which the first survey saw the hull.
        """
        from scipy.ndimage import map_coordinates

        on_chart = self.chart.to_chart(at)
        place = self.lattice.place(np.nan_to_num(on_chart[:, :2])).T
        slopes = np.gradient(height, self.lattice.step_m)
        below, by_along, by_girth = (
            map_coordinates(values, place, order=1, mode="constant", cval=np.nan)
            for values in (height, *slopes)
        )
        residual = on_chart[:, 2] - below
        along, girth, normal = axes
        # A point that moves along the hull also has another height below it, by the slope there
        toward = normal - by_along[:, None] * along - by_girth[:, None] * girth
        jacobian = np.concatenate([toward, np.cross(at - self.center, toward)], axis=1)
        known = np.isfinite(residual) & np.isfinite(jacobian).all(axis=1)
        return residual, jacobian, known


def estimate_offset(
    first: HullSurvey,
    second: HullSurvey,
    chart: Chart,
    lattice: Lattice,
    reliefs: tuple[Relief, Relief],
) -> SurveyOffset:
    """Estimate the offset of two surveys whose reliefs lie on one lattice.

    Parameters
    ----------
    first, second
        The surveys. Only their hull poses are used, which are the prior.
    chart
        Chart of the first survey, on which both reliefs are given.
    lattice, reliefs
        Cells, and the heights of both surveys on them.

    Raises
    ------
    StageError
        They saw too little of the same hull.
    """
    center = _middle(chart, lattice, reliefs[1])
    prior = hull_pose_covariance(first.hull_pose, center) + hull_pose_covariance(
        second.hull_pose, center
    )
    fit = _Fit(chart=chart, lattice=lattice, center=center, prior=prior)
    # Fit all six numbers from each of the best shifts, and take the fit of least cost
    heights, samples = _blur_both(reliefs, BLURS[0], fit)
    starts = [fit.solve(motion, samples, heights) for motion in _shifts(reliefs, fit)]
    motion = min(
        (start.motion for start in starts), key=lambda motion: fit.cost(motion, samples, heights)
    )
    for cells in BLURS[1:]:
        heights, samples = _blur_both(reliefs, cells, fit)
        solved = fit.solve(motion, samples, heights)
        motion = solved.motion
    # Whether an offset of this size is to be expected of the two hull poses
    x = _as_vector(motion, center)
    chi_square = float(x @ np.linalg.solve(prior, x))
    from scipy.special import gammaincc  # not scipy.stats, which takes seconds to load

    return SurveyOffset(
        first_from_second=motion,
        covariance=solved.covariance,
        prior_covariance=prior,
        center=center,
        chi_square=chi_square,
        p_value=float(gammaincc(3.0, 0.5 * chi_square)),
    )


def hull_pose_covariance(pose: HullPose, center: Array) -> Array:
    """Transform a hull pose's covariance (6, 6) to axes of M, rotations about a center (3,).

    In that form the covariances of two hull poses can be added.
    """
    # `turn` rotates the translation from g into M. `carry` gives that of the center, which a
    # rotation w about survey_center moves by w x (center - survey_center).
    turn, carry = np.eye(6), np.eye(6)
    turn[:3, :3] = pose.global_from_hull.rotation.as_matrix()[0].T
    carry[:3, 3:] = -cross_matrix(center - pose.survey_center)
    jacobian = carry @ turn
    return np.asarray(jacobian @ pose.covariance @ jacobian.T)


def offset_sigma(offset: SurveyOffset, points: Array, directions: Array) -> Array:
    """Compute the sigma (n,) m that the offset gives points (n, 3) along unit vectors (n, 3)."""
    # A point moves by dt + w x (point - center). Its part along d has the derivatives d and
    # (point - center) x d.
    rows = np.concatenate([directions, np.cross(points - offset.center, directions)], axis=1)
    return np.asarray(np.sqrt(np.einsum("ni,ij,nj->n", rows, offset.covariance, rows)))


def _middle(chart: Chart, lattice: Lattice, relief: Relief) -> Array:
    """Find the point (3,) on the CAD model nearest to the middle of what a survey saw."""
    at = lattice.points()[np.isfinite(relief.height)]
    inner = at[np.argmin(np.linalg.norm(at - at.mean(axis=0), axis=1))]
    return np.asarray(chart.from_chart(inner[None])[0][0])


def _shifts(reliefs: tuple[Relief, Relief], fit: _Fit) -> list[Poses]:
    """Find the shifts along and in girth at which both surveys agree best, the best first.

    All shifts that the prior allows are tried, by whole cells of a lattice twice as coarse. Those
    with too small an overlap are left out. Raises StageError where none is left.
    """
    step = 2 * fit.lattice.step_m
    # Structures on every second cell of both surveys
    flat = [_without_form(relief.height)[::2, ::2] for relief in reliefs]
    along, girth = (axis[0] for axis in tangents_at(fit.chart, fit.center[None]))
    sigma = np.array([np.sqrt(axis @ fit.prior[:3, :3] @ axis) for axis in (along, girth)])
    reach = np.minimum(np.ceil(GATE_SIGMAS * sigma / step).astype(int), np.array(flat[0].shape) - 1)
    most = min(int(np.isfinite(h).sum()) for h in flat)  # cells of the smaller survey

    # Chi-square of each shift: of the differences in structures, by the number of independent
    # pieces of hull (as if all of it were shared, so that a small overlap has no advantage), and of
    # the prior.
    tried = []
    for i, j in np.ndindex(*(2 * reach + 1)):
        difference = _overlap(flat[0], flat[1], i - int(reach[0]), j - int(reach[1]))
        difference = difference[np.isfinite(difference)]
        if len(difference) < max(MIN_SHARED_CELLS / 4, MIN_SHARED_SHARE * most):
            continue
        shift = step * (np.array([i, j]) - reach)
        disagreement = (
            most
            * (step / CORRELATED_M) ** 2
            * _truncated_square(difference - np.median(difference))
        )
        tried.append((disagreement + float(((shift / sigma) ** 2).sum()), *shift.tolist()))
    if not tried:
        raise _too_little_error()
    # The best ones, of which no two lie next to each other.
    chosen: list[Array] = []
    for _, a, g in sorted(tried):
        if len(chosen) < STARTS and all(np.hypot(a - c[0], g - c[1]) > APART_M for c in chosen):
            chosen.append(np.array([a, g]))
    return [Poses(identity().quaternion, (a * along + g * girth)[None]) for a, g in chosen]


def _truncated_square(gap: Array) -> float:
    """Compute the mean square of differences (n,) m over SCALE_M, each truncated at TRUNCATED."""
    return float(np.minimum((gap / SCALE_M) ** 2, TRUNCATED**2).mean())


def _too_little_error() -> StageError:
    """Build the error of surveys that cannot be compared."""
    return StageError(
        "the two dives saw too little of the same hull",
        remedy="compare dives that survey the same part of the ship",
    )


def _without_form(height: Array) -> Array:
    """Leave only structures: subtract the form, in which the surveys may be tilted, and blur."""
    return blur(height - local_median(height, 50), 2.0)


def _overlap(first: Array, second: Array, i: int, j: int) -> Array:
    """Subtract the first survey from the second moved by (i, j) cells, where they overlap."""
    rows, columns = (
        slice(max(0, k), n + min(0, k)) for k, n in zip((i, j), first.shape, strict=True)
    )
    moved = second[rows.start - i : rows.stop - i, columns.start - j : columns.stop - j]
    return np.asarray(moved - first[rows, columns])


def _blur_both(reliefs: tuple[Relief, Relief], cells: float, fit: _Fit) -> tuple[Array, _Samples]:
    """Blur both surveys by the same sigma, in cells.

    Returns heights (a, g) of the first one, and samples of the second.
    """
    first, second = (blur(relief.height, cells) for relief in reliefs)
    shared = float(np.hypot(np.nanmedian(reliefs[0].sigma), np.nanmedian(reliefs[1].sigma)))
    return first, _samples(fit.chart, fit.lattice, second, shared)


def _samples(chart: Chart, lattice: Lattice, height: Array, shared_m: float) -> _Samples:
    """Sample a survey's surface at every second seen cell along and in girth.

    Cells without a direction along or in girth (at the chart's rim) are left out. height: (a, g) m
    over the chart. shared_m: sigma of the errors that a block of hull shares.
    """
    which = np.zeros(lattice.shape, bool)
    which[::2, ::2] = True
    which &= np.isfinite(height)
    at = lattice.points()[which]
    points, normals = chart.from_chart(at)
    axes = np.stack([*tangents_at(chart, points), normals])
    known = np.isfinite(axes).all(axis=(0, 2))
    block = np.floor(at[known] / BLOCK_M).astype(np.int64)
    return _Samples(
        points=(points + normals * height[which][:, None])[known],
        axes=axes[:, known],
        weight=(2 * lattice.step_m / CORRELATED_M) ** 2,
        block=np.unique(block, axis=0, return_inverse=True)[1].reshape(-1),
        shared_m=shared_m,
    )


def _covariance(information: Array, held: Array, by_error: Array, block: Ints) -> Array:
    """Compute the covariance (6, 6) of a fit whose errors are correlated [docs/methods.md (69)].

    Errors within a block of the hull are fully correlated. Independent errors are added.

    Parameters
    ----------
    information
        (6, 6) of the solution, with the prior.
    held
        (6, 6) information of the prior.
    by_error
        (n, 6) effect of each point's error, of one sigma, on the right-hand side.
    block
        (n,) number of each point's block.
    """
    # Errors of a block add up before they are squared: so `total` is summed by block
    inverse = np.linalg.inv(information)
    total = np.stack(
        [np.bincount(block, np.ascontiguousarray(by_error[:, k])) for k in range(6)], axis=1
    )
    spread = np.asarray(total.T @ total, float)
    return np.asarray(inverse @ (spread + held) @ inverse + inverse)


def _as_vector(motion: Poses, center: Array) -> Array:
    """Write a motion near the identity as translation (3) of the center and rotation vector (3)."""
    return np.asarray(np.r_[motion.apply(center[None])[0] - center, motion.rotation.as_rotvec()[0]])


def _apply_step(motion: Poses, step: Array, center: Array) -> Poses:
    """Move a motion further by a step (6,): translation, and rotation about the center."""
    turn = Rotation.from_rotvec(step[3:])
    after = Poses(turn.as_quat()[None], (center + step[:3] - turn.apply(center))[None])
    return after @ motion

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A hull's deviation from its CAD model, parted in its form and how the patch stands off it.

An error of the hull pose moves all that was seen by one rigid motion. Over the surveyed patch that
is a shift along the normal and two tilts, and little else. These three, fitted to the deviation,
are given apart with the sigma that the hull's pose leaves them: the form is known well, the level
badly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.estimation.landmark_variance import pose_jacobian
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh, vertex_areas
from hullrecon.geometry.robust import robust_sigma
from hullrecon.records.solution import HullPose
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.typing import Array, Mask

MIN_VERTICES = 30  # of bare hull, from which a level and two tilts are fitted
MIN_SCALE_M = 0.003  # vertices nearer to the fit than some of these are bare hull
OUTLIER_SIGMAS = 4.0


@dataclass(frozen=True, kw_only=True)
class _Fit:
    """Level and tilts of the patch."""

    columns: Array  # (n, 3) of the vertices
    solver: Array  # (3, n) from deviations to coefficients


def split_deviation(
    surface: Surface,
    own_sigma: Array | None,
    bare: Mask,
    cad_model: Mesh,
    chart: Chart,
    hull_pose: HullPose,
) -> DeviationSplit | None:
    """Split a deviation into offset, tilt and form. None if too little hull was seen.

    `own_sigma`: m, of each vertex without what all share (n,). None where only the whole is known.
    `bare`: vertices on which no structure stands (n,).
    """
    seen = (surface.support > 0) & np.isfinite(surface.deviation) & np.isfinite(surface.sigma)
    if (seen & bare).sum() < MIN_VERTICES:
        return None
    scene = Scene(cad_model)
    normals = scene.smooth_normals(scene.closest(surface.vertices[seen]))
    by_pose, pose = pose_jacobian(surface.vertices[seen], normals, hull_pose), hull_pose.covariance

    # Level and tilts of the patch are linear in the deviation and in the error of the hull pose.
    weight = np.where(bare, vertex_areas(surface.mesh()), 0.0)[seen]
    deviation, total = surface.deviation[seen], surface.sigma[seen]
    fit = _fit_patch(surface.vertices[seen], normals, deviation, weight, chart)
    coefficients, of_pose = fit.solver @ deviation, fit.solver @ by_pose
    # The variance of a vertex: its own, what the hull pose gives it, and what else all share.
    by_hull_pose = _variance(by_pose, pose)
    own = (
        np.sqrt(np.maximum(total**2 - by_hull_pose, 0.0)) if own_sigma is None else own_sigma[seen]
    )
    rest = np.maximum(total**2 - own**2 - by_hull_pose, 0.0)
    # The form is what level and tilts leave, and the hull pose leaves little of its error there.
    form, form_sigma = np.full((2, len(seen)), np.nan)
    form[seen] = deviation - fit.columns @ coefficients
    form_sigma[seen] = np.sqrt(_variance(by_pose - fit.columns @ of_pose, pose) + own**2 + rest)

    mean = np.average(fit.columns, axis=0, weights=weight)
    tilt = np.einsum("ki,ij,kj->k", of_pose[1:], pose, of_pose[1:])
    return DeviationSplit(
        offset=np.asarray(mean @ coefficients),
        offset_sigma=np.sqrt(
            _variance((mean @ of_pose)[None], pose)[0] + np.average(rest, weights=weight)
        ),
        tilt=coefficients[1:],
        tilt_sigma=np.sqrt(tilt),
        form=form,
        form_sigma=form_sigma,
    )


def _variance(rows: Array, covariance: Array) -> Array:
    return np.asarray(np.einsum("ni,ij,nj->n", rows, covariance, rows))


def _fit_patch(
    points: Array, normals: Array, deviation: Array, weight: Array, chart: Chart
) -> _Fit:
    """Fit by least squares over area, without what stands far off a first fit."""
    columns = _rigid_columns(points, normals, weight, chart)
    for _ in range(3):
        scaled = columns * weight[:, None]
        solver = np.linalg.pinv(columns.T @ scaled) @ scaled.T
        left = deviation - columns @ (solver @ deviation)
        scale = max(MIN_SCALE_M, robust_sigma(left[weight > 0], about=0.0))
        weight = np.where(np.abs(left) < OUTLIER_SIGMAS * scale, weight, 0.0)
    return _Fit(columns=columns, solver=solver)


def _rigid_columns(points: Array, normals: Array, weight: Array, chart: Chart) -> Array:
    """Derive vertices' moves along their normals (n, 3) by level and tilts.

    Level is a shift of the patch along its mean normal; tilts are rises along the hull or in girth
    by one metre a metre, about its middle.
    """
    middle, up = (np.average(values, axis=0, weights=weight) for values in (points, normals))
    up /= np.linalg.norm(up)
    along, _ = tangents_at(chart, points[[int(np.argmin(np.linalg.norm(points - middle, axis=1)))]])
    east = along[0] if np.isfinite(along).all() else np.eye(3)[int(np.argmin(np.abs(up)))]
    east = east - up * (east @ up)
    east /= np.linalg.norm(east)
    # charts are left-handed about the outward normal
    north, arm = np.cross(east, up), points - middle
    level = normals @ up
    rises = [(arm @ axis) * level - (arm @ up) * (normals @ axis) for axis in (east, north)]
    return np.stack([level, *rises], axis=1)

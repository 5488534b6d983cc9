# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Split a hull's deviation from its CAD model into offset, tilt and form of the surveyed patch.

An error of the hull pose moves the whole patch by one rigid motion, which shows as a shift along
the normal and two tilts. These three are fitted to the deviation, and have the large sigmas that
the hull pose leaves them. The rest, the form, is known much better.
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

MIN_VERTICES = 30  # least number of vertices of bare hull for a fit
MIN_SCALE_M = 0.003  # lower limit of the robust sigma by which outliers are judged
OUTLIER_SIGMAS = 4.0


@dataclass(frozen=True, kw_only=True)
class _Fit:
    """A linear fit of level (shift along the normal) and two tilts to deviations of n vertices."""

    columns: Array  # (n, 3) m, deviations by a level of 1 m and by each tilt of 1 m per metre
    solver: Array  # (3, n) map from deviations, m, to level and tilts


def split_deviation(
    surface: Surface,
    own_sigma: Array | None,
    bare: Mask,
    cad_model: Mesh,
    chart: Chart,
    hull_pose: HullPose,
) -> DeviationSplit | None:
    """Split the deviation of a surface into offset, tilt and form.

    With it a bump of the hull is reported with its own small sigma, not with that of the hull pose.
    Vertices that no sensor saw, or without a deviation or a sigma, are left out: their form is NaN.

    Parameters
    ----------
    surface
        The hull as found, with deviation and sigma at its n vertices.
    own_sigma
        (n,) m, the part of each vertex's sigma that is independent of the others. None: all but the
        part of the hull pose is.
    bare
        (n,) vertices on which no structure stands.
    cad_model, chart, hull_pose
        The CAD model, its chart, and its pose with covariance.

    Returns
    -------
    DeviationSplit or None
        None with fewer than MIN_VERTICES of bare hull.
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
    # The variance of a vertex: its own, that of the hull pose, and the rest, common to all.
    by_hull_pose = _variance(by_pose, pose)
    own = (
        np.sqrt(np.maximum(total**2 - by_hull_pose, 0.0)) if own_sigma is None else own_sigma[seen]
    )
    rest = np.maximum(total**2 - own**2 - by_hull_pose, 0.0)
    # The form is the deviation without level and tilts. The hull pose's error is left in it only as
    # far as it differs from a level and tilts of the patch.
    form, form_sigma = np.full((2, len(seen)), np.nan)
    form[seen] = deviation - fit.columns @ coefficients
    form_sigma[seen] = np.sqrt(_variance(by_pose - fit.columns @ of_pose, pose) + own**2 + rest)

    # The offset is the mean over the bare patch of what level and tilts fit
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
    """Propagate a covariance (k, k) through Jacobian rows (n, k) to variances (n,)."""
    return np.asarray(np.einsum("ni,ij,nj->n", rows, covariance, rows))


def _fit_patch(
    points: Array, normals: Array, deviation: Array, weight: Array, chart: Chart
) -> _Fit:
    """Find the linear fit of a shift along the normal (level) and two tilts to a patch's deviation.

    Least squares, weighted by area, repeated three times without the vertices that were outliers
    the time before. Returned is the map from deviations to level (m) and tilts (m per metre, about
    the patch's middle), not their values, as the same map carries the hull pose's error.

    Parameters
    ----------
    points, normals
        Vertices (n, 3) m, and normals (n, 3) of the CAD model there.
    deviation
        (n,) m, from the CAD model. It only decides which vertices are outliers.
    weight
        (n,) m2, area of each vertex, zero where it is not bare hull.
    chart
        Gives the directions of the two tilts: along, and in girth.
    """
    columns = _rigid_columns(points, normals, weight, chart)  # about the middle of the bare hull
    for _ in range(3):
        scaled = columns * weight[:, None]
        solver = np.linalg.pinv(columns.T @ scaled) @ scaled.T
        residual = deviation - columns @ (solver @ deviation)
        scale = max(MIN_SCALE_M, robust_sigma(residual[weight > 0], about=0.0))
        weight = np.where(np.abs(residual) < OUTLIER_SIGMAS * scale, weight, 0.0)
    return _Fit(columns=columns, solver=solver)


def _rigid_columns(points: Array, normals: Array, weight: Array, chart: Chart) -> Array:
    """Compute how much vertices move along their normals by level and by each tilt: (n, 3).

    points, normals: (n, 3) m and unit vectors of the vertices. weight: (n,) in the mean. Level is a
    shift of the patch along its mean normal by a metre. A tilt is a rise of one metre in a metre
    along the hull, or in girth, about the middle of the patch.
    """
    middle, up = (np.average(values, axis=0, weights=weight) for values in (points, normals))
    up /= np.linalg.norm(up)
    along, _ = tangents_at(chart, points[[int(np.argmin(np.linalg.norm(points - middle, axis=1)))]])
    along_axis = along[0] if np.isfinite(along).all() else np.eye(3)[int(np.argmin(np.abs(up)))]
    along_axis = along_axis - up * (along_axis @ up)
    along_axis /= np.linalg.norm(along_axis)
    # (along, girth) of a chart is left-handed about the outward normal
    girth_axis, arm = np.cross(along_axis, up), points - middle
    level = normals @ up
    # A small rotation about the middle moves a vertex by arm.axis along `up`, and back by arm.up
    # along the axis. Counted is the part of that along the vertex's normal.
    rises = [
        (arm @ axis) * level - (arm @ up) * (normals @ axis) for axis in (along_axis, girth_axis)
    ]
    return np.stack([level, *rises], axis=1)

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where on the hull the dive was: T_g_M settled by profile along the hull, and its covariance.

The solve slides along a flat valley and stops at a facet's edge or where its tolerance lets it (METHODS 5). The posterior along
the valley, with the drawing's error as correlated noise, is what is known; its mean is the place that the last round holds.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hullrecon import native
from hullrecon.adjustment import profile, registration
from hullrecon.adjustment.assembly import Selection
from hullrecon.adjustment.model import Drawing, Measurements, return_points
from hullrecon.adjustment.state import State
from hullrecon.adjustment.uncertainty import hull_axes
from hullrecon.adjustment.weak import weak_directions
from hullrecon.geometry.poses import Poses

Array = NDArray[np.float64]
POINT_NOISE_M = 0.005  # of the mean of a voxel of landmarks and returns
ALONG = np.array([1.0, 0.0, 0.0])


def points_on_hull(m: Measurements, state: State, chosen: Selection, label: NDArray[np.int32]) -> Array:
    """Points (n, 3) in g that lie on the hull: landmarks labelled so, and DVL returns; thinned to some hundreds."""
    landmarks = state.landmark[chosen.landmarks][label == 1] if len(chosen.landmarks) == len(label) else np.zeros((0, 3))
    parts = [landmarks]
    if m.returns is not None:
        ends, _ = return_points(m.returns, state.nodes, state.tray, m.rig.tray_origin, state.T_s_d)
        parts.append(ends[chosen.returns])
    return registration.thin(np.vstack(parts), 0.15, 800)


def settled(points: Array, place: Poses, drawing: Drawing, center: Array) -> Poses:
    """T_g_M at the mean of its profile along the hull."""
    return _profile(points, place, ALONG, drawing, center).hull_from


def covariance(points: Array, place: Poses, drawing: Drawing, center: Array, hessian: Array) -> Array:
    """Covariance (6, 6) of T_g_M: the solve's, with the variances along the hull and along its weak directions from their
    profiles, taken as the posterior's second moment about the delivered place."""
    out = hessian
    for direction in _directions(hull_axes(hessian, place)):
        found = _profile(points, place, direction, drawing, center)
        out = profile.inflated(out, replace(found, sigma=float(np.hypot(found.sigma, found.mean))), place)
    return out


def _profile(points: Array, place: Poses, direction: Array, drawing: Drawing, center: Array) -> profile.Profile:
    index = native.MeshIndex(drawing.mesh.vertices, drawing.mesh.faces)
    valley = profile.valley(points, place, direction, drawing, center, index, POINT_NOISE_M)
    return profile.profile(valley, place, reach=3 * float(np.linalg.norm(direction * drawing.guess_sigma[:3])))


def _directions(hull_in_axes: Array) -> list[Array]:
    """Along the hull, and the weak directions of position (unit vectors in M) that point elsewhere."""
    weak = [np.array(w["direction"]) for w in weak_directions(hull_in_axes) if w["kind"] == "position"]
    return [ALONG, *(d for d in weak if abs(d[0]) < 0.9)]

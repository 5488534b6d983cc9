# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where on the hull the dive was: T_g_M settled by profile along the hull, and its covariance.

The solve slides along a flat valley and stops at a facet's edge or where its tolerance lets it (docs/methods.md 9). The
posterior along the valley, with the CAD model's error as correlated noise, is what is known; its mean is the place that the last
round holds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import cho_factor

from hullrecon import native
from hullrecon.adjustment.hull_pose import cad_error, profile_likelihood, registration
from hullrecon.adjustment.hull_pose.cad_error import CadError
from hullrecon.adjustment.hull_pose.observability import find_weak_directions
from hullrecon.adjustment.problem.assembly import Selection
from hullrecon.adjustment.problem.measurements import CadModel, Measurements, return_points
from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.results.covariance import hull_axes
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array, Ints32

ALONG = np.array([1.0, 0.0, 0.0])
MAX_PASSES = 3


@dataclass(frozen=True)
class HullPoseEvidence:
    """Points (n, 3) in g that lie on the hull, the CAD model, the survey's centre (3,) in M, and how wrong the CAD model may be."""

    points: Array
    cad_model: CadModel
    center: Array
    cad_error_model: CadError


def collect_hull_points(m: Measurements, state: State, chosen: Selection, label: Ints32) -> Array:
    """Points (n, 3) in g that lie on the hull: landmarks labelled so, and DVL returns; thinned to some hundreds."""
    landmarks = state.landmark[chosen.landmarks][label == 1] if len(chosen.landmarks) == len(label) else np.zeros((0, 3))
    parts = [landmarks]
    if m.returns is not None:
        ends, _ = return_points(m.returns, state.nodes, state.tray, m.rig.tray_origin, state.T_s_d)
        parts.append(ends[chosen.returns])
    return registration.thin_points(np.vstack(parts), 0.15, 800)


def fit_hull_pose(points: Array, place: Poses, cad_model: CadModel, center: Array) -> tuple[HullPoseEvidence, Poses]:
    """The ground under points (n, 3) in g, stray ones left out; and T_g_M settled on it from `place`."""
    ground, index = HullPoseEvidence(points, cad_model, center, cad_error.expected_cad_error(cad_model)), _index(cad_model)
    for _ in range(MAX_PASSES):
        valley = _valley(ground, place, ALONG, index)
        place, _ = profile_likelihood.minimise_cost(valley, place)
        distance, _ = registration.signed_distances(ground.points, place, center, index)
        outlier = cad_error.find_outliers(valley.factor, distance)
        if not outlier.any():
            break
        ground = replace(ground, points=ground.points[~outlier])
    return ground, place


def profile_mean_pose(ground: HullPoseEvidence, place: Poses) -> Poses:
    """T_g_M at the mean of its profile along the hull."""
    return _profile(ground, place, ALONG).global_from_hull


def hull_pose_covariance(ground: HullPoseEvidence, place: Poses) -> Array:
    """Covariance (6, 6) of T_g_M about the centre, given the points: what the CAD model's error, its facets and the package's
    prior leave open; with the variances along the hull and along its weak directions from their profiles, taken as the
    posterior's second moment about the delivered place."""
    out = profile_likelihood.posterior_covariance(_valley(ground, place, ALONG, _index(ground.cad_model)), place)
    for direction in _directions(hull_axes(out, place)):
        found = _profile(ground, place, direction)
        out = profile_likelihood.inflate_covariance(out, replace(found, sigma=float(np.hypot(found.sigma, found.mean))), place)
    return out


def _profile(ground: HullPoseEvidence, place: Poses, direction: Array) -> profile_likelihood.Profile:
    valley = _valley(ground, place, direction, _index(ground.cad_model))
    return profile_likelihood.profile(
        valley, place, reach=3 * float(np.linalg.norm(direction * ground.cad_model.guess_sigma[:3]))
    )


def _valley(ground: HullPoseEvidence, place: Poses, direction: Array, index: native.MeshIndex) -> profile_likelihood.Valley:
    return profile_likelihood.Valley(ground.points, direction, ground.cad_model, ground.center, index, _factor(ground, place))


def _factor(ground: HullPoseEvidence, place: Poses) -> Any:
    return cho_factor(cad_error.distance_covariance(ground.cad_error_model, ground.cad_model, place.inverse().apply(ground.points)), lower=True)


def _index(cad_model: CadModel) -> native.MeshIndex:
    return native.MeshIndex(cad_model.mesh.vertices, cad_model.mesh.faces)


def _directions(hull_in_axes: Array) -> list[Array]:
    """Along the hull, and the weak directions of position (unit vectors in M) that point elsewhere."""
    weak = [np.array(w["direction"]) for w in find_weak_directions(hull_in_axes) if w["kind"] == "position"]
    return [ALONG, *(d for d in weak if abs(d[0]) < 0.9)]

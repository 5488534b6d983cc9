# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare what pairs of images show with what DVL, attitude and tray predict for them.

The motion of features is held against that of a hull at the DVL's range, seen by a camera that
moves by the DVL's velocity and turns by the attitude.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hullrecon.geometry.poses import Poses, interpolate
from hullrecon.geometry.rotations import cross
from hullrecon.navigation.suspects.comparisons.camera_turns import fit_turns
from hullrecon.navigation.suspects.comparisons.comparison import (
    LATE_S,
    LEAST_WINDOWS,
    TILT_RAD,
    Comparison,
    Sensor,
)
from hullrecon.navigation.suspects.comparisons.dvl_track import Track
from hullrecon.navigation.suspects.comparisons.hull import HullPlanes
from hullrecon.records.clock import NS
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

# sigmas of the features' motion: a share of each motion, a share that all have in common (range,
# curvature), and rad
FLOW_SHARE, FLOW_SCALE, FLOW_RAD = 0.05, 0.03, 0.003
USUAL_TRAY_RAD = np.radians(0.8)  # the default of tray.sigma_deg
VIEW_RAD = np.radians(0.2)  # sigma of a turn between two images by the attitude, and by a good lens
# sensors that the comparisons with images depend on
SEEN = frozenset({Sensor.CAMERA, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY})


@dataclass(frozen=True, kw_only=True)
class Flow:
    """Features of a rigid scene in two images of the upper camera."""

    t_ns: tuple[int, int]  # stamps of the images
    first: Array  # (m, 2) ideal coordinates
    second: Array  # (m, 2)

    @cached_property
    def rays(self) -> Array:
        """Build the rays (m, 3) to the features of the first image, with z = 1."""
        return np.column_stack([self.first, np.ones(len(self.first))])

    @cached_property
    def shift(self) -> Array:
        """Compute the median motion (2,) of the features."""
        return np.asarray(np.median(self.second - self.first, axis=0))


@dataclass(frozen=True, kw_only=True)
class Views:
    """Pairs of images, with what DVL, attitude and tray predict for them."""

    flows: Sequence[Flow]  # n, the features of each pair
    path: Poses  # global_from_dvl (m) at the pings of the track
    path_ns: Ints  # (m,) stamps of the path
    dvl_from_top: Poses  # mount of the upper camera
    tray_axis: Array  # (3,) in the camera
    # rad, by which the tray's angle may be off in one image against the other; 0 without a tray
    tray_sigma_rad: float
    away: Array  # (n, 3) normals of the planes of hull, in the axes of the first camera
    depth: Array  # (n,) m, distance of the planes from the first camera

    @cached_property
    def second_from_first(self) -> Poses:
        """Compute the motions (n) of the upper camera by DVL, attitude and tray."""
        return self._motions_at(0)

    @cached_property
    def turn_if_late(self) -> Array:
        """Compute the change of the turns, (n, 3) rad, if images were exposed LATE_S later."""
        later = self._motions_at(round(LATE_S * NS))
        return np.asarray((later.rotation * self.second_from_first.rotation.inv()).as_rotvec())

    def _motions_at(self, late_ns: int) -> Poses:
        """Compute second_from_first (n), with images exposed late_ns after their stamps."""
        at = np.array([flow.t_ns for flow in self.flows], np.int64) + late_ns
        top = interpolate(self.path_ns, self.path, at.T.ravel()) @ self.dvl_from_top
        return top[len(at) :].inverse() @ top[: len(at)]


def views_of(
    ping_ns: Ints, hull: HullPlanes, rig: Rig, flows: Sequence[Flow], track: Track
) -> Views | None:
    """Predict from DVL, attitude and tray what pairs of images show.

    That is how the upper camera moved between the two, and the plane of hull in front of it, from
    the nearest ping. None without a camera or with too few pairs.

    Parameters
    ----------
    ping_ns, hull
        Stamps of all pings, and planes of those that show one.
    rig
        Mounts of the sensors, and the sigma of the tray's angles where it has one.
    flows
        Features of the pairs of images.
    track
        Path and attitude of the DVL.
    """
    flows = [f for f in flows if track.t_ns[0] <= f.t_ns[0] and f.t_ns[1] <= track.t_ns[-1]]
    if rig.tray_from_top is None or len(flows) < LEAST_WINDOWS:
        return None
    # the ping with a plane of hull that is nearest to each first image
    common, _, plane_rows = np.intersect1d(track.t_ns, ping_ns[hull.ping], return_indices=True)
    if len(common) < LEAST_WINDOWS:
        return None
    first_ns = np.array([flow.t_ns[0] for flow in flows], np.int64)
    near = plane_rows[np.abs(common[:, None] - first_ns).argmin(axis=0)]
    dvl_from_top = rig.tray_from_dvl.inverse() @ rig.tray_from_top
    return Views(
        flows=flows,
        path=Poses(track.global_from_dvl.as_quat(), track.way.total),
        path_ns=track.t_ns,
        dvl_from_top=dvl_from_top,
        tray_sigma_rad=float(np.nan_to_num(rig.priors.tray_sigma_rad)),
        tray_axis=rig.tray_from_top.rotation.inv().apply([0.0, 1.0, 0.0])[0],
        away=dvl_from_top.rotation.inv().apply(hull.normal[near]),
        depth=hull.distance[near] - hull.normal[near] @ dvl_from_top.translation[0],
    )


def compare_flow(views: Views) -> Comparison | None:
    """Compare the median motion of features with that predicted from DVL, attitude and tray.

    Motions are in ideal coordinates. The features' rays are met with the plane of hull, and the
    points projected into the second image. None where too few pairs show the hull in front of the
    camera.
    """
    seen, predicted = [], []
    rotation = views.second_from_first.rotation.as_matrix()
    translation = views.second_from_first.translation
    for k, flow in enumerate(views.flows):
        slope = flow.rays @ views.away[k]  # a ray meets the plane at depth / slope times its length
        if views.depth[k] <= 0 or (slope <= 0).any():
            continue
        points = (flow.rays * (views.depth[k] / slope)[:, None]) @ rotation[k].T + translation[k]
        if (points[:, 2] <= 0).any():
            continue
        predicted.append(np.median(points[:, :2] / points[:, 2:] - flow.first, axis=0))
        seen.append(flow.shift)
    if len(seen) < LEAST_WINDOWS:
        return None
    by_images, by_dvl = np.array(seen), np.array(predicted)
    size = np.linalg.norm(by_dvl, axis=1, keepdims=True) * np.ones(2)
    # What a turn about the tray's axis moves in the middle of an image, by backlash beyond a usual
    # tray's, for which the other sigmas hold
    slop_rad = np.sqrt(max(views.tray_sigma_rad**2 - USUAL_TRAY_RAD**2, 0.0))
    turned = slop_rad * cross(views.tray_axis, np.array([0.0, 0.0, 1.0]))[:2]
    return Comparison(
        kind="flow",
        sensors=SEEN,
        residual=(by_images - by_dvl).ravel(),
        sigma=np.sqrt((FLOW_SHARE * size) ** 2 + FLOW_RAD**2 + turned**2).ravel(),
        # all flows may be longer or shorter by one factor, of sigma FLOW_SCALE
        by_nuisance=FLOW_SCALE * by_dvl.reshape(-1, 1),
        first=by_images.ravel(),
        second=by_dvl.ravel(),
    )


def compare_view(views: Views) -> Comparison | None:
    """Compare the camera's turn that features show with the turn by attitude and tray.

    The motion compared includes that of the scene by the camera's displacement: with a wrong
    distortion, a displacement across the view looks in part like a turn. About the tray's axis the
    sigma is large, because of its backlash. None where too few pairs show the hull.
    """
    rows = np.flatnonzero(views.depth > 0)
    if len(rows) < LEAST_WINDOWS:
        return None
    moved, flows = views.second_from_first[rows], [views.flows[k] for k in rows.tolist()]
    turn, sigma = fit_turns(moved, [flow.first for flow in flows], [flow.second for flow in flows])
    # sigmas, rad: of the tray's angle, and of the turn meanwhile where images are exposed late
    backlash, lag = TILT_RAD * views.tray_axis, views.turn_if_late[rows]
    # what the displacement across the view looks like, as a turn of the camera
    shift = cross(np.array([0.0, 0.0, 1.0]), moved.translation) / views.depth[rows, None]
    predicted = moved.rotation.as_rotvec() + shift
    return Comparison(
        kind="view",
        sensors=SEEN,
        unclear=frozenset({Sensor.DVL}),  # only the direction of its motion has an influence
        residual=turn.ravel(),
        sigma=np.sqrt(sigma**2 + VIEW_RAD**2 + backlash**2 + lag**2).ravel(),
        by_nuisance=np.zeros((turn.size, 0)),
        first=(predicted + turn).ravel(),
        second=predicted.ravel(),
    )

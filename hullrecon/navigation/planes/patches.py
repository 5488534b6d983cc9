# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find patches of the hull under a path: windows of DVL returns that fit a smooth surface.

See [Ozog2016 2.3.4].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.navigation.planes.patch_fit import PatchFit, fit_patch
from hullrecon.records.trajectory import Returns, VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

WINDOW_M = 0.8  # of path in one window: about half of what the beams span at a distance of a metre
WINDOW_S = 8.0  # of a window at most: dead reckoning over it is good to millimetres
MOST_RETURNS = 60  # of a window; more of them, where the vehicle stands still, add nothing
# between a patch and the origin of its anchor: a plane through that origin cannot be written as its
# normal times its distance
LEAST_DISTANCE_M = 0.1


@dataclass(frozen=True, kw_only=True)
class Patches:
    """Patches (w) along a path, in its order. Fields without a comment are those of PatchFit."""

    anchor: Ints  # (w,) node in the middle of the window
    rows: tuple[Ints, ...]  # of the returns, one array a patch
    center: Array  # (w, 3) in the vehicle frame of the anchor
    axes: Array  # (w, 3, 3) in the vehicle frame of the anchor
    curvature: Array
    curvature_covariance: Array
    plane_covariance: Array
    by_curvature: Array
    sigma_m: Array
    to_plane: tuple[Array, ...]
    travelled: Array  # (w,) m of the path up to the anchor

    def __len__(self) -> int:
        return len(self.anchor)

    @property
    def plane(self) -> Array:
        """The patches' planes (w, 3), m: unit normal times distance from the anchor's origin."""
        normal = self.axes[:, :, 2]
        return np.asarray(-np.sum(normal * self.center, axis=1, keepdims=True) * normal)


def find_patches(
    returns: Returns, path: VehiclePath, t_ns: Ints, rig: Rig, curvature_sigma: Array
) -> Patches:
    """Fit a patch of hull to the DVL returns of each window along a path.

    Two passes over one place are later tied by their patches. Windows whose returns fit no smooth
    patch are left out, so there may be none.

    Parameters
    ----------
    returns
        Ranges of the DVL with their nodes. Flagged ones are not used.
    path, t_ns
        Poses of vehicle and tray at the nodes, and their stamps (n,).
    rig
        Where the DVL sits, and the sigma of its ranges.
    curvature_sigma
        Prior sigma (3,), 1/m, of the curvature in azimuth, twist and elevation.
    """
    # The returns of each window along the path, thinned evenly.
    travelled = travelled_m(path.poses)
    number = _number_windows(travelled, t_ns)[returns.node]
    usable = np.flatnonzero(~returns.flagged)
    order = usable[np.argsort(number[usable], kind="stable")]
    groups = np.split(order, np.flatnonzero(np.diff(number[order])) + 1) if len(order) else []
    chosen = [
        group[np.linspace(0, len(group) - 1, min(len(group), MOST_RETURNS)).astype(int)]
        for group in groups
    ]

    # A patch is fitted in the vehicle frame of its anchor, the node in the middle of its window.
    # Its plane must not pass through that frame's origin.
    anchors = [int(np.median(returns.node[rows])) for rows in chosen]
    points, rays = _beams_in_anchors(returns, chosen, path, anchors, rig)
    found: list[tuple[int, Ints, PatchFit]] = []
    begin = 0
    for rows, anchor in zip(chosen, anchors, strict=True):
        window = slice(begin, begin + len(rows))
        begin = window.stop
        fit = fit_patch(points[window], rays[window], rig.priors.range_sigma_m, curvature_sigma)
        if fit is not None and -fit.axes[:, 2] @ fit.center > LEAST_DISTANCE_M:
            found.append((anchor, rows[fit.kept], fit))
    fits = [fit for _, _, fit in found]
    nodes = np.array([anchor for anchor, _, _ in found], np.int64)
    return Patches(
        anchor=nodes,
        rows=tuple(rows for _, rows, _ in found),
        center=np.array([f.center for f in fits]).reshape(-1, 3),
        axes=np.array([f.axes for f in fits]).reshape(-1, 3, 3),
        curvature=np.array([f.curvature for f in fits]).reshape(-1, 3),
        curvature_covariance=np.array([f.curvature_covariance for f in fits]).reshape(-1, 3, 3),
        plane_covariance=np.array([f.plane_covariance for f in fits]).reshape(-1, 3, 3),
        by_curvature=np.array([f.by_curvature for f in fits]).reshape(-1, 3, 3),
        sigma_m=np.array([f.sigma_m for f in fits]),
        to_plane=tuple(f.to_plane[f.kept] for f in fits),
        travelled=travelled[nodes],
    )


def _beams_in_anchors(
    returns: Returns, windows: list[Ints], path: VehiclePath, anchors: list[int], rig: Rig
) -> tuple[Array, Array]:
    """Compute ends and unit directions (m, 3) of the windows' beams in their anchors' frames.

    windows: rows of the returns of each window. anchors: the node in the middle of each. The beams
    are listed window after window.
    """
    if not windows:
        return np.zeros((0, 3)), np.zeros((0, 3))
    beams = rig.dvl_points(returns.take(np.concatenate(windows)), path)
    to_anchor = path.poses[np.repeat(anchors, [len(window) for window in windows])].inverse()
    return to_anchor.apply(beams.points), np.asarray(to_anchor.rotation.apply(beams.directions))


def travelled_m(poses: Poses) -> Array:
    """Compute the length (n,) m of the path up to each node."""
    return np.concatenate(
        [[0.0], np.cumsum(np.linalg.norm(np.diff(poses.translation, axis=0), axis=1))]
    )


def _number_windows(travelled: Array, t_ns: Ints) -> Ints:
    """Divide the path into windows of at most WINDOW_M and WINDOW_S.

    Within one the path is good enough for the returns to lie on one patch.

    travelled, t_ns (n,): length of the path up to each node, m, and stamps. Returns the number (n,)
    of each node's window, ascending.
    """
    out, begun = np.zeros(len(travelled), np.int64), 0
    for k in range(1, len(travelled)):
        over = travelled[k] - travelled[begun] > WINDOW_M or t_ns[k] - t_ns[begun] > WINDOW_S * 1e9
        out[k] = out[k - 1] + over
        begun = k if over else begun
    return out

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The vehicle over the hull: poses at nodes, odometry between them, and what was measured there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import Poses, interpolate
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class VehiclePath:
    """The vehicle and its tray at n instants. poses: T_x_v (n) in some frame x; tray (n,) rad."""

    poses: Poses
    tray: Array

    def __len__(self) -> int:
        return len(self.poses)

    def __getitem__(self, rows: Ints | Mask | slice) -> VehiclePath:
        return VehiclePath(poses=self.poses[rows], tray=self.tray[rows])


@dataclass(frozen=True, kw_only=True)
class VehicleTrack:
    """The best path of a dive that there is, in the frame of its results.

    t_ns (n,); poses: T_M_v, or T_g_v where frame is g; tray (n,) rad; covariance (n, 6, 6) of
    (translation in that frame, rotation perturbed on the right); image (n, 2): rows in the indices
    of the cameras, -1 where none.
    """

    t_ns: Ints
    poses: Poses
    tray: Array
    covariance: Array
    image: Ints
    frame: Frame

    @property
    def path(self) -> VehiclePath:
        """Return poses and tray at the nodes."""
        return VehiclePath(poses=self.poses, tray=self.tray)

    @property
    def sigma(self) -> Array:
        """Return one sigma (n, 6) of x, y, z (m), roll, pitch, yaw (rad)."""
        return np.asarray(np.sqrt(np.einsum("nii->ni", self.covariance)))

    def sigma_towards(self, directions: Array) -> Array:
        """Return one sigma of the position (n,), m, along unit vectors (n, 3) of the frame."""
        return np.asarray(
            np.sqrt(np.einsum("ni,nij,nj->n", directions, self.covariance[:, :3, :3], directions))
        )

    def sigma_on_chart(self, chart: Chart) -> tuple[float, float]:
        """Return the median one sigma of the position along the hull and in girth, m, by the
        chart's tangents below the vehicle; NaN where it is nowhere over the chart.
        """
        along, girth = (
            self.sigma_towards(direction)
            for direction in tangents_at(chart, self.poses.translation)
        )
        known = np.isfinite(along) & np.isfinite(girth)
        return (
            (float(np.median(along[known])), float(np.median(girth[known])))
            if known.any()
            else (np.nan, np.nan)
        )

    def vehicle_at(self, t_ns: Ints) -> Poses:
        """Return the vehicle (m) at those times, held at both ends."""
        return interpolate(self.t_ns, self.poses, t_ns)


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """T_g_v at n nodes: quaternion (n, 4), translation (n, 3), covariance (n, 6, 6) of (translation
    in g, rotation as a right perturbation in v), tray (n,) rad, image (n, 2): row in the index of
    camera_top and camera_bottom, -1 where none.

    A node stands at each camera frame; DVL pings farther than a second from any frame have nodes
    too, thinned out.
    """

    t_ns: Ints
    quaternion: Array
    translation: Array
    covariance: Array
    tray: Array
    image: Ints

    def poses(self) -> Poses:
        """Return T_g_v (n)."""
        return Poses(self.quaternion, self.translation)

    def track(self) -> VehicleTrack:
        """Return the dead-reckoned vehicle in g."""
        return VehicleTrack(
            t_ns=self.t_ns,
            poses=self.poses(),
            tray=self.tray,
            covariance=self.covariance,
            image=self.image,
            frame=Frame.GLOBAL,
        )


@dataclass(frozen=True, kw_only=True)
class TrajectoryErrorModel:
    """What makes the poses of a Trajectory wrong, by cause, so that errors which two nodes share
    can cancel.

    Errors are twists about the origin of g, Exp(twist) T_g_v, (translation, rotation): whatever is
    fixed to the vehicle has the same. by_error (n, 6, k): derivative of each node's twist by the k
    errors that are one unknown for the dive; error_covariance (k, k) of those (k may be 0). walk
    (n, 6, 6): covariance that has accumulated since the start, negative before it; between two
    nodes it is the difference. white (n, 6, 6): covariance of what is new at each node.
    """

    by_error: Array
    error_covariance: Array
    walk: Array
    white: Array


@dataclass(frozen=True, kw_only=True)
class Odometry(Rows):
    """Relative motion between neighbouring nodes, `T_i^-1 T_j`, with its derivatives by the errors
    that persist.

    first, second (m,): nodes. quaternion (m, 4), translation (m, 3): the measured motion.
    covariance (m, 6, 6): of its white part, (translation, right-perturbed rotation). by_navigation
    (m, 6, 2): derivative of the measured (translation, rotation) by the DVL's scale error (a true
    speed of (1 + e) v) and by the heading drift in rad/s. by_mount (m, 6, 3): by a rotation vector
    of T_s_d, right-perturbed. by_tray (m, 6): by an error of the tray's angle that is common to
    both nodes. from_images (m,): the two nodes' images measured the motion.
    """

    first: Ints
    second: Ints
    quaternion: Array
    translation: Array
    covariance: Array
    by_navigation: Array
    by_mount: Array
    by_tray: Array
    from_images: Mask

    def sigma_between(self, first: Ints, second: Ints) -> Array:
        """Return how well the motions tell the way (m,) m from a node to a later one, of the axis
        that they tell worst.
        """
        nodes = 1 + max(int(rows.max(initial=0)) for rows in (self.second, first, second))
        walked_m2 = np.zeros(nodes)
        np.add.at(walked_m2, self.second, self.covariance[:, [0, 1, 2], [0, 1, 2]].max(axis=1))
        walked_m2 = np.cumsum(walked_m2)
        return np.asarray(np.sqrt(walked_m2[second] - walked_m2[first]))


@dataclass(frozen=True, kw_only=True)
class Returns(Rows):
    """DVL returns, one row a beam that came back. node (m,): the nearest node; quaternion (m, 4),
    translation (m, 3): the vehicle at the ping in the vehicle at the node (dead reckoned);
    tray_offset (m,): tray at ping minus tray at node, rad; beam (m, 3) unit vector in `dvl`;
    range_m (m,); flagged (m,) bool: disagrees with its neighbours; t_ns (m,).
    """

    t_ns: Ints
    node: Ints
    quaternion: Array
    translation: Array
    tray_offset: Array
    beam: Array
    range_m: Array
    flagged: Mask


@dataclass(frozen=True, kw_only=True)
class PositionTies(Rows):
    """Positions from outside at the nodes. node (m,): the nearest; antenna (m, 3) m: where the
    position was measured, in the vehicle at the node, moved since by dead reckoning; north_east (m,
    2) m of the first fix; sigma (m,) m of either; t_ns (m,).
    """

    t_ns: Ints
    node: Ints
    antenna: Array
    north_east: Array
    sigma: Array


@dataclass(frozen=True, kw_only=True)
class Attitude:
    """Depth, roll and pitch at the nodes, as measured: node (m,), depth (m,) of the pressure
    sensor, roll, pitch (m,) rad, and one sigma of the white part of each (m, 3). nodes_per_reading
    (m,): nodes that a reading of the pressure sensor comes to, 1 at least, by whose square root the
    sigma of their depths is the larger; 0 where none was read. tray_direction (n_nodes,): +1 or -1,
    the sense in which the tray last moved (for the servo's backlash); tray_sigma (n_nodes,): rad,
    beside the servo's own, of what the tray may have turned while its angle was not read.
    """

    node: Ints
    depth: Array
    roll: Array
    pitch: Array
    sigma: Array
    nodes_per_reading: Array
    tray_direction: Array
    tray_sigma: Array

    @property
    def has_depth(self) -> Mask:
        """Return at which rows (m,) a depth was measured."""
        return np.asarray(self.nodes_per_reading > 0)

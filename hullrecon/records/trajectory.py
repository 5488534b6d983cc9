# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The vehicle over the hull: poses at nodes, odometry between them, and measurements at nodes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.frames import Camera, Frame
from hullrecon.geometry.poses import Poses, exp, interpolate
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class VehiclePath:
    """The vehicle and its tray at n instants."""

    poses: Poses  # (n,) of the vehicle in some frame
    tray: Array  # (n,) rad

    def __len__(self) -> int:
        return len(self.poses)

    def __getitem__(self, rows: Ints | Mask | slice) -> VehiclePath:
        return VehiclePath(poses=self.poses[rows], tray=self.tray[rows])


@dataclass(frozen=True, kw_only=True)
class Exposures(Rows):
    """When each node's images were exposed, and how the tray moved meanwhile."""

    # (n, 2) how long after the node's time the first row of the top and of the bottom camera's
    # image was exposed, whatever their stamps say
    late_s: Array
    twist: Array  # (n, 6) of the tray in its own axes, m/s and rad/s
    depth_m: Array  # (n,) of the scene in the top camera by the DVL, NaN where not measured
    readout_s: Array  # (2,) from the first row of an image of either camera to its last

    SHARED: ClassVar = frozenset({"readout_s"})

    def motion(self, camera: Camera, row_share: Array | float) -> Poses:
        """Compute the tray's motion until a row's exposure: tray_at_node from tray_at_exposure.

        row_share: place of the row in the image (m,), 0 for the first row and 1 for the last. These
        exposures are of m nodes, or of one node for all m rows.
        """
        after_s = self.late_s[:, camera.column] + self.readout_s[camera.column] * row_share
        return exp(np.atleast_1d(after_s)[:, None] * self.twist)


@dataclass(frozen=True, kw_only=True)
class VehicleTrack:
    """The best path available of a dive, in the frame of its results."""

    t_ns: Ints
    poses: Poses  # (n,) of the vehicle in `frame`
    tray: Array  # (n,) rad
    covariance: Array  # (n, 6, 6) of (translation in that frame, rotation perturbed on the right)
    image: Ints  # (n, 2) rows in the cameras' indices, -1 without an image
    frame: Frame
    exposures: Exposures | None = None  # None: all images were exposed at their node's time

    @property
    def path(self) -> VehiclePath:
        """Poses and tray at the nodes."""
        return VehiclePath(poses=self.poses, tray=self.tray)

    @property
    def sigma(self) -> Array:
        """Sigmas (n, 6) of x, y, z (m), roll, pitch, yaw (rad)."""
        return np.asarray(np.sqrt(np.einsum("nii->ni", self.covariance)))

    def sigma_towards(self, directions: Array) -> Array:
        """Compute the sigma of the position (n,), m, along unit vectors (n, 3)."""
        return np.asarray(
            np.sqrt(np.einsum("ni,nij,nj->n", directions, self.covariance[:, :3, :3], directions))
        )

    def sigma_on_chart(self, chart: Chart) -> tuple[float, float]:
        """Compute the median sigma of the vehicle's position along the hull and in girth, m.

        The directions are the chart's tangents below the vehicle. NaN if it is nowhere over the
        chart.
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
        """Interpolate the vehicle's pose at times (m,), held at both ends."""
        return interpolate(self.t_ns, self.poses, t_ns)

    def path_at(self, t_ns: Ints) -> VehiclePath:
        """Interpolate vehicle and tray at times (m,), held at both ends."""
        tray = np.interp((t_ns - self.t_ns[0]) * 1e-9, (self.t_ns - self.t_ns[0]) * 1e-9, self.tray)
        return VehiclePath(poses=self.vehicle_at(t_ns), tray=tray)


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """The vehicle by dead reckoning, at nodes.

    There is a node at each camera frame. DVL pings farther than a second from any frame have nodes
    too, thinned out.
    """

    t_ns: Ints
    quaternion: Array  # (n, 4) global_from_vehicle
    translation: Array  # (n, 3) m
    covariance: Array  # (n, 6, 6) of (translation in g, rotation right-perturbed in v)
    tray: Array  # (n,) rad
    image: Ints  # (n, 2) rows in the cameras' indices, top and bottom, -1 without an image
    exposures: Exposures | None = None  # None: all images were exposed at their node's time

    def poses(self) -> Poses:
        """Combine rotation and translation to global_from_vehicle (n)."""
        return Poses(self.quaternion, self.translation)

    def track(self) -> VehicleTrack:
        """Convert to a track in g, for use where no adjusted path exists yet."""
        return VehicleTrack(
            t_ns=self.t_ns,
            poses=self.poses(),
            tray=self.tray,
            covariance=self.covariance,
            image=self.image,
            frame=Frame.GLOBAL,
            exposures=self.exposures,
        )


@dataclass(frozen=True, kw_only=True)
class TrajectoryErrorModel:
    """Errors of the poses of a Trajectory, by cause, so that errors shared by two nodes cancel.

    Errors are twists about the origin of g, Exp(twist) global_from_vehicle, (translation,
    rotation). Whatever is fixed to the vehicle has the same twist.
    """

    # (n, 6, k) derivative of each node's twist by k errors that are one unknown for the dive
    by_error: Array
    error_covariance: Array  # (k, k) of those errors, k may be 0
    # (n, 6, 6) covariance accumulated since the start, negative before it. Between two nodes it is
    # the difference.
    walk: Array
    white: Array  # (n, 6, 6) covariance of what is new at each node


@dataclass(frozen=True, kw_only=True)
class Odometry(Rows):
    """Relative motion between neighbouring nodes, with derivatives by errors that persist."""

    first: Ints  # (m,) nodes
    second: Ints  # (m,) nodes
    quaternion: Array  # (m, 4) measured first_from_second
    translation: Array  # (m, 3) m
    covariance: Array  # (m, 6, 6) of its white part, (translation, right-perturbed rotation)
    # (m, 6, 2) by the DVL's scale error (a true speed of (1 + e) v) and heading drift, rad/s
    by_navigation: Array
    by_mount: Array  # (m, 6, 3) by a rotation vector of tray_from_dvl, right-perturbed
    by_tray: Array  # (m, 6) by an error of the tray's angle common to both nodes
    from_images: Mask  # (m,) images of the two nodes measured the motion

    def sigma_between(self, first: Ints, second: Ints) -> Array:
        """Compute the sigma (m,), m, of the displacement from nodes `first` to later ones `second`.

        The variances of the motions in between are summed, of each motion the largest of its three
        axes. Errors that persist (scale, heading) are not included.
        """
        nodes = 1 + max(int(rows.max(initial=0)) for rows in (self.second, first, second))
        walked_m2 = np.zeros(nodes)
        # variance that grew from the first node to each: between two nodes it is the difference
        np.add.at(walked_m2, self.second, self.covariance[:, [0, 1, 2], [0, 1, 2]].max(axis=1))
        walked_m2 = np.cumsum(walked_m2)
        return np.asarray(np.sqrt(walked_m2[second] - walked_m2[first]))


@dataclass(frozen=True, kw_only=True)
class Returns(Rows):
    """DVL returns, one row per beam that came back."""

    t_ns: Ints
    node: Ints  # (m,) nearest
    quaternion: Array  # (m, 4) vehicle at the ping in the vehicle at the node, dead reckoned
    translation: Array  # (m, 3) m
    tray_offset: Array  # (m,) rad, tray at ping minus tray at node
    beam: Array  # (m, 3) unit vector in `dvl`
    range_m: Array  # (m,)
    flagged: Mask  # (m,) the range disagrees with those of the same beam's neighbouring pings
    # share by which all ranges may be too long or short, beyond what the speed of sound makes
    scale_sigma: Array = field(default_factory=lambda: np.array(0.0))

    SHARED: ClassVar = frozenset({"scale_sigma"})


@dataclass(frozen=True, kw_only=True)
class PositionTies(Rows):
    """Position fixes (USBL, GNSS), each tied to the nearest node."""

    t_ns: Ints
    node: Ints  # (m,) nearest
    # (m, 3) m, the measured point (antenna or transponder at the time of the fix) in the vehicle's
    # frame at the node, with the motion in between by dead reckoning
    antenna: Array
    north_east: Array  # (m, 2) m from the first fix
    sigma: Array  # (m,) m of either


@dataclass(frozen=True, kw_only=True)
class Attitude:
    """Depth, roll and pitch as measured at the nodes, and what the tray's angle is known to."""

    node: Ints  # (m,)
    depth: Array  # (m,) m of the pressure sensor
    roll: Array  # (m,) rad
    pitch: Array  # (m,) rad
    sigma: Array  # (m, 3) of the white part of depth, roll, pitch
    # (m,) nodes that share a pressure reading, by whose square root their sigma is larger, 0
    # without a reading
    nodes_per_reading: Array
    tray_direction: Array  # (nodes,) +1 or -1, sense in which the tray last moved
    # (nodes,) rad, of the servo's turn while it was not read, in addition to its own sigma
    tray_sigma: Array

    @property
    def has_depth(self) -> Mask:
        """Rows (m,) at which a depth was measured."""
        return np.asarray(self.nodes_per_reading > 0)

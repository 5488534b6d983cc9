# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The records that steps hand to each other: frozen structs of arrays, written as .npz by field name.

Times are int64 nanoseconds since 1970; metres, radians and seconds else. Lost values are NaN.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Record = TypeVar("Record")


def to_arrays(record: object) -> dict[str, NDArray[np.generic]]:
    """The fields of a record by name, ready for an .npz."""
    return {f.name: np.asarray(getattr(record, f.name)) for f in fields(record)}  # type: ignore[arg-type]


def from_arrays(kind: type[Record], arrays: Mapping[str, NDArray[np.generic]]) -> Record:
    """The record of that kind; raises KeyError with the missing field's name."""
    return kind(**{f.name: arrays[f.name] for f in fields(kind)})  # type: ignore[arg-type]


@dataclass(frozen=True)
class DvlPings:
    """velocity (n, 3) m/s of the instrument in `dvl` (NaN when lost), velocity_sigma (n,) m/s, ranges (n, b) m along the
    beams (NaN when lost), beams (b, 3) unit vectors in `dvl`."""

    t_ns: Ints
    velocity: Array
    velocity_sigma: Array
    ranges: Array
    beams: Array


@dataclass(frozen=True)
class ImuSamples:
    """quaternion (n, 4): rotation of `vehicle` in `global` (NED-like, converted at ingest); rates (n, 3) rad/s and
    acceleration (n, 3) m/s2 in `vehicle`, NaN when not logged."""

    t_ns: Ints
    quaternion: Array
    angular_velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class PressureSamples:
    """depth (n,) m of the sensor below the surface, positive down."""

    t_ns: Ints
    depth: Array


@dataclass(frozen=True)
class JointSamples:
    """angle (n,) rad of one servo as logged."""

    t_ns: Ints
    angle: Array


@dataclass(frozen=True)
class ImageIndex:
    """Images of one camera in time order. file (n,) str: path relative to the package, or "" when the bytes lie in the
    ingest artifact's images_<camera>.bin at offset (n,), size (n,). usable (n,) bool: it decoded."""

    t_ns: Ints
    file: NDArray[np.str_]
    offset: Ints
    size: Ints
    usable: NDArray[np.bool_]


@dataclass(frozen=True)
class SonarPings:
    """image (n, beams, ranges) uint8, directions (beams, 3) unit vectors in `sonar`, range_m (ranges,) bin centres."""

    t_ns: Ints
    image: NDArray[np.uint8]
    directions: Array
    range_m: Array


@dataclass(frozen=True)
class Trajectory:
    """T_g_v at n nodes: quaternion (n, 4), translation (n, 3), covariance (n, 6, 6) of (translation in g, rotation as a
    right perturbation in v), tray (n,) rad, image (n, 2): row in the index of camera_top and camera_bottom, -1 where none.

    A node stands at each camera frame; a DVL ping farther than a second from any camera frame has its own node.
    """

    t_ns: Ints
    quaternion: Array
    translation: Array
    covariance: Array
    tray: Array
    image: Ints

    def poses(self) -> Poses:
        return Poses(self.quaternion, self.translation)


@dataclass(frozen=True, kw_only=True)
class TrajectoryErrorModel:
    """What makes the poses of a Trajectory wrong, by cause, so that errors which two nodes share can cancel.

    Errors are twists about the origin of g, Exp(twist) T_g_v, (translation, rotation): whatever is fixed to the vehicle has the
    same. by_error (n, 6, k): derivative of each node's twist by the k errors that are one unknown for the dive;
    error_covariance (k, k) of those (k may be 0). walk (n, 6, 6): covariance that has accumulated since the first instant;
    between two nodes it is the difference. white (n, 6, 6): covariance of what is new at each node.
    """

    by_error: Array
    error_covariance: Array
    walk: Array
    white: Array


@dataclass(frozen=True)
class Odometry:
    """Relative motion between neighbouring nodes, `T_i^-1 T_j`, with its derivatives by the errors that persist.

    first, second (m,): nodes. quaternion (m, 4), translation (m, 3): the measured motion. covariance (m, 6, 6): of its white
    part, (translation, right-perturbed rotation). by_navigation (m, 6, 2): derivative of the measured (translation, rotation)
    by the DVL's scale error (a true speed of (1 + e) v) and by the heading drift in rad/s. by_mount (m, 6, 3): by a rotation
    vector of T_s_d, right-perturbed. by_tray (m, 6): by an error of the tray's angle that is common to both nodes.
    """

    first: Ints
    second: Ints
    quaternion: Array
    translation: Array
    covariance: Array
    by_navigation: Array
    by_mount: Array
    by_tray: Array


@dataclass(frozen=True)
class Returns:
    """DVL returns, one row a beam that came back. node (m,): the nearest node; quaternion (m, 4), translation (m, 3): the
    vehicle at the ping in the vehicle at the node (dead reckoned); tray_offset (m,): tray at ping minus tray at node, rad;
    beam (m, 3) unit vector in `dvl`; range_m (m,); flagged (m,) bool: disagrees with its neighbours; t_ns (m,)."""

    t_ns: Ints
    node: Ints
    quaternion: Array
    translation: Array
    tray_offset: Array
    beam: Array
    range_m: Array
    flagged: NDArray[np.bool_]


@dataclass(frozen=True)
class Attitude:
    """Depth, roll and pitch at the nodes, as measured: node (m,), depth (m,) of the pressure sensor, roll, pitch (m,) rad,
    and one sigma of the white part of each (m, 3). tray_direction (n_nodes,): +1 or -1, the sense in which the tray last
    moved (for the servo's play)."""

    node: Ints
    depth: Array
    roll: Array
    pitch: Array
    sigma: Array
    tray_direction: Array


@dataclass(frozen=True)
class Tracks:
    """Observations, sorted by (landmark, node): landmark (m,), node (m,), top (m, 2) and bottom (m, 2) pixels in the raw
    (distorted) images, NaN where that camera did not see it. color (landmarks, 3) uint8 RGB."""

    landmark: Ints
    node: Ints
    top: Array
    bottom: Array
    color: NDArray[np.uint8]


@dataclass(frozen=True)
class Surface:
    """vertices (n, 3) in M (g without a drawing), faces (m, 3); deviation (n,) m against the drawing, outward positive, NaN
    without; sigma (n,) m; support (n,) int: returns (surface) or views (as found) behind a vertex, 0 = unseen."""

    vertices: Array
    faces: NDArray[np.int32]
    deviation: Array
    sigma: Array
    support: Ints

    def mesh(self) -> Mesh:
        return Mesh(self.vertices, self.faces)


@dataclass(frozen=True)
class Solution:
    """The adjusted dive. T_g_v: quaternion, translation, tray, tray_sigma by node; pose_covariance (n, 6, 6) of T_M_v (of T_g_v
    without a drawing): (translation in M, rotation right-perturbed in v). Landmarks: position (L, 3) in g, covariance (L, 3, 3)
    in M, label (L,) 1 = on the drawn surface, deviation (L,) signed distance to the drawing (NaN without one), views (L,),
    color (L, 3). hull_from and mounts: T_g_M, T_s_ct, T_ct_cb, T_s_d as 7 numbers x y z qx qy qz qw (NaN where absent);
    hull_covariance (6, 6) of T_g_M, (translation in g, rotation right-perturbed in M) about survey_center (3,) in M: of where
    the hull lies given the dive's own frame, the drawing's error in it (docs/adr/0011); as published, the solve's marginal.
    navigation (6,): DVL scale error, heading drift rad/s, roll and pitch bias rad, depth bias m, tray play rad.
    The deviation field on the chart: field_origin (2,), field_step (2,) m, field_value (a, g), field_sigma (a, g)."""

    t_ns: Ints
    image: Ints
    quaternion: Array
    translation: Array
    tray: Array
    tray_sigma: Array
    pose_covariance: Array
    landmark: Array
    landmark_covariance: Array
    label: Ints
    deviation: Array
    views: Ints
    color: NDArray[np.uint8]
    T_g_M: Array
    T_s_ct: Array
    T_ct_cb: Array
    T_s_d: Array
    hull_covariance: Array
    survey_center: Array
    navigation: Array
    field_origin: Array
    field_step: Array
    field_value: Array
    field_sigma: Array

    def poses(self) -> Poses:
        """T_g_v."""
        return Poses(self.quaternion, self.translation)

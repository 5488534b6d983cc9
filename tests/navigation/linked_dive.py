# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two long legs with truth, there and back, in plain NumPy: what navigation measures of them under
a drifting heading, and what pairs of images measure.

Every error is drawn from the sigma that the records state: scale, drift and mount of the DVL,
biases, white noise, links.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, from_mount, identity
from hullrecon.records.links import CameraLinks
from hullrecon.records.trajectory import Attitude, Odometry, Trajectory
from hullrecon.rig import Rig, RigPriors
from hullrecon.studies.scenes.ellipsoid_dive import (
    ATTITUDE_SIGMA,
    TRAY_ORIGIN_M,
    measured_steps,
    reckoned,
)

STEP_S, STEP_M, APART_M = 2.0, 0.5, 0.6
STEP_SIGMA = np.r_[np.full(3, 3e-3), np.full(3, 5e-4)]  # m, rad of odometry a step
LINK_SIGMA = np.r_[np.full(3, 3e-3), np.full(3, 1e-3)]
# scale, drift rad/s, roll, pitch, depth m, backlash
NAVIGATION_SIGMA = np.array([0.01, 1e-3, 2e-3, 2e-3, 0.02, 1e-3])
DVL_TURN_SIGMA = np.radians(0.3)
TRAY_FROM_TOP, TOP_FROM_BOTTOM = (
    from_mount([0.03, 0.05, -0.05, 90, 0, 90]),
    from_mount([0.0, 0.1, 0.0, 0.5, -0.3, 0.2]),
)


def matrices(translation: np.ndarray, rotation: Rotation) -> np.ndarray:
    """T (n, 4, 4)."""
    out = np.tile(np.eye(4), (len(translation), 1, 1))
    out[:, :3, :3], out[:, :3, 3] = rotation.as_matrix(), translation
    return out


def poses(transform: np.ndarray) -> Poses:
    return Poses(Rotation.from_matrix(transform[:, :3, :3]).as_quat(), transform[:, :3, 3].copy())


@dataclass(frozen=True, kw_only=True)
class LinkedDive:
    """True global_from_vehicle (n, 4, 4), tray at zero; navigation of it; the rig."""

    global_from_vehicle: np.ndarray
    trajectory: Trajectory
    odometry: Odometry
    attitude: Attitude
    rig: Rig

    def cameras(self, bottom: np.ndarray | bool = False) -> np.ndarray:
        """T_g_c (n, 4, 4) of the top camera, or of the bottom one at the nodes where that is asked
        for.
        """
        offset = np.eye(4)
        offset[:3, 3] = TRAY_ORIGIN_M
        top = self.global_from_vehicle @ offset @ TRAY_FROM_TOP.matrix()[0]
        lower = np.broadcast_to(bottom, len(top))[:, None, None]
        return np.where(lower, top @ TOP_FROM_BOTTOM.matrix()[0], top)


def simulate(seed: int, per_leg: int = 30, drift: float | None = None) -> LinkedDive:
    """The dive. drift: rad/s of the heading; drawn where it is not stated."""
    rng = np.random.default_rng(seed)
    truth = true_path(per_leg)
    navigation = NAVIGATION_SIGMA * rng.standard_normal(6)
    navigation[1] = navigation[1] if drift is None else drift
    odometry = measured_steps(
        rng, truth, navigation, DVL_TURN_SIGMA * rng.standard_normal(3), STEP_S, STEP_SIGMA
    )
    roll_pitch = Rotation.from_matrix(truth[:, :3, :3]).as_euler("xyz")[:, :2] + navigation[2:4]
    measured = np.column_stack(
        [truth[:, 2, 3] + navigation[4], roll_pitch]
    ) + ATTITUDE_SIGMA * rng.standard_normal((len(truth), 3))
    attitude = Attitude(
        node=np.arange(len(truth)),
        depth=measured[:, 0],
        roll=measured[:, 1],
        pitch=measured[:, 2],
        sigma=np.tile(ATTITUDE_SIGMA, (len(truth), 1)),
        nodes_per_reading=np.ones(len(truth)),
        tray_direction=np.ones(len(truth)),
        tray_sigma=np.zeros(len(truth)),
    )
    return LinkedDive(
        global_from_vehicle=truth,
        trajectory=reckoned(truth[0], odometry, STEP_S),
        odometry=odometry,
        attitude=attitude,
        rig=rig(),
    )


def rig() -> Rig:
    """The DVL's turn is known to 0.3 degrees, its place and both cameras' mounts are known."""
    return Rig(
        tray_origin=TRAY_ORIGIN_M,
        pressure_origin=np.zeros(3),
        tray_from_dvl=identity(1),
        tray_from_top=TRAY_FROM_TOP,
        top_from_bottom=TOP_FROM_BOTTOM,
        priors=RigPriors(
            tray_from_dvl=np.diag(1 / np.r_[np.full(3, 1e-6), np.full(3, DVL_TURN_SIGMA)]),
            dvl_position_sigma_m=np.zeros(3),
            tray_sigma_rad=1e-3,
            navigation_sigma=NAVIGATION_SIGMA,
            density_sigma=0.002,
            range_sigma_m=0.01,
        ),
    )


def true_path(per_leg: int) -> np.ndarray:
    """A vehicle that faces the hull and goes sideways along it, out and back, half a metre deeper
    on its way back.
    """
    k = np.arange(2 * per_leg)
    back = k >= per_leg
    along = STEP_M * np.where(back, 2 * per_leg - 1 - k, k)
    place = np.column_stack(
        [0.05 * np.sin(0.3 * k), along, 3.0 + APART_M * back + 0.05 * np.sin(0.2 * k)]
    )
    turn = np.column_stack([0.03 * np.sin(0.2 * k), 0.02 * np.cos(0.3 * k), 0.1 * np.sin(0.1 * k)])
    return matrices(place, Rotation.from_euler("xyz", turn))


def neighbours(per_leg: int = 30, reach: int = 2) -> np.ndarray:
    """Pairs (m, 2) of following nodes."""
    n = 2 * per_leg
    return np.array([(k, k + s) for s in range(1, reach + 1) for k in range(n - s)])


def opposite(per_leg: int = 30, every: int = 1) -> np.ndarray:
    """Pairs (m, 2) of nodes of the two legs that stand before the same piece of hull; the turn's
    four are neighbours.
    """
    k = np.arange(0, per_leg - 2, every)
    return np.column_stack([k, 2 * per_leg - 1 - k])


def link(
    dive: LinkedDive,
    pairs: np.ndarray,
    rng: np.random.Generator,
    *,
    scaled: bool = True,
    bottom: np.ndarray | bool = False,
) -> CameraLinks:
    """The relative poses of pairs (m, 2), with noise of LINK_SIGMA times the root of how many links
    share each image; without scale, the translation's length is one metre.
    """
    camera = dive.cameras(bottom)
    first, second = pairs.T
    relative = np.linalg.inv(camera[second]) @ camera[first]
    degree = np.bincount(pairs.ravel(), minlength=len(camera))
    shared = np.maximum((degree[first] + degree[second]) / 4, 1.0)
    noise = np.sqrt(shared)[:, None] * LINK_SIGMA * rng.standard_normal((len(pairs), 6))
    turn = Rotation.from_matrix(relative[:, :3, :3]) * Rotation.from_rotvec(noise[:, 3:])
    length = np.linalg.norm(relative[:, :3, 3], axis=1, keepdims=True)
    shift, sigma = relative[:, :3, 3] + noise[:, :3], np.tile(LINK_SIGMA, (len(pairs), 1))
    if not scaled:
        shift, sigma = shift / length, np.hstack([sigma[:, :3] / length, sigma[:, 3:]])
    lower = np.broadcast_to(bottom, len(camera))
    return CameraLinks(
        first=first,
        second=second,
        translation=shift,
        quaternion=turn.as_quat(),
        covariance=np.einsum("mi,ij->mij", sigma**2, np.eye(6)),
        scaled=np.full(len(pairs), scaled),
        bottom=np.column_stack([lower[first], lower[second]]),
    )


def joined(*parts: CameraLinks) -> CameraLinks:
    """Links one after the other."""
    names = ("first", "second", "translation", "quaternion", "covariance", "scaled", "bottom")
    return CameraLinks(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    )


def disturbed(
    links: CameraLinks, rows: np.ndarray, shift_m: float, turn_rad: float, rng: np.random.Generator
) -> CameraLinks:
    """Some of the links made wrong, each in another direction."""
    translation, rotation = links.translation.copy(), Rotation.from_quat(links.quaternion)
    way, axis = (rng.standard_normal((len(rows), 3)) for _ in range(2))
    translation[rows] += shift_m * way / np.linalg.norm(way, axis=1, keepdims=True)
    wrong = np.zeros((len(links), 3))
    wrong[rows] = turn_rad * axis / np.linalg.norm(axis, axis=1, keepdims=True)
    return replace(
        links,
        translation=translation,
        quaternion=(rotation * Rotation.from_rotvec(wrong)).as_quat(),
    )


def aligned_error_m(found: Poses, truth: np.ndarray) -> float:
    """Root mean square distance of positions after the best rigid alignment."""
    a, b = found.translation, truth[:, :3, 3]
    u, _, vt = np.linalg.svd((b - b.mean(0)).T @ (a - a.mean(0)))
    rotation = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return float(
        np.sqrt(np.mean(np.sum(((a - a.mean(0)) @ rotation.T - (b - b.mean(0))) ** 2, axis=1)))
    )

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The survey: legs along the hull at a constant standoff, from the top down, the vehicle facing the
steel.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, from_rpy
from hullrecon.synthetic.spec import DiveSpec, Survey
from hullrecon.synthetic.vehicle.motion import Motion, with_backlash
from hullrecon.synthetic.vehicle.rig import TRAY_ORIGIN
from hullrecon.synthetic.world.hull_patch import HullSkin
from hullrecon.typing import Array

STEP_S = 0.02
# the sonar looks that much lower than the cameras (rad), less where the bilge curves away (rad/rad)
SONAR_BELOW = (0.72, 0.42)


def leg_corners(survey: Survey, middle_m: float, top_girth_m: float) -> Array:
    """Return the corners (2 legs, 2) of the path as along, girth."""
    rows = []
    for k in range(survey.legs):
        way = 0.5 * survey.leg_length_m * (1 if k % 2 else -1)
        girth = top_girth_m - k * survey.leg_spacing_m
        rows += [(middle_m - way, girth), (middle_m + way, girth)]
    return np.array(rows)


def simulate_path(spec: DiveSpec, skin: HullSkin, corners: Array) -> Motion:
    """Return the whole motion over those corners (n, 2) of the chart."""
    from scipy.ndimage import gaussian_filter1d

    along, girth = _time_path(corners, spec.survey.speed_m_per_s)
    t = STEP_S * np.arange(len(along), dtype=float)
    point, normal = skin.follow(along, girth, width_m=0.5)
    level = _trim(spec)
    facing, out = level.apply(normal), level.apply(point)
    port = level.apply([0.0, 1.0, 0.0])
    flat = facing[:, :2] + 0.1 * port[:2]  # under a flat bottom the normal alone gives no heading
    yaw = gaussian_filter1d(
        np.unwrap(np.arctan2(-flat[:, 1], -flat[:, 0])), 0.7 / STEP_S, mode="nearest"
    )
    wobble = _wobble(spec, t)
    attitude = np.stack([wobble[:, 3], wobble[:, 4], yaw + wobble[:, 5]], axis=1)
    elevation = gaussian_filter1d(
        np.arcsin(np.clip(facing[:, 2], -0.98, 0.98)), 0.7 / STEP_S, mode="nearest"
    )
    sensor = out + spec.survey.standoff_m * facing + wobble[:, :3]
    position = sensor - Rotation.from_euler("xyz", attitude).apply(TRAY_ORIGIN)
    smooth = gaussian_filter1d(position, 0.5 / STEP_S, axis=0, mode="nearest")
    global_from_level = _start_of(smooth[0], float(attitude[0, 2]), spec.ship.draught_m)
    encoder = elevation + wobble[:, 6]
    attitude[:, 2] -= attitude[0, 2]
    hull = global_from_level @ Poses(level.as_quat()[None], np.zeros((1, 3)))
    tray = with_backlash(encoder, np.radians(spec.errors.backlash_deg))
    sonar = encoder - SONAR_BELOW[0] + SONAR_BELOW[1] * elevation
    return Motion(
        t_s=t,
        position=global_from_level.apply(smooth),
        roll_pitch_yaw=attitude,
        encoder=encoder,
        tray=tray,
        sonar_tray=sonar,
        global_from_hull=hull,
    )


def _time_path(corners: Array, speed: float) -> tuple[Array, Array]:
    """Return along and girth every STEP_S: constant speed, half as fast between legs, a rest at
    both ends, corners rounded.
    """
    from scipy.ndimage import gaussian_filter1d

    way = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    seconds = way / np.where(np.arange(len(way)) % 2, 0.5 * speed, speed)
    knots = np.concatenate(
        [[0.0], 1.0 + np.concatenate([[0.0], np.cumsum(seconds)]), [2.0 + seconds.sum()]]
    )
    t = np.arange(0, knots[-1], STEP_S)
    path = np.vstack([corners[:1], corners, corners[-1:]])
    along, girth = (np.interp(t, knots, path[:, k]) for k in (0, 1))
    return tuple(gaussian_filter1d(v, 0.6 / STEP_S, mode="nearest") for v in (along, girth))  # type: ignore[return-value]


def _trim(spec: DiveSpec) -> Rotation:
    """Return the turn from M to a level frame with z down: the ship lies a little by the head and
    to one side.
    """
    heel, trim = np.radians(spec.random("trim").uniform(-0.5, 0.5, 2))
    return Rotation.from_euler("xyz", [np.pi + heel, trim, 0.0])


def _start_of(position: Array, yaw: float, draught_m: float) -> Poses:
    """Return the pose of the level frame in g, which starts where the vehicle starts, heading its
    way; its z = 0 is the water surface.
    """
    turn = from_rpy([0.0, 0.0, 0.0], [0.0, 0.0, -yaw])
    shift = -turn.apply(position[None])[0]
    return Poses(turn.quaternion, np.array([[shift[0], shift[1], draught_m]]))


def _wobble(spec: DiveSpec, t: Array, waves: int = 7) -> Array:
    """Return (n, 7) what the controller does not hold: position (m), roll, pitch, yaw, and the
    tray's command (rad).
    """
    random = spec.random("wobble")
    size = np.array([0.012, 0.012, 0.012, *np.radians([0.9, 0.9, 1.0, 0.7])])
    rate = 2 * np.pi * random.uniform(0.03, 0.22, (waves, 7))
    phase = random.uniform(0, 2 * np.pi, (waves, 7))
    total = sum(np.sin(t[:, None] * w + p) for w, p in zip(rate, phase, strict=True))
    return np.asarray(total * size * np.sqrt(2.0 / waves))

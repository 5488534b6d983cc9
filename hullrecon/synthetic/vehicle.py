# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The vehicle of a simulated dive: where its sensors sit, and how it moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry import poses
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses, exp, from_mount, from_rpy
from hullrecon.synthetic.hull_patch import HullSkin
from hullrecon.synthetic.options import DiveSpec, Survey
from hullrecon.typing import Array

Six = tuple[float, float, float, float, float, float]

# Positions in the vehicle, m: axes of tray and sonar's servo, USBL transponder. Nominal mounts as
# in dive.toml: x y z (m), roll pitch yaw (degrees).
TRAY_ORIGIN = (0.45, 0.0, 0.10)
SONAR_ORIGIN = (0.45, 0.0, 0.25)
TRANSPONDER = (-0.3, 0.15, -0.25)
DVL_MOUNT: Six = (0.0, 0.0, 0.08, 0.0, 90.0, 0.0)
CAMERA_MOUNT: Six = (0.0, 0.0, -0.05, 90.0, 0.0, 90.0)
BOTTOM_IN_TOP: Six = (0.001, 0.1, -0.001, 0.15, -0.1, 0.12)
SONAR_MOUNT: Six = (0.0, 0.0, 0.0, 0.0, 90.0, 0.0)
SONAR_ELEVATION_DEG = 14.0
LAMP_IN_TOP = np.array([0.16, -0.26, 0.02])  # metres in camera_top
BEAMS = np.array(
    [[-0.5, 0.0, 0.75**0.5], [0.5, 0.0, 0.75**0.5], [0.0, 0.5, 0.75**0.5], [0.0, -0.5, 0.75**0.5]]
)


@dataclass(frozen=True, kw_only=True)
class TrueRig:
    """The true mounts (one pose each) and cameras."""

    tray_from_dvl: Poses
    tray_from_top: Poses
    top_from_bottom: Poses
    servo_from_sonar: Poses
    camera_top: CameraModel
    camera_bottom: CameraModel | None  # None on a mono rig


def true_rig(spec: DiveSpec) -> TrueRig:
    """Draw the true mounts: nominal ones with errors of millimetres and tenths of a degree.

    Cameras have fixed intrinsics, scaled to the image size.
    """
    random = spec.random("rig")
    width, height = spec.cameras.image_width, spec.cameras.image_height
    f = 1.03 * width
    top = CameraModel(
        width, height, f, 1.0012 * f, 0.507 * width, 0.493 * height, -0.065, 0.035, 0.0006, -0.0004
    )
    bottom = CameraModel(
        width,
        height,
        0.993 * f,
        0.9942 * f,
        0.495 * width,
        0.509 * height,
        -0.061,
        0.03,
        -0.0003,
        0.0005,
    )
    return TrueRig(
        tray_from_dvl=from_mount(DVL_MOUNT) @ _draw_misalignment(random, 0.002, 0.2),
        tray_from_top=from_mount(CAMERA_MOUNT) @ _draw_misalignment(random, 0.003, 0.25),
        top_from_bottom=from_mount(BOTTOM_IN_TOP),
        servo_from_sonar=from_mount(SONAR_MOUNT),
        camera_top=top,
        camera_bottom=bottom if spec.cameras.carried == "stereo" else None,
    )


def _draw_misalignment(random: np.random.Generator, shift_m: float, turn_deg: float) -> Poses:
    """Draw the error of a mount. shift_m, turn_deg: sigmas by axis."""
    return exp(
        np.concatenate(
            [shift_m * random.standard_normal(3), np.radians(turn_deg) * random.standard_normal(3)]
        )
    )


STEP_S = 0.02  # between samples of the path
SMOOTHED_S = 0.6  # sigma of the Gaussian that rounds the corners of the path
WAVES = 7  # sine waves of the wobble that the controller does not suppress
SETTLE_S = 0.7  # sigma in time with which heading and tray follow the hull
# How much lower than the cameras the sonar looks, rad, and by how much less per radian of the
# tray's angle, as the bilge curves away
SONAR_BELOW = (0.72, 0.42)


@dataclass(frozen=True, kw_only=True)
class Motion:
    """The path over n times."""

    t_s: Array  # (n,) since the log's start
    position: Array  # (n, 3) of the vehicle in global, m
    roll_pitch_yaw: Array  # (n, 3) rad
    encoder: Array  # (n,) angle that the tray's servo reports, rad
    tray: Array  # (n,) angle that it truly has
    sonar_tray: Array  # (n,) angle of the sonar's servo
    global_from_hull: Poses

    def vehicle(self, t_s: Array) -> Poses:
        """Place the vehicle in global at times (n,)."""
        return from_rpy(self._spline(self.position)(t_s), self._spline(self.roll_pitch_yaw)(t_s))

    def angle(self, series: Array, t_s: Array) -> Array:
        """Interpolate a servo's series at times (n,)."""
        return np.interp(t_s, self.t_s, series)

    def on_tray(
        self,
        t_s: Array,
        mount: Poses,
        origin_m: tuple[float, float, float],
        series: Array | None = None,
    ) -> Poses:
        """Compute the poses (n,) in global of a sensor that is mounted on a servo.

        Parameters
        ----------
        t_s
            Times (n,).
        mount
            servo_from_sensor, a batch of one.
        origin_m
            Position of the servo's axis in the vehicle.
        series
            Angles of the servo as in `Motion`, of the camera tray if None.
        """
        angle = self.angle(self.tray if series is None else series, t_s)
        return self.vehicle(t_s) @ poses.tray_poses(origin_m, angle) @ mount

    def rates(self, t_s: Array, half_s: float = 0.01) -> Array:
        """Compute the angular velocity (n, 3) in the vehicle, rad/s."""
        before, after = self.vehicle(t_s - half_s).rotation, self.vehicle(t_s + half_s).rotation
        return np.asarray((before.inv() * after).as_rotvec() / (2 * half_s))

    def acceleration(self, t_s: Array) -> Array:
        """Compute the acceleration (n, 3) of the vehicle in global, m/s2."""
        return np.asarray(self._spline(self.position)(t_s, 2))

    def in_hull(self, frames: Poses) -> Poses:
        """Convert poses in global to poses in the hull's frame."""
        return self.global_from_hull.inverse() @ frames

    def _spline(self, values: Array) -> Callable[..., Array]:
        """Interpolate values (n, ...) of the path's times by a cubic spline over time, s."""
        from scipy.interpolate import CubicSpline

        spline: Callable[..., Array] = CubicSpline(self.t_s, values)
        return spline


def with_backlash(command: Array, backlash: float) -> Array:
    """Compute the angle (n,) of a load that follows a command (n,) through a gear with backlash.

    The load stands still while the gear crosses the dead band, whose half width is `backlash`.
    """
    out = np.empty_like(command)
    at = float(command[0])
    for k, c in enumerate(command.tolist()):
        at = min(max(at, c - backlash), c + backlash)
        out[k] = at
    return out


def ticks(
    motion: Motion, rate_hz: float, random: np.random.Generator, first_s: float = 0.25
) -> Array:
    """Draw the times (n,) of a sensor's readings, s: even with jitter, from first_s on."""
    t = np.arange(first_s, motion.t_s[-1] - 0.2, 1 / rate_hz)
    return np.asarray(t + random.uniform(-0.01, 0.01, len(t)) / max(1.0, rate_hz / 5))


def leg_corners(survey: Survey, middle_m: float, top_girth_m: float) -> Array:
    """List the start and end of each leg as along, girth (2 legs, 2). Legs run to and fro.

    middle_m: of all legs, along the hull. top_girth_m: of the first leg. The others lie below it.
    """
    rows = []
    for k in range(survey.legs):
        half = 0.5 * survey.leg_length_m * (1 if k % 2 else -1)
        girth = top_girth_m - k * survey.leg_spacing_m
        rows += [(middle_m - half, girth), (middle_m + half, girth)]
    return np.array(rows)


def simulate_path(spec: DiveSpec, skin: HullSkin, corners: Array) -> Motion:
    """Simulate the motion of a vehicle that follows the hull along corners (n, 2) of the chart.

    It keeps the standoff and faces the hull: heading by the vehicle, elevation by the tray. What
    the controller does not suppress is added, and the backlash of the tray.
    """
    from scipy.ndimage import gaussian_filter1d

    along, girth = _time_path(corners, spec.survey.speed_m_per_s)
    t = STEP_S * np.arange(len(along), dtype=float)
    point, normal = skin.follow(along, girth, width_m=0.5)
    level = _level_from_hull(spec)
    # In the level frame, whose z points down: outward normal that is to be faced, and point on hull
    facing, on_hull = level.apply(normal), level.apply(point)
    port = level.apply([0.0, 1.0, 0.0])
    # Under a flat bottom the normal is vertical and gives no heading: add some of the port side's.
    flat = facing[:, :2] + 0.1 * port[:2]
    yaw = gaussian_filter1d(
        np.unwrap(np.arctan2(-flat[:, 1], -flat[:, 0])), SETTLE_S / STEP_S, mode="nearest"
    )
    wobble = _draw_wobble(spec, t)
    attitude = np.stack([wobble[:, 3], wobble[:, 4], yaw + wobble[:, 5]], axis=1)
    elevation = gaussian_filter1d(
        np.arcsin(np.clip(facing[:, 2], -0.98, 0.98)), SETTLE_S / STEP_S, mode="nearest"
    )
    # Where the tray's axis is to be, then the vehicle that carries it
    axis = on_hull + spec.survey.standoff_m * facing + wobble[:, :3]
    position = axis - Rotation.from_euler("xyz", attitude).apply(TRAY_ORIGIN)
    smooth = gaussian_filter1d(position, 0.5 / STEP_S, axis=0, mode="nearest")
    global_from_level = _global_from_level(smooth[0], float(attitude[0, 2]), spec.ship.draught_m)
    encoder = elevation + wobble[:, 6]
    attitude[:, 2] -= attitude[0, 2]  # the global frame has the heading of the first attitude
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
    """Sample along and girth (n,) of the path every STEP_S.

    Between legs the vehicle is half as fast, and it rests a second at both ends. corners: starts
    and ends of the legs, along and girth (k, 2), as by `leg_corners`. speed: on the legs, m/s.
    """
    from scipy.ndimage import gaussian_filter1d

    distance = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    # Every second one leads from a leg to the next
    seconds = distance / np.where(np.arange(len(distance)) % 2, 0.5 * speed, speed)
    knots = np.concatenate(
        [[0.0], 1.0 + np.concatenate([[0.0], np.cumsum(seconds)]), [2.0 + seconds.sum()]]
    )
    t = np.arange(0, knots[-1], STEP_S)
    path = np.vstack([corners[:1], corners, corners[-1:]])
    along, girth = (np.interp(t, knots, path[:, k]) for k in (0, 1))
    along, girth = (
        gaussian_filter1d(v, SMOOTHED_S / STEP_S, mode="nearest") for v in (along, girth)
    )
    return along, girth


def _level_from_hull(spec: DiveSpec) -> Rotation:
    """Draw the rotation from the hull's frame to a level one with z down, with trim and heel."""
    heel, trim = np.radians(spec.random("trim").uniform(-0.5, 0.5, 2))
    return Rotation.from_euler("xyz", [np.pi + heel, trim, 0.0])


def _global_from_level(position: Array, yaw: float, draught_m: float) -> Poses:
    """Compute global_from_level: global begins at the vehicle, with z = 0 at the water surface.

    position, yaw: of the vehicle at the start, in the level frame, whose z = 0 is at the keel.
    """
    turn = from_rpy([0.0, 0.0, 0.0], [0.0, 0.0, -yaw])
    shift = -turn.apply(position[None])[0]
    return Poses(turn.quaternion, np.array([[shift[0], shift[1], draught_m]]))


def _draw_wobble(spec: DiveSpec, t: Array) -> Array:
    """Draw the motion (n, 7) that the controller does not suppress, at times t (n,) s.

    It is a sum of sine waves, for position (3), m, attitude (3) and tray angle, rad.
    """
    random = spec.random("wobble")
    size = np.array([0.012, 0.012, 0.012, *np.radians([0.9, 0.9, 1.0, 0.7])])
    rate = 2 * np.pi * random.uniform(0.03, 0.22, (WAVES, 7))
    phase = random.uniform(0, 2 * np.pi, (WAVES, 7))
    total = sum(np.sin(t[:, None] * w + p) for w, p in zip(rate, phase, strict=True))
    return np.asarray(total * size * np.sqrt(2.0 / WAVES))

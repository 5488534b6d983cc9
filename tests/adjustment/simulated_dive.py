# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A tiny dive with truth: a vehicle on two legs before the side of an ellipsoid with a bump that no
CAD model shows and a box.

Truth is stated here in plain NumPy, with 4 x 4 matrices: it shares no geometry with what it tests.
Each record's errors are known: the DVL's scale, its mount and the heading drift, biases of roll,
pitch and depth, the tray's backlash, white noise.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import Attitude, Odometry, Returns, Trajectory
from hullrecon.rig import Rig, RigPriors

# of the CAD model, x forward, y port, z up: it curves both ways
SEMI_AXES_M = np.array([6.0, 2.5, 2.0])
BOX_M = (0.3, 0.75, 0.0, 0.3, 0.08)  # x from, to, z from, to, height
BUMP_M, BUMP_LENGTH_M = 0.02, 0.7  # the hull as it is stands out by this around (-0.7, 0.15)
CAMERA = CameraModel(640, 512, 650.0, 651.0, 322.0, 255.0, -0.05, 0.02)
JANUS = np.array(
    [[-0.5, 0, 0.75**0.5], [0.5, 0, 0.75**0.5], [0, 0.5, 0.75**0.5], [0, -0.5, 0.75**0.5]]
)
TRAY_ORIGIN_M, PRESSURE_ORIGIN_M = np.array([0.4, 0.0, 0.1]), np.array([-0.3, 0.05, -0.1])
STEP_S = 0.5  # between nodes

PIXEL_NOISE_PX, RANGE_NOISE_M, ATTITUDE_NOISE_RAD, DEPTH_NOISE_M, TRAY_NOISE_RAD = (
    0.3,
    0.004,
    5e-4,
    3e-3,
    3e-4,
)
STEP_NOISE_M, TURN_NOISE_RAD = 1.5e-3, 3e-4
# scale, drift rad/s, roll, pitch, depth m, backlash rad
NAVIGATION = np.array([0.008, 1e-3, 2e-3, -1.5e-3, 0.03, 0.008])
NAVIGATION_SIGMA = np.array([0.01, 1e-3, 3e-3, 3e-3, 0.05, 0.014])
GUESS_SIGMA = np.r_[0.3, 0.2, 0.2, np.radians([1.0, 1.0, 3.0])]
MOUNT_SIGMA = np.r_[np.full(3, 0.01), np.radians(np.full(3, 0.5))]


def matrix(translation, rotation):
    """T (n, 4, 4) of translations (n, 3) and n rotations."""
    out = np.tile(np.eye(4), (len(translation), 1, 1))
    out[:, :3, :3], out[:, :3, 3] = rotation.as_matrix(), translation
    return out


def motion(*six):
    """T (4, 4) of x, y, z in metres, roll, pitch, yaw in degrees."""
    return matrix(np.array([six[:3]]), Rotation.from_euler("xyz", [six[3:]], degrees=True))[0]


def moved(transform, points):
    """Points (n, 3) by T (4, 4) or one T a point (n, 4, 4)."""
    return np.einsum("...ij,...j->...i", transform[..., :3, :3], points) + transform[..., :3, 3]


def records_poses(transform):
    """The library's poses of T (n, 4, 4) or (4, 4)."""
    transform = transform.reshape(-1, 4, 4)
    return Poses(Rotation.from_matrix(transform[:, :3, :3]).as_quat(), transform[:, :3, 3].copy())


GLOBAL_FROM_HULL = motion(3.0, -2.0, 4.0, 180.4, -0.5, 40.0)
TRAY_FROM_DVL, TRAY_FROM_TOP = (
    motion(0.02, -0.15, 0.0, 0.0, 90.0, 0.0),
    motion(0.03, 0.05, -0.05, 90.0, 0.0, 90.0),
)
TOP_FROM_BOTTOM = motion(0.001, 0.1, 0.002, 0.2, -0.1, 0.15)


def cad_side(x, z):
    """y of the CAD model's port side."""
    a, b, c = SEMI_AXES_M
    return b * np.sqrt(np.maximum(1 - (x / a) ** 2 - (z / c) ** 2, 1e-9))


def outward(x, z):
    """Unit normals (n, 3) of the CAD model's port side."""
    n = np.stack([x, cad_side(x, z), z], -1) / SEMI_AXES_M**2
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def true_deviation(x, z):
    """Of the hull as it is from the CAD model, along the CAD model's normal, m."""
    return BUMP_M * np.exp(-((x + 0.7) ** 2 + (z - 0.15) ** 2) / (2 * BUMP_LENGTH_M**2))


def true_side(x, z):
    """y of the hull as it is: the deviation is laid along y, which lies near the normal."""
    return cad_side(x, z) + true_deviation(x, z) / outward(x, z)[..., 1]


@lru_cache
def cad_hull(spacing_m=0.1):
    """The whole ellipsoid as a mesh; its facets stand some tenths of a millimetre off."""
    along = np.linspace(0.02, np.pi - 0.02, int(np.pi * SEMI_AXES_M[0] / 2 / spacing_m))
    around = np.linspace(0, 2 * np.pi, int(2 * np.pi * SEMI_AXES_M[1] / spacing_m), endpoint=False)
    u, w = np.meshgrid(along, around, indexing="ij")
    rings = SEMI_AXES_M * np.stack([-np.cos(u), np.sin(u) * np.cos(w), np.sin(u) * np.sin(w)], -1)
    n, k = u.shape
    a = (np.arange(n - 1)[:, None] * k + np.arange(k)).ravel()
    b = (np.arange(n - 1)[:, None] * k + (np.arange(k) + 1) % k).ravel()
    faces = np.vstack([np.stack([a, b, b + k], 1), np.stack([a, b + k, a + k], 1)])
    corner = rings.reshape(-1, 3)[faces]
    inward = (
        np.einsum(
            "ni,ni->n",
            np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]),
            corner.mean(1),
        )
        < 0
    )
    faces[inward] = faces[inward][:, ::-1]
    return Mesh(rings.reshape(-1, 3), faces.astype(np.int32))


@lru_cache
def hull_chart():
    return chart_for_hull(cad_hull())


@dataclass(frozen=True, kw_only=True)
class SimulatedDive:
    """What is measured, and the truth behind it: global_from_vehicle (n, 4, 4), tray (n,) rad,
    landmark (L, 3) in g, on_hull (L,).
    """

    measured: Measurements
    global_from_vehicle: np.ndarray
    tray: np.ndarray
    landmark: np.ndarray
    on_hull: np.ndarray


def path(s, per_leg):
    """Where the vehicle is at times s (n,) counted in nodes: T_g_v (n, 4, 4), the tray's angle and
    its sense of motion (n,).
    """
    leg = (s >= per_leg - 0.5).astype(float)
    share = (s - leg * per_leg) / (per_leg - 1)
    x, z = np.where(leg > 0, 1.3 - 2.6 * share, -1.3 + 2.6 * share), np.where(leg > 0, -0.15, 0.45)
    normal = outward(x, z)
    x, z = x + 0.02 * np.sin(0.9 * s), z + 0.03 * np.sin(0.5 * s)
    origin = np.stack([x, cad_side(x, z) + 1.35 + 0.05 * np.sin(0.3 * s), z], -1)
    facing = np.array([[0, -1, 0], [-1, 0, 0], [0, 0, -1.0]])  # x_v to -y_M, z_v down
    turn = Rotation.from_euler(
        "z", -np.arctan2(normal[:, :1], normal[:, 1:2])
    ) * Rotation.from_matrix(facing)
    wobble = 0.02 * np.stack([np.sin(0.7 * s), np.sin(0.45 * s + 1), np.sin(0.35 * s + 2)], -1)
    hull_from_vehicle = matrix(origin, turn * Rotation.from_rotvec(wobble))
    tray = -np.arcsin(normal[:, 2]) + 0.08 * np.sin(0.8 * s)
    return GLOBAL_FROM_HULL @ hull_from_vehicle, tray, np.where(np.cos(0.8 * s) >= 0, 1.0, -1.0)


def simulate(*, stereo=True, cad=True, ranges=True, camera=True, per_leg=18, landmarks=500, seed=1):
    """The dive; without noise-free parts. Each part can be left out."""
    rng = np.random.default_rng(seed)
    n = 2 * per_leg
    poses, tray, sense = path(np.arange(n, dtype=float), per_leg)
    points, on_hull = _landmarks(rng, landmarks)
    points = moved(GLOBAL_FROM_HULL, points)
    logged_tray = tray + NAVIGATION[5] * sense + TRAY_NOISE_RAD * rng.standard_normal(n)
    mount_error = np.radians([0.3, -0.4, 0.2])
    odometry = _odometry(rng, poses, tray, logged_tray, mount_error)
    attitude = _attitude(rng, poses, sense)
    trajectory = _dead_reckoned(poses, odometry, logged_tray)
    tracks = _tracks(rng, poses, tray, points, stereo) if camera else None
    rig = _rig(stereo, camera, mount_error)
    measured = Measurements(
        trajectory=trajectory,
        odometry=odometry,
        returns=_returns(rng, n, per_leg) if ranges else None,
        attitude=attitude,
        tracks=tracks,
        rig=rig,
        cad_model=_cad_model(poses) if cad else None,
    )
    return SimulatedDive(
        measured=measured, global_from_vehicle=poses, tray=tray, landmark=points, on_hull=on_hull
    )


def _landmarks(rng, count):
    """In M, and whether they lie on the hull: the rest lies on the box's face."""
    x, z = rng.uniform(-1.7, 1.7, count), rng.uniform(-0.6, 0.9, count)
    x0, x1, z0, z1, height = BOX_M
    behind = (x > x0 - 0.1) & (x < x1 + 0.1) & (z > z0 - 0.1) & (z < z1 + 0.1)
    x, z = x[~behind], z[~behind]
    box_x, box_z = rng.uniform(x0, x1, count // 10), rng.uniform(z0, z1, count // 10)
    hull = np.stack([x, true_side(x, z), z], -1)
    face = np.stack([box_x, true_side(box_x, box_z), box_z], -1) + height * outward(box_x, box_z)
    return np.vstack([hull, face]), np.r_[np.ones(len(hull), bool), np.zeros(len(face), bool)]


def _tray_poses(angle):
    return matrix(np.tile(TRAY_ORIGIN_M, (len(angle), 1)), Rotation.from_euler("y", angle[:, None]))


def pixels_of(points_in_camera):
    """Pixels (n, 2) by CAMERA; NaN behind it and outside the image."""
    depth = points_in_camera[:, 2]
    x, y = (points_in_camera[:, :2] / np.where(depth > 0.05, depth, np.nan)[:, None]).T
    r2 = x * x + y * y
    radial = 1 + CAMERA.k1 * r2 + CAMERA.k2 * r2 * r2
    pixel = np.stack([CAMERA.fx * x * radial + CAMERA.cx, CAMERA.fy * y * radial + CAMERA.cy], -1)
    inside = (
        (pixel >= 0).all(1) & (pixel <= [CAMERA.width - 1, CAMERA.height - 1]).all(1) & (r2 < 1)
    )
    return np.where(inside[:, None], pixel, np.nan)


def _tracks(rng, poses, tray, points, stereo):
    top = poses @ _tray_poses(tray) @ TRAY_FROM_TOP
    landmark, node = (
        k.ravel() for k in np.meshgrid(np.arange(len(points)), np.arange(len(poses)), indexing="ij")
    )
    seen = []
    for camera in (top, top @ TOP_FROM_BOTTOM):
        pixel = pixels_of(moved(np.linalg.inv(camera)[node], points[landmark]))
        seen.append(pixel + PIXEL_NOISE_PX * rng.standard_normal(pixel.shape))
    if not stereo:
        seen[1][:] = np.nan
    keep = np.isfinite(seen[0][:, 0]) | np.isfinite(seen[1][:, 0])
    color = np.tile(np.array([90, 120, 60], np.uint8), (len(points), 1))
    return Tracks(
        landmark=landmark[keep],
        node=node[keep],
        top=seen[0][keep],
        bottom=seen[1][keep],
        response=np.full(keep.sum(), 0.02),
        color=color,
    )


def cross_matrices(v):
    out = np.zeros((len(v), 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return out - out.transpose(0, 2, 1)


def _odometry(rng, poses, tray, logged_tray, mount_error):
    """Each step as a DVL of wrong scale and mount, behind a tray of wrong angle, under a drifting
    heading, measures it.
    """
    first, second = np.arange(len(poses) - 1), np.arange(1, len(poses))
    step = np.linalg.inv(poses[first]) @ poses[second]
    t, m = step[:, :3, 3], len(first)
    up_i, up_j = poses[first, 2, :3], poses[second, 2, :3]  # g's z in either vehicle
    vehicle_from_dvl = (_tray_poses(0.5 * (tray[first] + tray[second])) @ TRAY_FROM_DVL)[:, :3, :3]
    by_navigation, by_mount, by_tray = np.zeros((m, 6, 2)), np.zeros((m, 6, 3)), np.zeros((m, 6))
    by_navigation[:, :3, 0] = t
    by_navigation[:, :3, 1], by_navigation[:, 3:, 1] = (
        0.5 * STEP_S * np.cross(up_i, t),
        STEP_S * up_j,
    )
    by_mount[:, :3] = -vehicle_from_dvl @ cross_matrices(
        np.einsum("nji,nj->ni", vehicle_from_dvl, t)
    )
    by_tray[:, :3] = np.cross([0.0, 1.0, 0.0], t)
    wrong_tray = 0.5 * ((tray - logged_tray)[first] + (tray - logged_tray)[second])
    error = by_navigation @ NAVIGATION[:2] + by_mount @ mount_error + by_tray * wrong_tray[:, None]
    error += (
        rng.standard_normal((m, 6)) * np.r_[np.full(3, STEP_NOISE_M), np.full(3, TURN_NOISE_RAD)]
    )
    turn = Rotation.from_matrix(step[:, :3, :3]) * Rotation.from_rotvec(-error[:, 3:])
    covariance = np.tile(
        np.diag(np.r_[np.full(3, STEP_NOISE_M), np.full(3, TURN_NOISE_RAD)] ** 2), (m, 1, 1)
    )
    return Odometry(
        first=first,
        second=second,
        quaternion=turn.as_quat(),
        translation=t - error[:, :3],
        covariance=covariance,
        by_navigation=by_navigation,
        by_mount=by_mount,
        by_tray=by_tray,
        from_images=np.zeros(m, bool),
    )


def _attitude(rng, poses, sense):
    n = len(poses)
    roll_pitch = Rotation.from_matrix(poses[:, :3, :3]).as_euler("xyz")[:, :2] + NAVIGATION[2:4]
    roll_pitch += ATTITUDE_NOISE_RAD * rng.standard_normal((n, 2))
    depth = (
        moved(poses, np.tile(PRESSURE_ORIGIN_M, (n, 1)))[:, 2]
        + NAVIGATION[4]
        + DEPTH_NOISE_M * rng.standard_normal(n)
    )
    sigma = np.tile([DEPTH_NOISE_M, ATTITUDE_NOISE_RAD, ATTITUDE_NOISE_RAD], (n, 1))
    return Attitude(
        node=np.arange(n),
        depth=depth,
        roll=roll_pitch[:, 0],
        pitch=roll_pitch[:, 1],
        sigma=sigma,
        nodes_per_reading=np.ones(n),
        tray_direction=sense,
        tray_sigma=np.zeros(n),
    )


def _dead_reckoned(poses, odometry, logged_tray):
    """From the first true pose, its roll, pitch and depth as sensors have them, step by step."""
    n = len(poses)
    roll, pitch, yaw = Rotation.from_matrix(poses[0, :3, :3]).as_euler("xyz")
    start = Rotation.from_euler("xyz", [[roll + NAVIGATION[2], pitch + NAVIGATION[3], yaw]])
    track = [matrix(poses[:1, :3, 3] + [0, 0, NAVIGATION[4]], start)[0]]
    for step in matrix(odometry.translation, Rotation.from_quat(odometry.quaternion)):
        track.append(track[-1] @ step)
    reckoned = records_poses(np.array(track))
    spread = (1e-3 * np.arange(1, n + 1))[:, None, None] ** 2 * np.eye(6)
    stamps = 10**18 + (STEP_S * 1e9 * np.arange(n)).astype(np.int64)
    image = np.tile(np.arange(n)[:, None], (1, 2))
    return Trajectory(
        t_ns=stamps,
        quaternion=reckoned.quaternion,
        translation=reckoned.translation,
        covariance=spread,
        tray=logged_tray,
        image=image,
    )


def cast(origin, direction):
    """Ranges (n,) of rays in M to the hull with its box: Newton's steps on y - side(x, z)."""
    x0, x1, z0, z1, height = BOX_M

    def reach(raised):
        length = np.full(len(origin), 1.0)
        for _ in range(40):
            p, q = (origin + (length + h)[:, None] * direction for h in (0.0, 1e-6))
            gap, ahead = (k[:, 1] - true_side(k[:, 0], k[:, 2]) - raised for k in (p, q))
            length = length - np.clip(gap / ((ahead - gap) / 1e-6), -0.3, 0.3)
        return length

    far, near = reach(0.0), reach(height)
    p = origin + near[:, None] * direction
    return np.where((p[:, 0] > x0) & (p[:, 0] < x1) & (p[:, 2] > z0) & (p[:, 2] < z1), near, far)


def _returns(rng, n, per_leg):
    """Four beams a ping, a ping a third of a step after each node of a leg."""
    node = np.array([k for k in range(n) if k not in (per_leg - 1, n - 1)])
    at, ping = path(node.astype(float), per_leg), path(node + 0.3, per_leg)
    offset = records_poses(np.linalg.inv(at[0]) @ ping[0])
    hull_from_dvl = np.linalg.inv(GLOBAL_FROM_HULL) @ ping[0] @ _tray_poses(ping[1]) @ TRAY_FROM_DVL
    k, beam = np.repeat(np.arange(len(node)), 4), np.tile(JANUS, (len(node), 1))
    length = cast(hull_from_dvl[k, :3, 3], np.einsum("nij,nj->ni", hull_from_dvl[k, :3, :3], beam))
    length = length + RANGE_NOISE_M * rng.standard_normal(len(k))
    stamps = 10**18 + (STEP_S * 1e9 * (node[k] + 0.3)).astype(np.int64)
    tray_offset = (ping[1] - at[1])[k]
    flagged = np.zeros(len(k), bool)
    return Returns(
        t_ns=stamps,
        node=node[k],
        quaternion=offset.quaternion[k],
        translation=offset.translation[k],
        tray_offset=tray_offset,
        beam=beam,
        range_m=length,
        flagged=flagged,
    )


def _mount(truth, error, sigma=MOUNT_SIGMA):
    """A nominal mount from which the truth differs by a shift (3,) m in the parent frame and a turn
    (3,) rad on the right, and its prior.
    """
    back = matrix(np.zeros((1, 3)), Rotation.from_rotvec([-np.asarray(error[3:])]))[0]
    nominal = truth @ back
    nominal[:3, 3] = truth[:3, 3] - error[:3]
    rows = np.diag(1 / sigma)
    rows[:3, :3] = rows[:3, :3] @ nominal[:3, :3]
    return records_poses(nominal), rows


def _rig(stereo, camera, mount_error):
    held = np.r_[np.full(3, 1e-6), MOUNT_SIGMA[3:]]
    dvl, dvl_prior = _mount(TRAY_FROM_DVL, np.r_[np.zeros(3), mount_error], held)
    top, top_prior = _mount(
        TRAY_FROM_TOP, np.r_[0.004, -0.006, 0.005, np.radians([0.3, -0.2, 0.4])]
    )
    return Rig(
        tray_origin=TRAY_ORIGIN_M,
        pressure_origin=PRESSURE_ORIGIN_M,
        tray_from_dvl=dvl,
        tray_from_top=top if camera else None,
        top_from_bottom=records_poses(TOP_FROM_BOTTOM) if stereo and camera else None,
        camera_models=dict.fromkeys(Camera if stereo else (Camera.TOP,), CAMERA) if camera else {},
        priors=RigPriors(
            tray_from_dvl=dvl_prior,
            tray_from_top=top_prior if camera else None,
            dvl_position_sigma_m=np.full(3, 0.01),
            tray_sigma_rad=0.014,
            navigation_sigma=NAVIGATION_SIGMA,
            density_sigma=0.002,
            pixel_sigma_px=1.0,
            range_sigma_m=2 * RANGE_NOISE_M,
        ),
    )


def _cad_model(poses):
    """The guess is half a sigma off, in either sense."""
    middle = moved(np.linalg.inv(GLOBAL_FROM_HULL), poses[:, :3, 3]).mean(0) - [0, 1.35, 0]
    error = GUESS_SIGMA * np.array([0.5, -0.5, 0.4, -0.5, 0.5, -0.4])
    about = matrix(middle[None], Rotation.identity(1))[0]
    wrong = matrix(error[None, :3], Rotation.from_rotvec(error[None, 3:]))[0]
    guess = records_poses(GLOBAL_FROM_HULL @ about @ wrong @ np.linalg.inv(about))
    return CadModel(cad_hull(), hull_chart(), guess, GUESS_SIGMA, 0.02, (3.0, 1.5))


def aligning(points, onto):
    """T (4, 4) that lays points (n, 3) onto others in the least squares."""
    a, b = points.mean(0), onto.mean(0)
    u, _, vt = np.linalg.svd((onto - b).T @ (points - a))
    rotation = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return matrix((b - rotation @ a)[None], Rotation.from_matrix(rotation[None]))[0]

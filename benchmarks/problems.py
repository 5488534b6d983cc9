# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Adjustment problems of the field's size (O Table 4.1) on a ship's side, with truth, started from dead reckoning.

A 180 m hull with curvature both ways is swept in legs; the vehicle looks at the side from a metre. Each landmark is seen from
two poses: mostly neighbours on a leg, one in eight from the neighbouring leg (a loop closure), as in O 4.4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from hullrecon.geometry import poses
from hullrecon.geometry.cameras import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.native import Problem

Array = NDArray[np.float64]
CAMERA = Camera(1360, 1024, 1400.0, 1400.0, 680.0, 512.0)
T_S_CT = poses.from_mount([0.0, 0.0, -0.05, 90.0, 0.0, 90.0])
T_CT_CB = poses.from_mount([0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
T_S_D = poses.from_mount([0.0, 0.0, 0.08, 0.0, 90.0, 0.0])
TRAY_ORIGIN = np.array([0.45, 0.0, 0.10])
_TILT, _AZIMUTH = np.pi / 6, np.radians([180, 0, 90, -90])
BEAMS = np.stack([np.sin(_TILT) * np.cos(_AZIMUTH), np.sin(_TILT) * np.sin(_AZIMUTH), np.full(4, np.cos(_TILT))], axis=1)


@dataclass(frozen=True)
class Size:
    """Of a problem. pairs: poses that carry images; every pose carries four beams."""

    poses: int
    imaged: int
    landmarks: int
    stereo: bool
    legs: int


SIZES = {
    "stereo": Size(24236, 22434, 243536, stereo=True, legs=40),
    "mono": Size(9249, 9249, 100597, stereo=False, legs=16),
    "small": Size(400, 400, 4000, stereo=True, legs=4),
}


def side(x: Array, depth: Array) -> Array:
    """Half-breadth y (m) of the port side at x (m from amidships, hull 180 m) and height z above the keel (hull 14 m deep)."""
    ends = 1 - 0.75 * np.abs(x / 90.0) ** 3
    section = (1 - np.clip(1 - depth / 9.0, 0, 1) ** 3) ** 0.5
    return 16.0 * ends * np.maximum(section, 0.05)


def hull_mesh(along: int = 201, girth: int = 51) -> tuple[Array, NDArray[np.int32]]:
    """20,000 triangles of the port side, outward y."""
    x, z = np.meshgrid(np.linspace(-90, 90, along), np.linspace(0.2, 14, girth), indexing="ij")
    vertices = np.stack([x, side(x, z), z], -1).reshape(-1, 3)
    n = np.arange(x.size).reshape(x.shape)
    a, b, c, d = n[:-1, :-1].ravel(), n[1:, :-1].ravel(), n[1:, 1:].ravel(), n[:-1, 1:].ravel()
    return vertices, np.vstack([np.stack([a, c, b], 1), np.stack([a, d, c], 1)]).astype(np.int32)


def _normals(x: Array, z: Array) -> Array:
    step = 1e-3
    dx = (side(x + step, z) - side(x - step, z)) / (2 * step)
    dz = (side(x, z + step) - side(x, z - step)) / (2 * step)
    normal = np.stack([-dx, np.ones_like(x), -dz], -1)
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def _path(size: Size) -> tuple[Poses, Array]:
    """T_M_v (n) a metre off the side, legs at heights from 13 to 2 m, and the tray's angle (n,) that faces the hull."""
    per_leg = int(np.ceil(size.poses / size.legs))
    number = np.arange(size.poses)
    leg, place = number // per_leg, (number % per_leg) / per_leg
    reach = 0.5 * 0.192 * per_leg
    x = reach * (2 * place - 1) * np.where(leg % 2 == 0, 1, -1)
    z = 12.5 - 0.6 * leg * (16 / max(size.legs, 16)) - 0.05 * np.sin(x / 3)
    normal = _normals(x, z)
    standoff = 1.0 + 0.05 * np.sin(x / 2 + leg)
    position = np.stack([x, side(x, z), z], 1) + standoff[:, None] * normal
    forward = np.stack([-normal[:, 0], -normal[:, 1], np.zeros(len(x))], 1)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    down = np.tile([0.0, 0, -1.0], (len(x), 1))
    frame = np.stack([forward, np.cross(down, forward), down], axis=2)
    tray = np.arctan2(-normal[:, 2], np.linalg.norm(normal[:, :2], axis=1))
    lever = TRAY_ORIGIN[None].repeat(len(x), 0)
    hull_from_vehicle = Poses(Rotation.from_matrix(frame).as_quat(), position)
    return Poses(hull_from_vehicle.quaternion, position - hull_from_vehicle.rotation.apply(lever)), tray


def make(size: Size, seed: int = 0) -> Problem:
    """The problem, started from dead reckoning."""
    rng = np.random.default_rng(seed)
    vertices, faces = hull_mesh()
    true_nodes, tray = _path(size)
    T_g_M = poses.from_rpy([3.0, 20.0, 13.0], np.radians([180.0, 0.3, 40.0]))
    nodes = T_g_M @ true_nodes
    start = _dead_reckoned(nodes, rng)
    problem = Problem(pose=np.hstack([start.translation, start.quaternion, tray[:, None] + np.radians(0.3)]))
    problem.vertices, problem.faces = vertices, faces
    _mounts(problem, T_g_M, rng)
    _navigation(problem, nodes, tray, rng)
    _ranges(problem, true_nodes, tray, rng)
    _landmarks(problem, size, nodes, true_nodes, start, tray, rng)
    problem.constant = ("T_ct_cb", "T_s_d", "intrinsics_bottom", "intrinsics_top", "navigation")
    return problem


def _seven(pose: Poses) -> Array:
    return np.r_[pose.translation[0], pose.quaternion[0]]


def _mounts(problem: Problem, T_g_M: Poses, rng: np.random.Generator) -> None:
    wrong = poses.exp(np.r_[0.3, 0.05, 0.05, 0.002, 0.002, 0.005])
    problem.T_g_M, problem.prior_T_g_M = _seven(T_g_M @ wrong), _seven(T_g_M @ wrong)
    problem.prior_T_g_M_sqrt = np.diag(1 / np.r_[1.0, 0.3, 0.3, 0.02, 0.02, 0.05])
    off = poses.exp(np.r_[0.003 * rng.standard_normal(3), 0.004 * rng.standard_normal(3)])
    problem.T_s_ct, problem.prior_T_s_ct = _seven(T_S_CT @ off), _seven(T_S_CT)
    problem.prior_T_s_ct_sqrt = np.diag(1 / np.r_[np.full(3, 0.01), np.full(3, 0.01)])
    problem.T_ct_cb, problem.T_s_d = _seven(T_CT_CB), _seven(T_S_D)
    problem.tray_origin = TRAY_ORIGIN
    problem.intrinsics_top = problem.intrinsics_bottom = CAMERA.parameters()


def _relative(nodes: Poses) -> Poses:
    return nodes[:-1].inverse() @ nodes[1:]


SIGMA_ODOMETRY = np.r_[np.full(3, 0.002), np.full(3, 0.0008)]


def _dead_reckoned(nodes: Poses, rng: np.random.Generator) -> Poses:
    """Integrated odometry with white noise, a scale error of 0.3 % and heading drift; depth, roll and pitch stay bounded."""
    step = _relative(nodes)
    noisy = Poses(step.quaternion, step.translation * 1.003 + SIGMA_ODOMETRY[0] * rng.standard_normal((len(step), 3)))
    heading = np.cumsum(np.r_[0, 2e-5 + 2e-4 * rng.standard_normal(len(step))])
    rotation = Rotation.from_euler("z", heading[:, None]) * nodes.rotation
    move = rotation[:-1].apply(noisy.translation)
    position = nodes.translation[0] + np.vstack([np.zeros(3), np.cumsum(move, 0)])
    position[:, 2] = nodes.translation[:, 2] + 0.02 * rng.standard_normal(len(nodes))
    return Poses(rotation.as_quat(), position)


def _navigation(problem: Problem, nodes: Poses, tray: Array, rng: np.random.Generator) -> None:
    n = len(nodes)
    problem.prior_pose_node = np.zeros(1, np.int32)
    problem.prior_pose = problem.pose[:1, :7].copy()
    problem.prior_pose_sqrt = np.diag(1 / np.r_[np.full(3, 1e-3), np.full(3, 1e-3)])[None]
    rpy = poses.roll_pitch_yaw(nodes.rotation)
    problem.attitude_node = np.arange(n, dtype=np.int32)
    sigma = np.r_[0.02, np.radians([0.1, 0.1])]
    truth = np.c_[nodes.translation[:, 2], rpy[:, :2]]
    problem.attitude_measured, problem.attitude_sigma = truth + sigma * rng.standard_normal((n, 3)), np.tile(sigma, (n, 1))
    problem.tray_node, problem.tray_measured = np.arange(n, dtype=np.int32), tray + np.radians(0.5) * rng.standard_normal(n)
    problem.tray_direction, problem.tray_sigma = np.zeros(n), np.full(n, np.radians(0.8))
    step = _relative(nodes) @ poses.exp(SIGMA_ODOMETRY * rng.standard_normal((n - 1, 6)))
    problem.odometry_first, problem.odometry_second = np.arange(n - 1, dtype=np.int32), np.arange(1, n, dtype=np.int32)
    problem.odometry_measured = np.hstack([step.translation, step.quaternion])
    problem.odometry_sqrt = np.tile(np.diag(1 / SIGMA_ODOMETRY), (n - 1, 1, 1))
    problem.odometry_by_navigation, problem.odometry_by_mount = np.zeros((n - 1, 6, 2)), np.zeros((n - 1, 6, 3))
    problem.odometry_by_tray, problem.odometry_tray = np.zeros((n - 1, 6)), np.zeros(n - 1)
    problem.odometry_mount = _seven(T_S_D)


def _ranges(problem: Problem, true_nodes: Poses, tray: Array, rng: np.random.Generator) -> None:
    from hullrecon.native import MeshIndex

    n = len(true_nodes)
    dvl = true_nodes @ poses.tray(TRAY_ORIGIN, tray) @ T_S_D
    node, beam = np.repeat(np.arange(n), 4), np.tile(BEAMS, (n, 1))
    at = dvl[node]
    hits = MeshIndex(problem.vertices, problem.faces).cast(at.translation, at.rotation.apply(beam))
    measured = np.where(np.isfinite(hits.range), hits.range, 1.2) + 0.01 * rng.standard_normal(4 * n)
    problem.range_node, problem.range_beam, problem.range_measured = node.astype(np.int32), beam, measured
    problem.range_offset = np.tile([0, 0, 0, 0, 0, 0, 1.0], (4 * n, 1))
    problem.range_tray_offset, problem.range_sigma = np.zeros(4 * n), np.full(4 * n, 0.01)


def _pairs(size: Size, rng: np.random.Generator) -> tuple[Array, Array]:
    """The two poses of each landmark: neighbours on a leg; one in eight reaches over to the same place of the next leg."""
    per_leg = int(np.ceil(size.poses / size.legs))
    first = np.sort(rng.integers(0, size.imaged - 1, size.landmarks))
    second = first + 1
    across = (rng.random(size.landmarks) < 0.125) & (first + per_leg < size.imaged)
    leg, place = first // per_leg, first % per_leg
    mirrored = (leg + 1) * per_leg + per_leg - 1 - place
    second = np.where(across & (mirrored < size.imaged), mirrored, second)
    return first, second


def _landmarks(
    problem: Problem, size: Size, nodes: Poses, true_nodes: Poses, start: Poses, tray: Array, rng: np.random.Generator
) -> None:
    """On the hull but for one in twenty that stands 0.05 to 0.2 m off it; pixels with 0.5 px of noise."""
    first, second = _pairs(size, rng)
    middle = 0.5 * (true_nodes.translation[first] + true_nodes.translation[second])
    x = middle[:, 0] + rng.uniform(-0.12, 0.12, size.landmarks)
    z = np.clip(middle[:, 2] + 0.1 + rng.uniform(-0.1, 0.1, size.landmarks), 0.5, 13.9)
    off = np.where(rng.random(size.landmarks) < 0.05, rng.uniform(0.05, 0.2, size.landmarks), 0.0)
    in_hull = np.stack([x, side(x, z), z], 1) + off[:, None] * _normals(x, z)
    hull = Poses(true_nodes.quaternion, true_nodes.translation)
    in_global = (nodes[:1] @ hull[:1].inverse()).apply(in_hull)
    problem.landmark = (start @ nodes.inverse())[first].apply(in_global)
    node = np.stack([first, second], 1).ravel()
    landmark = np.repeat(np.arange(size.landmarks), 2)
    top = nodes @ poses.tray(TRAY_ORIGIN, tray) @ T_S_CT
    pixels = [CAMERA.project(pose.inverse()[node].apply(in_global[landmark])) for pose in (top, top @ T_CT_CB)]
    pixels = [p + 0.5 * rng.standard_normal(p.shape) for p in pixels]
    if size.stereo:
        problem.stereo_node, problem.stereo_landmark = node.astype(np.int32), landmark.astype(np.int32)
        problem.stereo_pixel = np.hstack(pixels)
    else:
        problem.mono_node, problem.mono_landmark = node.astype(np.int32), landmark.astype(np.int32)
        problem.mono_camera, problem.mono_pixel = np.zeros(len(node), np.int32), pixels[0]
    problem.surface_landmark = np.arange(size.landmarks, dtype=np.int32)
    problem.surface_weight = np.ones(size.landmarks)

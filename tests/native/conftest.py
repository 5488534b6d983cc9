# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A small survey: vehicle over a bumpy plate, two cameras, four beams; measurements are exact
unless noise is asked.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft
from scipy.spatial.transform import Rotation

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses, exp, from_rpy, identity, tray_poses
from hullrecon.native import CadMesh, LeverArms, MeshIndex, MotionPrior, Problem, Unknowns

TOP = CameraModel(640, 480, 500, 510, 320, 240, -0.05, 0.01, 0.001, -0.002, 0.003)
BOTTOM = CameraModel(640, 480, 490, 505, 322, 238, 0.03, -0.02, -0.001, 0.001, 0.0)
TRAY_ORIGIN = np.array([0.4, 0.0, 0.1])
BEAMS = np.array(
    [[-0.5, 0, 0.75**0.5], [0.5, 0, 0.75**0.5], [0, -0.5, 0.75**0.5], [0, 0.5, 0.75**0.5]]
)


def seven(poses: Poses) -> np.ndarray:
    rows = np.hstack([poses.translation, poses.quaternion])
    return rows[0] if len(rows) == 1 else rows


def plate(n: int = 25) -> tuple[np.ndarray, np.ndarray]:
    """A bumpy plate in M, outward along +z."""
    x, y = np.meshgrid(np.linspace(-4, 4, n), np.linspace(-4, 4, n), indexing="ij")
    z = 0.3 * np.sin(1.1 * x) * np.cos(0.9 * y) + 0.04 * x * y
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n - 1), np.arange(n - 1), indexing="ij")
    a = (i * n + j).ravel()
    return vertices, np.vstack(
        [np.stack([a, a + n, a + n + 1], 1), np.stack([a, a + n + 1, a + 1], 1)]
    ).astype(np.int32)


def survey(poses: int = 8, landmarks: int = 60, seed: int = 0, pixel_noise: float = 0.0) -> Draft:
    """The true state with its measurements. The vehicle looks at the plate along its z; mounts are
    near the identity.
    """
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 2 * np.pi, poses, endpoint=False)
    place = np.stack([0.5 * np.cos(t), 0.4 * np.sin(2 * t), 1.6 + 0.2 * np.sin(3 * t)], axis=1)
    vehicle = from_rpy(
        place * [1, -1, -1], np.stack([0.1 * np.sin(t), 0.1 * np.cos(t), 0.4 * t], axis=1)
    )
    theta = 0.1 * np.sin(2 * t)
    hull = from_rpy([[0.05, -0.03, 0.02]], [[np.pi, 0.02, -0.01]])
    camera, bottom = (
        exp([[0.02, -0.01, 0.0, 0.01, 0.02, 0.03]]),
        exp([[0.0, 0.1, 0.0, 0.002, -0.003, 0.001]]),
    )
    dvl = exp([[0.0, 0.02, 0.05, 0.03, -0.02, 0.01]])
    vertices, faces = plate()
    on_plate = rng.uniform([-0.5, -0.7, 2], [1.0, 0.7, 2], (landmarks, 3))
    index = MeshIndex(vertices, faces)
    on_plate[:, 2] -= index.cast(on_plate, np.tile([0.0, 0, -1], (landmarks, 1))).range
    points = hull.apply(on_plate)
    unknowns = Unknowns(
        pose=np.hstack([vehicle.translation, vehicle.quaternion, theta[:, None]]),
        landmark=points,
        T_g_M=seven(hull),
        T_s_ct=seven(camera),
        T_ct_cb=seven(bottom),
        T_s_d=seven(dvl),
        intrinsics_top=TOP.parameters(),
        intrinsics_bottom=BOTTOM.parameters(),
    )
    p = Draft(
        Problem(
            unknowns=unknowns,
            constant=(
                "T_ct_cb",
                "T_s_d",
                "navigation",
                "deviation",
                "intrinsics_top",
                "intrinsics_bottom",
            ),
            cad_mesh=CadMesh(vertices=vertices, faces=faces),
            lever_arms=LeverArms(tray=TRAY_ORIGIN, pressure=np.array([0.1, 0.02, -0.05])),
        )
    )
    p.priors.T_g_M = MotionPrior(value=p.unknowns.T_g_M.copy(), sqrt_information=np.eye(6) / 0.5)
    p.priors.T_s_ct = MotionPrior(value=p.unknowns.T_s_ct.copy(), sqrt_information=np.eye(6) / 0.02)
    p.priors.pose.node, p.priors.pose.value, p.priors.pose.sqrt_information = (
        np.zeros(1, np.int32),
        p.unknowns.pose[:1, :7].copy(),
        np.eye(6)[None] / 1e-3,
    )
    add_navigation(p, vehicle, theta)
    add_images(p, vehicle, theta, camera, bottom, rng, pixel_noise)
    add_ranges(p, vehicle, theta, dvl, hull, index)
    p.surface.landmark, p.surface.weight = (
        np.arange(landmarks, dtype=np.int32),
        np.full(landmarks, 0.1),
    )
    return p


def add_navigation(p: Draft, vehicle: Poses, theta: np.ndarray) -> None:
    n = len(vehicle)
    p.attitude.node = np.arange(n, dtype=np.int32)
    rpy = vehicle.rotation.as_euler("xyz")
    p.attitude.measured = np.stack(
        [vehicle.apply(p.lever_arms.pressure)[:, 2], rpy[:, 0], rpy[:, 1]], axis=1
    )
    p.attitude.sigma = np.tile([0.02, 0.002, 0.002], (n, 1))
    p.tray.node, p.tray.measured = np.arange(n, dtype=np.int32), theta.copy()
    p.tray.direction, p.tray.sigma = np.where(np.arange(n) % 2, 1.0, -1.0), np.full(n, 0.01)
    p.odometry.first, p.odometry.second = (
        np.arange(n - 1, dtype=np.int32),
        np.arange(1, n, dtype=np.int32),
    )
    p.odometry.measured = seven(vehicle[:-1].inverse() @ vehicle[1:]).reshape(-1, 7)
    p.odometry.sqrt_information = np.tile(np.diag([100.0] * 3 + [1000.0] * 3), (n - 1, 1, 1))
    rng = np.random.default_rng(9)
    p.odometry.by_navigation, p.odometry.by_mount = (
        rng.normal(size=(n - 1, 6, 2)),
        rng.normal(size=(n - 1, 6, 3)),
    )
    p.odometry.by_tray, p.odometry.tray = (
        rng.normal(size=(n - 1, 6)),
        0.5 * (theta[:-1] + theta[1:]),
    )
    p.odometry.mount = p.unknowns.T_s_d.copy()


def add_images(
    p: Draft,
    vehicle: Poses,
    theta: np.ndarray,
    camera: Poses,
    bottom: Poses,
    rng: np.random.Generator,
    noise: float,
) -> None:
    node, landmark, pixel = [], [], []
    for k in range(len(vehicle)):
        top = vehicle[k] @ tray_poses(TRAY_ORIGIN, theta[k]) @ camera
        in_top = top.inverse().apply(p.unknowns.landmark)
        above, below = TOP.project(in_top), BOTTOM.project(bottom.inverse().apply(in_top))
        seen = ((above > 0) & (above < [640, 480]) & (below > 0) & (below < [640, 480])).all(axis=1)
        node.append(np.full(seen.sum(), k))
        landmark.append(np.flatnonzero(seen))
        pixel.append(np.hstack([above, below])[seen])
    p.stereo.node, p.stereo.landmark = (
        np.concatenate(x).astype(np.int32) for x in (node, landmark)
    )
    p.stereo.pixel = np.vstack(pixel) + noise * rng.normal(size=(len(p.stereo.node), 4))


def add_ranges(
    p: Draft, vehicle: Poses, theta: np.ndarray, dvl: Poses, hull: Poses, index: MeshIndex
) -> None:
    n = len(vehicle)
    node, beam = np.repeat(np.arange(n), 4), np.tile(BEAMS, (n, 1))
    offset = exp(np.tile([0.05, -0.02, 0.01, 0.01, 0.02, -0.03], (4 * n, 1)))
    tray_offset = np.full(4 * n, 0.01)
    instrument = (
        hull.inverse()
        @ vehicle[node]
        @ offset
        @ tray_poses(TRAY_ORIGIN, theta[node] + tray_offset)
        @ dvl
    )
    p.ranges.node, p.ranges.beam, p.ranges.tray_offset = node.astype(np.int32), beam, tray_offset
    p.ranges.offset = seven(offset)
    p.ranges.measured = index.cast(instrument.translation, instrument.rotation.apply(beam)).range
    assert np.isfinite(p.ranges.measured).all()
    p.ranges.sigma = np.full(4 * n, 0.01)


def shake(p: Draft, metres: float = 0.02, radians: float = 0.005, seed: int = 5) -> Draft:
    """Moves every free unknown off its place."""
    rng = np.random.default_rng(seed)
    n = len(p.unknowns.pose)
    p.unknowns.pose[:, :3] += metres * rng.normal(size=(n, 3))
    p.unknowns.pose[:, 3:7] = (
        Rotation.from_quat(p.unknowns.pose[:, 3:7])
        * Rotation.from_rotvec(radians * rng.normal(size=(n, 3)))
    ).as_quat()
    p.unknowns.pose[:, 7] += radians * rng.normal(size=n)
    p.unknowns.landmark += metres * rng.normal(size=p.unknowns.landmark.shape)
    p.unknowns.T_g_M[:3] += metres * rng.normal(size=3)
    return p


@pytest.fixture
def make_survey() -> Callable[..., Draft]:
    return survey


@pytest.fixture
def shaken() -> Callable[..., Draft]:
    return shake


@pytest.fixture
def empty() -> Callable[[int], Draft]:
    """n poses at the origin, nothing else; everything but the poses held."""

    def make(n: int) -> Draft:
        held = (
            "T_g_M",
            "T_s_ct",
            "T_ct_cb",
            "T_s_d",
            "navigation",
            "deviation",
            "intrinsics_top",
            "intrinsics_bottom",
        )
        return Draft(
            Problem(
                unknowns=Unknowns(pose=np.tile(np.append(seven(identity()), 0.0), (n, 1))),
                constant=held,
            )
        )

    return make

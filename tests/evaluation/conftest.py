# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A package small enough to work out by hand: a wall in the x-z plane that faces y > 0, 12 mm proud
of its CAD model, with one block of 0.1 m on it, and a vehicle that passes it at y = 1.5.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.records.solution import HullPose, Landmarks, Mounts, Solution
from hullrecon.records.trajectory import Returns
from hullrecon.rig import Rig, rig_from_settings

PROUD_M = 0.012
BLOCK: dict[str, Any] = {
    "id": 1,
    "kind": "box",
    "center": [1.0, PROUD_M + 0.1, 0.0],
    "normal": [0, 1, 0],
    "height": 0.1,
    "extent": [0.3, 0.3],
    "views": 9,
    "painted": False,
}
MARK = {
    **BLOCK,
    "id": 2,
    "kind": "ring",
    "center": [2.0, PROUD_M, 0.0],
    "height": 0.0,
    "painted": True,
}
LESSER = {**BLOCK, "id": 3, "kind": "lump", "center": [3.0, PROUD_M, 0.5], "height": 0.05}
FRAMES = np.arange(41)
STAMPS_NS = 1_777_887_000_000_000_000 + FRAMES * 500_000_000
PATH = np.stack([0.1 * FRAMES, 1.5 + 0 * FRAMES, 0.2 * np.sin(0.3 * FRAMES)], 1)
# x at the wall, z down
FACING = Rotation.from_matrix(np.array([[0, -1, 0], [-1, 0, 0], [0, 0, -1]], float))
CAMERA_IN_TRAY = {"translation": [0.05, 0.0, -0.05], "quaternion": [0.5, 0.5, 0.5, 0.5]}
TRAY_ORIGIN = [0.45, 0.0, 0.1]
THETA = 0.02
SHIFT = np.array([1.0, 2.0, 3.0])  # of g against M


def wall(y: float, block: bool) -> trimesh.Trimesh:
    """A 2 cm grid, x from -1 to 5, z from -1 to 1; the block's walls are one cell wide."""
    x, z = np.meshgrid(np.arange(-1, 5.001, 0.02), np.arange(-1, 1.001, 0.02), indexing="ij")
    top = (np.abs(x - 1) < 0.151) & (np.abs(z) < 0.151) & block
    node = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:])
    faces = np.concatenate(
        [np.stack([a, c, b], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)]
    )
    return trimesh.Trimesh(np.stack([x, y + 0.1 * top, z], -1).reshape(-1, 3), faces, process=False)


@pytest.fixture(scope="session")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("judged") / "wall"
    (folder / "truth").mkdir(parents=True)
    wall(0.0, False).export(folder / "hull.stl")
    wall(PROUD_M, True).export(folder / "truth" / "as_built.ply")
    (folder / "dive.toml").write_text('[hull]\nmesh = "hull.stl"\n')
    quaternion = np.tile(FACING.as_quat(), (len(FRAMES), 1))
    rows = np.column_stack([PATH, quaternion])
    lines = [
        f"{t // 10**9}.{t % 10**9:09d}," + ",".join(map(repr, r))
        for t, r in zip(STAMPS_NS.tolist(), rows.tolist(), strict=True)
    ]
    (folder / "truth" / "poses.csv").write_text("t,x,y,z,qx,qy,qz,qw\n" + "\n".join(lines) + "\n")
    (folder / "truth" / "servo.csv").write_text(f"t,rad\n1777887000,{THETA}\n1777887030,{THETA}\n")
    still = {"translation": [1.0, 2.0, 3.0], "quaternion": [0.0, 0.0, 0.0, 1.0]}
    down = {"translation": [0.0, 0.0, 0.08], "quaternion": [0.0, 0.5**0.5, 0.0, 0.5**0.5]}
    mounts = {"tray_origin": TRAY_ORIGIN, "T_s_ct": CAMERA_IN_TRAY, "T_s_d": down}
    for name, value in {
        "alignment": {"T_g_M": still},
        "extrinsics": mounts,
        "objects": {"objects": [BLOCK, MARK, LESSER], "not_objects": []},
    }.items():
        (folder / "truth" / f"{name}.json").write_text(json.dumps(value))
    return folder


@dataclass
class Deliver:
    """Writes deliverables into a folder."""

    folder: Path

    def track(
        self,
        path: np.ndarray = PATH,
        sigma: tuple[float, float, float] = (0.1, 0.1, 0.1),
        turn_deg: float = 0.0,
        turned: Rotation | None = None,
    ) -> None:
        """turned: the frame that the path is told in, from M."""
        quaternion = (
            (turned or Rotation.identity())
            * FACING
            * Rotation.from_rotvec([np.radians(turn_deg), 0, 0])
        ).as_quat()
        rows = [
            ",".join(
                [
                    "t_s",
                    "x_m",
                    "y_m",
                    "z_m",
                    "qx",
                    "qy",
                    "qz",
                    "qw",
                    "sigma_x_m",
                    "sigma_y_m",
                    "sigma_z_m",
                ]
            )
        ]
        for t, p in zip(STAMPS_NS.tolist(), path.tolist(), strict=True):
            rows.append(
                ",".join(
                    [
                        f"{t // 10**9}.{t % 10**9:09d}",
                        *map(repr, [*p, *quaternion.tolist(), *sigma]),
                    ]
                )
            )
        (self.folder / "trajectory.csv").write_text("\n".join(rows) + "\n")

    def cloud(self, name: str, points: np.ndarray, **fields: np.ndarray) -> None:
        columns = {**{axis: points[:, k].astype("<f8") for k, axis in enumerate("xyz")}, **fields}
        kinds = {"f8": "double", "f4": "float", "u1": "uchar", "i4": "int"}
        head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
        head += [f"property {kinds[v.dtype.str[1:]]} {n}" for n, v in columns.items()]
        rows = np.empty(len(points), [(n, v.dtype.str) for n, v in columns.items()])
        for n, v in columns.items():
            rows[n] = v
        (self.folder / name).write_bytes(
            "\n".join([*head, "end_header", ""]).encode() + rows.tobytes()
        )

    def objects(self, *found: dict[str, Any]) -> None:
        (self.folder / "objects.json").write_text(json.dumps({"objects": list(found)}))


@pytest.fixture
def deliver(tmp_path: Path) -> Deliver:
    (tmp_path / "deliver").mkdir()
    return Deliver(tmp_path / "deliver")


def on_wall(count: int = 400, seed: int = 0) -> np.ndarray:
    """Points of the true steel away from the block."""
    random = np.random.default_rng(seed)
    return np.column_stack(
        [random.uniform(1.5, 4.0, count), np.full(count, PROUD_M), random.uniform(-0.6, 0.6, count)]
    )


def on_block(count: int = 100, seed: int = 1) -> np.ndarray:
    random = np.random.default_rng(seed)
    return np.column_stack(
        [
            random.uniform(0.9, 1.1, count),
            np.full(count, PROUD_M + 0.1),
            random.uniform(-0.1, 0.1, count),
        ]
    )


@pytest.fixture
def wall_points() -> np.ndarray:
    return on_wall()


@pytest.fixture
def block_points() -> np.ndarray:
    return on_block()


def make_solution(landmarks: np.ndarray, label: np.ndarray, path: np.ndarray = PATH) -> Solution:
    """A solution whose g is M shifted by (1, 2, 3), as in the truth; landmarks and path in M."""
    n, m = len(FRAMES), len(landmarks)
    camera = Poses(
        np.array([CAMERA_IN_TRAY["quaternion"]]), np.array([CAMERA_IN_TRAY["translation"]])
    )
    return Solution(
        t_ns=STAMPS_NS,
        image=np.stack([FRAMES, np.full(n, -1)], 1),
        global_from_vehicle=Poses(np.tile(FACING.as_quat(), (n, 1)), path + SHIFT),
        tray=np.full(n, THETA),
        tray_sigma=np.full(n, 0.001),
        pose_covariance=np.tile(np.eye(6) * 1e-4, (n, 1, 1)),
        landmarks=Landmarks(
            position=landmarks + SHIFT,
            covariance=np.tile(np.eye(3) * 1e-6, (m, 1, 1)),
            label=label.astype(np.int64),
            deviation=landmarks[:, 1],
            views=np.full(m, 5),
            color=np.zeros((m, 3), np.uint8),
        ),
        mounts=Mounts(
            tray_from_dvl=from_mount([0, 0, 0.08, 0, 90, 0]),
            tray_from_top=camera,
            top_from_bottom=None,
        ),
        navigation_errors=np.zeros(6),
        hull_pose=HullPose(
            global_from_hull=from_mount([*SHIFT, 0, 0, 0]),
            covariance=np.eye(6),
            survey_center=np.zeros(3),
        ),
        deviation_field=None,
    )


@pytest.fixture
def solution() -> Solution:
    """The truth: landmarks on the wall labelled 1, on the block labelled 0."""
    points = np.vstack([on_wall(), on_block()])
    return make_solution(points, points[:, 1] < 0.05)


@pytest.fixture
def returns() -> Returns:
    """One beam straight ahead at each node that ends on the true steel; the last one flagged."""
    n = len(FRAMES)
    steel = np.where((np.abs(PATH[:, 0] - 1) < 0.15), PROUD_M + 0.1, PROUD_M)
    # the tray's origin is 0.45 m ahead, and the beam leans by theta: both small effects are worked
    # out, not neglected
    ahead = PATH[:, 1] - 0.45 - 0.08 * np.sin(THETA) - steel
    return Returns(
        t_ns=STAMPS_NS,
        node=np.arange(n),
        quaternion=np.tile([0.0, 0, 0, 1], (n, 1)),
        translation=np.zeros((n, 3)),
        tray_offset=np.zeros(n),
        beam=np.tile([0.0, 0, 1], (n, 1)),
        range_m=ahead / np.cos(THETA),
        flagged=np.arange(n) == n - 1,
    )


@pytest.fixture
def rig() -> Rig:
    """The rig as the truth has it, as a step reads it from dive.toml."""
    return rig_from_settings(
        {"tray.origin": tuple(TRAY_ORIGIN), "dvl.mount": (0, 0, 0.08, 0, 90, 0)}
    )

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A cylinder surveyed by DVL: the artifacts of the steps before `surface`."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.artifacts.runner import run_stage
from hullrecon.artifacts.stage import Stage, load_arrays
from hullrecon.dive.config import schema
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.solution import HullPose, Landmarks, Mounts, Solution
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Returns, Trajectory
from hullrecon.steps.chain import stage
from hullrecon.surface.options import SurfaceOptions

STAGE = stage("surface")

RADIUS, OFF = 3.0, 0.02  # a cylinder along x about (0, 3), drawn 2 cm too small
TURN = (0.0, 0.0, 0.0, 180.0, 0.0, 0.0)  # T_g_M: z down against z up
DVL_MOUNT = (0, 0, 0, 90, 0, 0)


def _hull() -> Mesh:
    x, angle = np.linspace(0, 10, 21), np.radians(np.linspace(-120, 120, 81))
    vertices = np.array([[a, RADIUS * np.sin(t), 3 - RADIUS * np.cos(t)] for a in x for t in angle])
    i, j = np.meshgrid(np.arange(20), np.arange(80), indexing="ij")
    a = (i * 81 + j).ravel()
    faces = np.concatenate([np.stack([a, a + 81, a + 82], 1), np.stack([a, a + 82, a + 1], 1)])
    center = vertices[faces].mean(axis=1) - [0, 0, 3]
    corner = vertices[faces]
    inward = (
        np.einsum(
            "ni,ni->n",
            np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) * [0, 1, 1],
            center,
        )
        < 0
    )
    faces[inward] = faces[inward][:, ::-1]
    return Mesh(vertices, faces.astype(np.int32))


def _dive(rng: np.random.Generator) -> tuple[Poses, Returns]:
    """A vehicle at port, y = 4.5 m, moving along x; beams in the dvl frame, whose z looks along -y
    of M.
    """
    n = 60
    x, z = np.tile(np.linspace(3, 7, 20), 3), np.repeat([2.4, 3.0, 3.6], 20)
    hull_from_vehicle = Poses(
        np.tile([0.0, 0, 0, 1], (n, 1)), np.column_stack([x, np.full(n, 4.5), z])
    )
    node, beams = (
        np.repeat(np.arange(n), 4),
        np.tile([[0.3, 0, 1], [-0.3, 0, 1], [0, 0.3, 1], [0, -0.3, 1.0]], (n, 1)),
    )
    beams /= np.linalg.norm(beams, axis=1, keepdims=True)
    mount = from_mount(DVL_MOUNT)
    direction = mount.rotation.apply(beams)  # in v, which here is turned like M
    start = hull_from_vehicle.translation[node] - [0, 0, 3]
    grown = RADIUS + OFF
    b, a = (start * direction)[:, 1:].sum(1), (direction[:, 1:] ** 2).sum(1)
    reach = (-b - np.sqrt(b**2 - a * ((start[:, 1:] ** 2).sum(1) - grown**2))) / a
    global_from_hull = from_mount(TURN)
    zero = np.zeros(len(node))
    returns = Returns(
        t_ns=node.astype(np.int64),
        node=node,
        quaternion=np.tile([0.0, 0, 0, 1], (len(node), 1)),
        translation=np.zeros((len(node), 3)),
        tray_offset=zero,
        beam=beams,
        range_m=reach + rng.normal(0, 0.005, len(node)),
        flagged=zero > 0,
    )
    return global_from_hull[np.zeros(n, int)] @ hull_from_vehicle, returns


def solution_of(global_from_vehicle: Poses, landmarks: np.ndarray) -> Solution:
    n, m = len(global_from_vehicle), len(landmarks)
    return Solution(
        t_ns=np.arange(n),
        image=np.full((n, 2), -1),
        global_from_vehicle=global_from_vehicle,
        tray=np.zeros(n),
        tray_sigma=np.zeros(n),
        pose_covariance=np.tile(1e-6 * np.eye(6), (n, 1, 1)),
        landmarks=Landmarks(
            position=landmarks,
            covariance=np.tile(4e-6 * np.eye(3), (m, 1, 1)),
            label=np.ones(m, np.int64),
            deviation=np.full(m, OFF),
            views=np.full(m, 4),
            color=np.zeros((m, 3), np.uint8),
        ),
        mounts=Mounts(
            tray_from_dvl=from_mount(DVL_MOUNT), tray_from_top=None, top_from_bottom=None
        ),
        navigation_errors=np.zeros(6),
        hull_pose=HullPose(
            global_from_hull=from_mount(TURN),
            covariance=1e-6 * np.eye(6),
            survey_center=np.zeros(3),
        ),
        deviation_field=None,
    )


class EarlierSteps:
    """Artifacts of the earlier steps in folders, to be spoilt by a test before `run`."""

    def __init__(self, root: Path) -> None:
        rng = np.random.default_rng(8)
        self.root, self.hull = root, _hull()
        self.global_from_vehicle, self.returns = _dive(rng)
        angle, x = np.radians(rng.uniform(75, 105, 600)), rng.uniform(3, 7, 600)
        grown = RADIUS + OFF
        marks = np.column_stack([x, grown * np.sin(angle), 3 - grown * np.cos(angle)])
        self.solution = solution_of(self.global_from_vehicle, from_mount(TURN).apply(marks))
        self.sections = {
            "tray": schema.Tray(),
            "dvl": schema.Dvl(mount=DVL_MOUNT),
            "hull": schema.Hull(mesh="hull.stl", pose=TURN),
        }

    def without_cad_model(self) -> None:
        self.sections["hull"] = None
        self.solution = replace(self.solution, hull_pose=None)

    def run(
        self, adjusted: bool = True, dvl: bool = True, stage: Stage = STAGE, **options: object
    ) -> Path:
        ingest, navigate, adjust = (self._folder(name) for name in ("ingest", "navigate", "adjust"))
        if self.sections["hull"] is not None:
            np.savez(ingest / "hull.npz", vertices=self.hull.vertices, faces=self.hull.faces)
            np.savez(adjust / "chart.npz", **chart_for_hull(self.hull).to_arrays())
        if dvl:
            np.savez(navigate / "returns.npz", **to_arrays(self.returns))
        n = len(self.global_from_vehicle)
        track = Trajectory(
            t_ns=np.arange(n), quaternion=self.global_from_vehicle.quaternion,
            translation=self.global_from_vehicle.translation,
            covariance=np.tile(1e-4 * np.eye(6), (n, 1, 1)), tray=np.zeros(n),
            image=np.full((n, 2), -1),
        )  # fmt: skip
        np.savez(navigate / "trajectory.npz", **to_arrays(track))
        np.savez(adjust / "solution.npz", **to_arrays(self.solution))
        inputs = {"ingest": ingest, "navigate": navigate} | ({"adjust": adjust} if adjusted else {})
        return run_stage(
            stage,
            {**self.sections, "surface": SurfaceOptions(**options)},
            inputs,
            self.root / "surface",
        )

    def _folder(self, name: str) -> Path:
        path = self.root / name
        path.mkdir()
        return path


@pytest.fixture
def earlier(tmp_path: Path) -> EarlierSteps:
    return EarlierSteps(tmp_path)


def read_surface(out: Path) -> tuple[Surface, dict[str, object]]:
    return from_arrays(Surface, load_arrays(out / "surface.npz")), json.loads(
        (out / "surface.json").read_text()
    )


def radius(surface: Surface) -> np.ndarray:
    return np.hypot(surface.vertices[:, 1], surface.vertices[:, 2] - 3)


def beam_ends(earlier: EarlierSteps) -> np.ndarray:
    hull_from_vehicle = (
        from_mount(TURN).inverse()[np.zeros(240, int)]
        @ earlier.global_from_vehicle[earlier.returns.node]
    )
    beam = hull_from_vehicle @ from_mount(DVL_MOUNT)
    return beam.apply(earlier.returns.beam * earlier.returns.range_m[:, None])


def bumped(earlier: EarlierSteps) -> EarlierSteps:
    """The same survey of a hull with a bump of 8 cm at (5, 3) that the CAD model lacks."""
    beam_end = beam_ends(earlier)
    bump = 0.08 * np.exp(-0.5 * ((beam_end[:, 0] - 5) ** 2 + (beam_end[:, 2] - 3) ** 2) / 0.5**2)
    earlier.returns = replace(earlier.returns, range_m=earlier.returns.range_m - bump)
    return earlier


def on_and_off_bump(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Which vertices are on top of the bump, and which beside it."""
    x, z = surface.vertices[:, 0], surface.vertices[:, 2]
    top = np.hypot(x - 5, z - 3) < 0.15
    aside = (np.hypot(x - 5, z - 3) > 1.3) & (np.abs(x - 5) < 1.8) & (np.abs(z - 3) < 0.6)
    return top, aside


def landmarks_around_bilge(earlier: EarlierSteps) -> EarlierSteps:
    """The same survey with landmarks all around the bilge: no plane faces them all."""
    angle = np.radians(np.linspace(-100, 100, 400))
    x = np.tile(np.linspace(3, 7, 20), 20)
    marks = np.column_stack([x, RADIUS * np.sin(angle), 3 - RADIUS * np.cos(angle)])
    earlier.solution = solution_of(earlier.global_from_vehicle, from_mount(TURN).apply(marks))
    return earlier

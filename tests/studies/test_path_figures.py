# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The parts of the path's figures; whole, on a dive: tests/end_to_end/test_path_figures.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.workspace import Workspace
from hullrecon.evaluation.truth import read_mesh, read_truth
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import Poses
from hullrecon.records.links import LinkedPath
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, Trajectory, VehiclePath
from hullrecon.rig import Rig
from hullrecon.studies.methods.comparison import DeadReckoning
from hullrecon.studies.paths.path_figures import draw_path_figures, lay_onto_cad_model, linked_track


@pytest.fixture
def start(solution: Solution, returns: Returns, rig: Rig) -> DeadReckoning:
    """Dead reckoning that is true."""
    poses = solution.global_from_vehicle
    reckoned = Trajectory(
        t_ns=solution.t_ns, quaternion=poses.quaternion, translation=poses.translation,
        covariance=np.zeros((len(poses), 6, 6)), tray=solution.tray, image=solution.image,
    )  # fmt: skip
    return DeadReckoning(trajectory=reckoned, returns=returns, rig=rig)


def test_a_linked_path_is_a_track_of_the_same_nodes_in_g(start: DeadReckoning) -> None:
    trajectory, n = start.trajectory, len(start.trajectory.t_ns)
    path = LinkedPath(
        pose=np.hstack([trajectory.translation + 1.0, trajectory.quaternion]),
        tray=np.full(n, 0.3),
        covariance=np.tile(np.eye(6), (n, 1, 1)),
        part=np.zeros(n, np.int64),
        part_sigma=np.zeros(1),
    )
    track = linked_track(trajectory, path)
    assert track.frame is Frame.GLOBAL
    np.testing.assert_array_equal(track.t_ns, trajectory.t_ns)
    np.testing.assert_allclose(track.poses.translation, trajectory.translation + 1.0)
    np.testing.assert_array_equal(track.sigma[:, :3], 1.0)


def test_returns_lie_on_hull_by_true_path_not_by_bent(start: DeadReckoning, package: Path) -> None:
    """The wall stands 12 mm proud of its CAD model, which its pose takes up."""
    truth = read_truth(package)
    bent = start.trajectory.track().path
    off = np.zeros((len(bent), 3))
    off[:, 1] = 0.3 * np.linspace(-1, 1, len(bent)) ** 2
    bent = VehiclePath(
        poses=Poses(bent.poses.quaternion, bent.poses.translation + off), tray=bent.tray
    )
    mesh = read_mesh(package / "hull.stl")
    distances = [
        np.abs(lay_onto_cad_model(path, start, mesh, truth.global_from_hull).distance).mean()
        for path in (start.trajectory.track().path, bent)
    ]
    assert distances[0] < 0.02
    assert distances[1] > 3 * distances[0]


def test_a_run_without_links_has_none_of_these_figures(
    start: DeadReckoning, package: Path, tmp_path: Path
) -> None:
    dive = DiveRun("wall", Chain((), {}, package), Workspace(tmp_path / "runs" / "wall"))
    nothing: Any = None
    assert draw_path_figures(dive, start, read_truth(package), nothing) == []

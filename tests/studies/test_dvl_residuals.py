# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hullrecon.evaluation.truth import read_truth
from hullrecon.geometry.poses import pose_from_vector
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, Trajectory
from hullrecon.rig import Rig
from hullrecon.studies.methods.sections import (
    adjusted_beams,
    dead_reckoned_beams,
    range_residuals,
)

SHIFT = pose_from_vector(np.array([1.0, 2, 3, 0, 0, 0, 1]))


def test_beams_end_on_the_steel(solution: Solution, returns: Returns, rig: Rig) -> None:
    points = adjusted_beams(solution, SHIFT, returns, rig).points
    assert len(points) == 40  # the flagged one is left out
    bare = points[:, 0] > 1.5
    np.testing.assert_allclose(points[bare, 1], 0.012, atol=1e-9)


def test_a_residual_is_predicted_minus_measured(
    package: Path, solution: Solution, returns: Returns, rig: Rig
) -> None:
    """The steel stands 12 mm proud of the CAD model, so the CAD model is farther than what was
    measured.
    """
    truth = read_truth(package)
    assert truth.cad_model is not None
    residuals = range_residuals(adjusted_beams(solution, SHIFT, returns, rig), truth.cad_model)
    assert np.median(residuals) == pytest.approx(0.012 / np.cos(0.02), abs=1e-5)
    assert residuals.max() == pytest.approx(0.112 / np.cos(0.02), abs=1e-5)


def test_dead_reckoning_is_placed_alike(solution: Solution, returns: Returns, rig: Rig) -> None:
    n = len(solution.t_ns)
    path = Trajectory(
        t_ns=solution.t_ns,
        quaternion=solution.global_from_vehicle.quaternion,
        translation=solution.global_from_vehicle.translation,
        covariance=np.zeros((n, 6, 6)),
        tray=solution.tray,
        image=solution.image,
    )
    before = dead_reckoned_beams(path, SHIFT, returns, rig)
    np.testing.assert_allclose(before.points, adjusted_beams(solution, SHIFT, returns, rig).points)


def test_beams_past_the_cad_model_have_no_residual(
    package: Path, solution: Solution, returns: Returns, rig: Rig
) -> None:
    truth = read_truth(package)
    assert truth.cad_model is not None
    beams = adjusted_beams(
        solution, pose_from_vector(np.array([-50.0, 2, 3, 0, 0, 0, 1])), returns, rig
    )
    assert len(range_residuals(beams, truth.cad_model)) == 0


def test_a_field_moves_the_cad_model_along_the_beam(
    package: Path, solution: Solution, returns: Returns, rig: Rig
) -> None:
    """12 mm outward all over: what was measured is then what is predicted, but for the block."""
    truth = read_truth(package)
    assert truth.cad_model is not None
    beams = adjusted_beams(solution, SHIFT, returns, rig)
    residuals = range_residuals(beams, truth.cad_model, lambda at: np.full(len(at), 0.012))
    assert np.median(np.abs(residuals)) < 1e-6
    assert residuals.max() == pytest.approx(0.1 / np.cos(0.02), abs=1e-5)

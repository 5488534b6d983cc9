# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry.poses import identity
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns
from hullrecon.rig import Rig
from hullrecon.studies.methods.method_figures import (
    METHODS,
    TABLE,
    WEIGHTINGS,
    gap_figures,
    height_figures,
    hull_frame,
    method_figures,
)


@pytest.fixture(scope="module")
def truth(package: Path) -> Truth:
    return read_truth(package)


def squashed(solution: Solution, share: float) -> Solution:
    """The landmarks of the block pressed onto the steel, leaving that share of their height."""
    position = solution.landmarks.position.copy()
    high = position[:, 1] > 2.05
    position[high, 1] = 2.012 + share * (position[high, 1] - 2.012)
    return replace(solution, landmarks=replace(solution.landmarks, position=position))


def test_the_truth_keeps_every_height_and_every_gap_closed(
    solution: Solution, returns: Returns, rig: Rig, truth: Truth
) -> None:
    figures = method_figures(solution, returns, rig, truth)
    assert figures["trajectory"]["rigid_rmse_m"] == pytest.approx(0, abs=1e-6)
    assert figures["cameras"]["similarity_rmse_m"] == pytest.approx(0, abs=1e-6)
    assert figures["cameras"]["images"] == 41
    assert figures["landmarks"]["off_recall"] == 1
    assert figures["heights"] == {
        "structures": 1,
        "ratio_median": pytest.approx(1, abs=1e-3),
        "ratio_worst": pytest.approx(1, abs=1e-3),
        "ratios": {"1": pytest.approx(1, abs=1e-3)},
    }
    assert figures["gap"]["median_m"] == pytest.approx(0, abs=2e-4)


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5])
def test_a_squashed_block_shows_in_its_ratio(
    share: float, solution: Solution, rig: Rig, truth: Truth
) -> None:
    figures = method_figures(squashed(solution, share), None, rig, truth)
    assert figures["heights"]["ratio_median"] == pytest.approx(share, abs=0.01)


def test_landmarks_off_the_dvl_surface_show_in_the_gap(
    solution: Solution, returns: Returns, rig: Rig, truth: Truth
) -> None:
    off = replace(solution.landmarks, position=np.add(solution.landmarks.position, [0, 0.03, 0]))
    figures = method_figures(replace(solution, landmarks=off), returns, rig, truth)
    assert figures["gap"]["median_m"] == pytest.approx(0.03, abs=3e-4)
    assert figures["gap"]["mean_m"] == pytest.approx(0.03, abs=3e-4)


def test_moving_the_hull_as_a_whole_squashes_nothing(solution: Solution, truth: Truth) -> None:
    points = solution.landmarks.position - [1, 2, 3]
    around = np.column_stack(
        [np.linspace(1.25, 1.4, 20), np.full(20, 0.012), np.linspace(-0.1, 0.1, 20)]
    )
    figures = height_figures(np.add(np.vstack([points, around]), [0, 0.02, 0]), truth, identity())
    assert figures["ratio_median"] == pytest.approx(1, abs=0.02)


def test_too_few_landmarks_on_top_give_no_ratio(truth: Truth) -> None:
    assert height_figures(np.array([[1.0, 0.112, 0.0], [1.01, 0.112, 0.0]]), truth, identity()) == {
        "structures": 0
    }


def test_landmarks_without_returns_nearby_have_no_gap(
    truth: Truth, wall_points: np.ndarray
) -> None:
    assert truth.cad_model is not None
    assert gap_figures(wall_points, np.add(wall_points, [20, 0, 0]), truth.cad_model) == {
        "landmarks": 0
    }
    assert gap_figures(wall_points, wall_points[:3], truth.cad_model) == {"landmarks": 0}


def test_without_cameras_only_the_track_is_scored(
    solution: Solution, rig: Rig, truth: Truth
) -> None:
    none = replace(solution.landmarks, position=np.zeros((0, 3)), label=np.zeros(0, np.int64))
    bare = replace(solution, landmarks=none)
    assert set(method_figures(bare, None, rig, truth)) == {"trajectory"}


def test_without_a_cad_model_the_true_frame_is_taken(solution: Solution, truth: Truth) -> None:
    lost = replace(solution, hull_pose=None)
    np.testing.assert_array_equal(hull_frame(lost, truth).translation[0], [1, 2, 3])


def test_every_method_is_compared_in_both_weightings() -> None:
    assert METHODS == ("naive", "geva", "maxmix")
    assert WEIGHTINGS == {"as published": True, "as weighted by us": False}
    assert all("." in name for name in TABLE)

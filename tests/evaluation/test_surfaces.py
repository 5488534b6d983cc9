# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces and landmarks against the wall of conftest.py, whose steel stands 12 mm proud of its CAD
model.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.evaluation.deliverables import PointCloud
from hullrecon.evaluation.surfaces import score_landmarks, score_surface
from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry.poses import from_mount, identity
from hullrecon.records.solution import LABEL_BOUNDARY_M


@pytest.fixture(scope="module")
def truth(package: Path) -> Truth:
    return read_truth(package)


def cloud(points: np.ndarray, **fields: np.ndarray) -> PointCloud:
    return PointCloud(points=points, fields=fields)


def test_the_true_steel_has_no_error(truth: Truth, wall_points: np.ndarray) -> None:
    figures = score_surface(cloud(wall_points), truth, identity(), 1)
    assert figures["rmse_m"] == pytest.approx(0, abs=1e-6)
    assert figures["cad_model_alone_rmse_m"] == pytest.approx(0.012, abs=1e-5)


def test_a_shift_is_an_error_until_the_alignment_takes_it_away(
    truth: Truth, wall_points: np.ndarray
) -> None:
    figures = score_surface(
        cloud(np.add(wall_points, [0, 0.02, 0])), truth, from_mount([0, -0.02, 0, 0, 0, 0]), 1
    )
    assert figures["rmse_m"] == pytest.approx(0.02, abs=1e-6)
    assert figures["aligned_rmse_m"] == pytest.approx(0, abs=1e-6)


def test_support_that_is_too_low_leaves_a_vertex_out(truth: Truth, wall_points: np.ndarray) -> None:
    support = np.r_[np.zeros(100, np.int32), np.full(300, 2, np.int32)]
    assert (
        score_surface(cloud(wall_points, support=support), truth, identity(), 1)["vertices"] == 300
    )
    assert score_surface(cloud(wall_points, support=support), truth, identity(), 3) == {
        "vertices": 0
    }


def test_sigmas_are_held_to_the_errors(truth: Truth, wall_points: np.ndarray) -> None:
    off = np.add(wall_points, [0, 0.01, 0])
    sigma = np.r_[np.full(100, 0.02), np.full(100, 0.006), np.full(200, 0.004)]
    figures = score_surface(cloud(off, sigma=sigma), truth, identity(), 1)
    assert figures["share_within_1_sigma"] == pytest.approx(0.25)
    assert figures["share_within_1.96_sigma"] == pytest.approx(0.5)


def test_sigmas_that_are_not_known_are_left_out(truth: Truth, wall_points: np.ndarray) -> None:
    sigma = np.r_[np.full(200, np.nan), np.zeros(100), np.full(100, 0.01)]
    figures = score_landmarks(cloud(wall_points, sigma=sigma), truth, identity())
    assert figures["share_within_1_sigma"] == 1


def test_landmarks_far_from_the_hull_are_counted_apart(
    truth: Truth, wall_points: np.ndarray
) -> None:
    away = np.vstack([wall_points, [[1.0, 3.0, 0.0], [2.0, 4.0, 0.0]]])
    figures = score_landmarks(cloud(away), truth, identity())
    assert figures["landmarks"] == 402
    assert figures["far_from_hull"] == 2
    assert figures["rmse_m"] == pytest.approx(0, abs=1e-6)


def test_labels_are_scored_on_both_sides_of_the_boundary(
    truth: Truth, wall_points: np.ndarray, block_points: np.ndarray
) -> None:
    points = np.vstack([wall_points, block_points])
    right = np.r_[np.ones(400), np.zeros(100)]
    figures = score_landmarks(cloud(points, label=right), truth, identity())
    assert (figures["off_cad_model"], figures["off_recall"], figures["off_precision"]) == (
        100,
        1,
        1,
    )
    wrong = score_landmarks(cloud(points, label=1 - right), truth, identity())
    assert (wrong["off_recall"], wrong["off_precision"]) == (0, 0)


def test_without_a_cad_model_labels_have_no_figure(truth: Truth, wall_points: np.ndarray) -> None:
    bare = replace(truth, cad_model=None)
    figures = score_landmarks(cloud(wall_points, label=np.ones(400)), bare, identity())
    assert "off_recall" not in figures
    assert "cad_model_alone_rmse_m" not in score_surface(cloud(wall_points), bare, identity(), 1)


def test_label_boundary_is_that_of_the_mixture() -> None:
    """The number stands once in Python and once beside the residual that it belongs to."""
    text = (Path(__file__).resolve().parents[2] / "native" / "factors" / "mixture.h").read_text()
    assert f"{LABEL_BOUNDARY_M:.5f}" in text

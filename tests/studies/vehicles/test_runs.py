# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Missions of two underwater vehicles, with submaps."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.evaluation.trajectory import rms_length
from hullrecon.studies.vehicles import remus, remus_study, sparus, sparus_study
from hullrecon.studies.vehicles.convergence import converge
from hullrecon.studies.vehicles.convergence_study import STANDOFF_RHO, first_inside
from hullrecon.studies.vehicles.joined_map import JoinedMap, Submap


@pytest.fixture(scope="module")
def survey() -> remus.Survey:
    return remus.simulate_survey(0, passes=1)


@pytest.fixture(scope="module")
def run(survey: remus.Survey) -> remus.Run:
    return remus.run_slam(survey)


@pytest.fixture(scope="module")
def frames() -> sparus.Survey:
    return sparus.simulate_survey(0, size_m=(10.0, 10.0))


@pytest.fixture(scope="module")
def seen(frames: sparus.Survey) -> sparus.Run:
    return sparus.run_slam(frames)


def submap(points: list[list[float]], end: list[float], variance: float) -> Submap:
    size = 3 * len(points) + len(end)
    return Submap(
        points=np.array(points),
        end=np.array(end),
        covariance=variance * np.eye(size),
        labels=tuple(range(len(points))),
    )


def test_a_common_landmark_corrects_where_a_submap_starts() -> None:
    whole = JoinedMap(axes=2)
    whole.join(submap([[5.0, 0.0, 1.0]], [10.0, 0.0], 0.01))
    whole.join(submap([[-4.7, 0.0, 1.0]], [3.0, 0.0], 0.01))
    # Start, landmark and its second sight are as unsure: each takes a third of the 0.3 m.
    assert whole.starts[1, 0] == pytest.approx(9.9, abs=1e-4)
    assert whole.points[:, 0] == pytest.approx([5.1], abs=1e-4)
    assert whole.start_covariance(1)[0, 0] == pytest.approx(0.01 * 2 / 3, rel=1e-3)


def test_a_submap_with_few_known_landmarks_is_not_fused() -> None:
    whole = JoinedMap(axes=2)
    whole.join(submap([[5.0, 0.0, 1.0]], [10.0, 0.0], 0.01))
    whole.join(submap([[-4.9, 0, 1], [20, 5, 1], [25, 5, 1]], [3.0, 0.0], 0.01))
    assert whole.fused == 0
    assert len(whole.points) == 4
    assert whole.starts[1].tolist() == [10.0, 0.0]


def test_remus_is_nearer_to_the_truth_than_dead_reckoning(
    survey: remus.Survey, run: remus.Run
) -> None:
    truth = survey.mission.truth[:, :2]
    reckoned = rms_length(survey.mission.dead_reckoned()[:, :2] - truth)
    assert rms_length(run.path[:, :2] - truth) < 0.5 * reckoned
    assert run.wrong_pairs + run.map.wrong_pairs == 0


def test_discrepancy_to_lbl_stays_inside_its_bound(survey: remus.Survey, run: remus.Run) -> None:
    assert remus_study.inside(survey, run).mean() >= 0.985


def test_noise_stated_too_small_leaves_the_bound(survey: remus.Survey, run: remus.Run) -> None:
    oversure = remus.run_slam(survey, state_sigmas=1 / remus_study.OVERSURE)
    good = remus_study.inside(survey, run).mean()
    assert 1 - remus_study.inside(survey, oversure).mean() > 5 * (1 - good)


def test_sparus_ends_nearer_than_dead_reckoning(frames: sparus.Survey, seen: sparus.Run) -> None:
    truth = frames.mission.truth[:, :3]
    reckoned = frames.mission.dead_reckoned(by_pressure=False)
    ends = [np.linalg.norm(path[-1] - truth[-1]) for path in (reckoned, seen.path)]
    assert ends[1] < 0.5 * ends[0]


def test_sparus_stays_inside_three_sigma(frames: sparus.Survey, seen: sparus.Run) -> None:
    assert sparus_study.inside(frames, seen) >= 0.98


def test_predicted_ellipses_shrink_as_a_landmark_is_seen_again(seen: sparus.Run) -> None:
    areas = sparus_study.areas(seen, most=5)
    assert (np.diff(areas) < 0).all()
    assert areas[-1] < 0.3 * areas[0]


def test_inverse_depth_converges_from_a_hundredth_of_the_depth() -> None:
    trials = converge(1, 100, STANDOFF_RHO)
    assert trials.converged.mean() >= 0.99
    assert first_inside(trials) >= 0.97

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Targets of several side-scan passes: paired over the passes and placed."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.association.point_sets import chi_square
from hullrecon.studies.targets.sonar_targets import (
    MAX_P_VALUE,
    Pass,
    ReadingErrors,
    Readings,
    Sigmas,
    place_targets,
    sonar_sees,
)
from hullrecon.studies.targets.sonar_targets_study import Trial, try_surveys

ERRORS = ReadingErrors(bias=np.zeros(3), covariance=np.diag([0.03, 0.03, 0.01]) ** 2)
AREA_M2 = 800.0


@pytest.fixture(scope="module")
def trial() -> Trial:
    return try_surveys(3, 10)


def passed(points: np.ndarray, offset_m: float, sigmas: Sigmas, seed: int, mount: float) -> Pass:
    rng = np.random.default_rng(seed)
    start = np.array([0.0, offset_m])
    true_start = start + sigmas.place_m * rng.standard_normal(2)
    heading = sigmas.heading_rad * rng.standard_normal()
    seen = np.array([sonar_sees(point, true_start, heading, mount) for point in points])
    seen += 0.03 * rng.standard_normal(seen.shape)
    height, pings = np.full(len(points), 0.4), np.full(len(points), 9)
    readings = Readings(along_m=seen[:, 0], range_m=seen[:, 1], height_m=height, pings=pings)
    return Pass(start=start, readings=readings)


def test_a_sonar_turned_forward_sees_a_target_early() -> None:
    # 20 m to port, mount turned back by 0.1 rad: seen when the vehicle is 2 m past it.
    along, range_m = sonar_sees(np.array([30.0, 20.0]), np.zeros(2), 0.0, 0.1)
    assert along == pytest.approx(30.0 + 20.0 * np.tan(0.1))
    assert range_m == pytest.approx(20.0 / np.cos(0.1))


def test_what_one_pass_alone_shows_is_not_confirmed() -> None:
    points = np.array([[5.0, 20.0], [15.0, 30.0]])
    fish = np.array([[10.0, 26.0]])
    first = passed(np.vstack([points, fish]), 0.0, Sigmas(), 0, 0.0)
    confirmed, alone = place_targets(
        [first, passed(points, 4.0, Sigmas(), 1, 0.0), passed(points, -4.0, Sigmas(), 2, 0.0)],
        Sigmas(),
        ERRORS,
        AREA_M2,
    )
    assert [t.passes for t in confirmed] == [3, 3]
    assert [t.passes for t in alone] == [1]


def test_passes_do_not_average_the_mount_away() -> None:
    points, sigmas = np.array([[10.0, 30.0]]), Sigmas(place_m=0.01, heading_rad=1e-4)
    # All from one side and one range: nothing tells the mount's turn from the target's place.
    passes = [passed(points, 0.0, sigmas, k, 0.0) for k in range(3)]
    confirmed, _ = place_targets(passes, sigmas, ERRORS, AREA_M2)
    along_m = np.sqrt(confirmed[0].covariance[0, 0])
    assert along_m == pytest.approx(30.0 * sigmas.mount_rad, rel=0.05)


def test_places_err_as_their_covariance_says() -> None:
    sigmas, points = Sigmas(), np.array([[5.0, 18.0], [12.0, 30.0], [20.0, 24.0]])
    chi2 = []
    for seed in range(200):
        mount = sigmas.mount_rad * np.random.default_rng(9000 + seed).standard_normal()
        passes = [
            passed(points, offset, sigmas, 10 * seed + k, mount)
            for k, offset in enumerate((0.0, 4.0, -4.0))
        ]
        for target in place_targets(passes, sigmas, ERRORS, AREA_M2)[0]:
            off = target.center[:2] - points[np.argmin(np.abs(points[:, 0] - target.center[0]))]
            chi2.append(off @ np.linalg.solve(target.covariance, off))
    # The targets of one survey share its mount: 200 independent ones hold the mean to 0.3.
    assert np.mean(chi2) == pytest.approx(2.0, abs=0.3)


def test_shoals_coincide_as_seldom_as_the_p_value_says() -> None:
    sigmas, size = Sigmas(), np.array([35.0, 23.0])
    points = np.array([[5.0, 18.0], [12.0, 30.0], [20.0, 24.0]])
    surveys, false = 200, 0
    for seed in range(surveys):
        rng = np.random.default_rng(seed)
        fish = [np.array([0.0, 15.0]) + size * rng.uniform(size=(5, 2)) for _ in range(3)]
        passes = [
            passed(np.vstack([points, fish[k]]), offset, sigmas, 10 * seed + k, 0.0)
            for k, offset in enumerate((0.0, 4.0, -4.0))
        ]
        confirmed, _ = place_targets(passes, sigmas, ERRORS, float(size.prod()))
        off = [np.linalg.norm(points - t.center[:2], axis=1).min() for t in confirmed]
        false += int(np.sum(np.array(off) > 1.0))
    assert false / surveys <= MAX_P_VALUE


def test_targets_are_confirmed_and_shoals_are_not(trial: Trial) -> None:
    assert trial.missed <= 1  # of 60
    assert trial.false <= 1  # of 60 shoals, and of what is bright or dark alone
    assert sum(t.passes == 1 for found in trial.alone for t in found) >= 50


def test_targets_lie_within_three_sigmas_of_the_truth(trial: Trial) -> None:
    assert (trial.chi2 < chi_square(0.9973, 2)).all()
    assert (np.abs(trial.height_off) < 4).all()


def test_a_row_says_that_sonar_found_it(trial: Trial) -> None:
    row = trial.confirmed[0][0].row(1)
    assert row["by"] == "sonar"
    assert row["position_sigma"] == pytest.approx(np.sqrt(np.diag(row["position_covariance"])))
    assert row["p_value"] < 0.05

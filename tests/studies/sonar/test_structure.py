# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features by range and bearing, with the servo as an unknown."""

from __future__ import annotations

import numpy as np

from hullrecon.studies.sonar.structure import (
    CASES,
    OFFSET_RAD,
    TILT_RAD,
    estimate,
    hull_distance,
    sighted,
    simulate,
)


def test_the_hull_resolves_elevation() -> None:
    survey = simulate(np.random.default_rng(1))
    off = {
        case: np.linalg.norm(estimate(survey, case).features - survey.features, axis=1)
        for case in CASES[1:]
    }
    free, held = (float(np.sqrt(np.mean(o**2))) for o in off.values())
    assert held < 0.03
    assert free > 3 * held


def test_the_servo_is_found_within_its_sigma() -> None:
    found = estimate(simulate(np.random.default_rng(2)), CASES[2])
    assert abs(found.offset - OFFSET_RAD) < 3 * found.offset_sigma
    assert found.offset_sigma < np.radians(1.0)


def test_a_point_ahead_is_seen_at_its_range_and_no_bearing() -> None:
    ahead = np.array([[0.0, 3 * np.cos(TILT_RAD), 3 * np.sin(TILT_RAD)]])
    seen, elevation = sighted(np.zeros((1, 3)), ahead, 0.0)
    np.testing.assert_allclose(seen, [[3.0, 0.0]], atol=1e-12)
    np.testing.assert_allclose(elevation, 0.0, atol=1e-12)


def test_simulated_features_lie_on_the_hull() -> None:
    survey = simulate(np.random.default_rng(0))
    np.testing.assert_allclose(hull_distance(survey.features), 0.0, atol=1e-9)

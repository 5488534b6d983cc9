# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A stereo calibration that the dive contradicts: found, freed and said; one that holds is left
alone.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from adjustment.simulated_dive import (
    NAVIGATION,
    TOP_FROM_BOTTOM,
    aligning,
    motion,
    moved,
    records_poses,
    simulate,
)
from adjustment.solved_dives import solved
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.adjustment.stereo_calibration import (
    compare_rigs,
    describe_contradiction,
    stereo_warning,
)

OPTIONS = AdjustOptions()
BASELINE = TOP_FROM_BOTTOM[:3, 3]
LENGTH_M = float(np.linalg.norm(BASELINE))


def longer(share):
    """The true rig with a longer baseline."""
    out = TOP_FROM_BOTTOM.copy()
    out[:3, 3] *= 1 + share
    return out


@lru_cache
def _adjusted(name, cad):
    dive = simulate(cad=cad)
    rig, odometry = dive.measured.rig, dive.measured.odometry
    calibrated = {
        "DVL too long": TOP_FROM_BOTTOM,
        "turned": TOP_FROM_BOTTOM @ motion(0.0, 0.0005, 0.0, 0.1, -0.06, 0.08),
        "too long": longer(0.08),
        "doubted by its package": TOP_FROM_BOTTOM @ motion(0.0, 0.0005, 0.0, 0.1, -0.06, 0.08),
        "turned, said to be known": TOP_FROM_BOTTOM @ motion(0.0, 0.0005, 0.0, 0.1, -0.06, 0.08),
        "too long, said to be known": longer(0.08),
    }[name]
    stated = {"doubted": (0.01, 0.02), "known": (1e-4, np.radians(0.01))}  # m, rad
    sigma = next((stated[word] for word in stated if word in name), None)
    rows = None if sigma is None else np.diag(1 / np.repeat(sigma, 3))
    measured = replace(
        dive.measured,
        rig=replace(rig, top_from_bottom=records_poses(calibrated)).with_priors(
            top_from_bottom=rows
        ),
    )
    if name.startswith("DVL"):
        by_navigation = odometry.by_navigation * np.r_[np.full(3, 1.08), np.ones(3)][:, None]
        odometry = replace(
            odometry, translation=1.08 * odometry.translation, by_navigation=by_navigation
        )
        measured = replace(measured, odometry=odometry)
    adjusted = adjust(measured, OPTIONS, lambda _: None)
    return dive, adjusted, summarise_adjustment(measured, adjusted, OPTIONS)


def position_rms_m(dive, outcome):
    truth, found = (
        dive.global_from_vehicle[:, :3, 3],
        outcome.solution.global_from_vehicle.translation,
    )
    return np.sqrt(np.mean(np.sum((moved(aligning(found, truth), found) - truth) ** 2, axis=1)))


@pytest.mark.parametrize(("name", "cad"), [("turned", True), ("turned, said to be known", False)])
def test_a_rig_that_was_turned_is_found_and_said(name, cad):
    dive, adjusted, outcome = _adjusted(name, cad)
    found = adjusted.state.mounts.top_from_bottom.matrix()[0]
    assert adjusted.verdict.accepted
    assert adjusted.verdict.stereo.by_images
    assert (
        np.degrees(Rotation.from_matrix(TOP_FROM_BOTTOM[:3, :3].T @ found[:3, :3]).magnitude())
        < 0.02
    )
    assert np.linalg.norm(found[:3, 3] - BASELINE) < 0.01 * LENGTH_M
    assert position_rms_m(dive, outcome) < 5e-3
    (sentence,) = [w for w in outcome.warnings if "stereo calibration does not hold" in w]
    assert "turned by 0.1" in sentence
    assert outcome.summary["stereo_contradiction"]["by_images"]
    assert outcome.summary["stereo_contradiction"]["sentence"] == sentence


@pytest.mark.parametrize(
    ("name", "cad"), [("too long", False), ("too long, said to be known", True)]
)
def test_depths_find_wrong_baseline_where_lengths_disagree(name, cad):
    _, adjusted, outcome = _adjusted(name, cad)
    assert not adjusted.verdict.stereo.by_images
    turned = 0.02 if "known" in name else 1e-3  # degrees: what is known to 0.01 may turn by so much
    found, marginal = (
        adjusted.state.mounts.top_from_bottom.matrix()[0],
        outcome.summary["navigation_sigma"]["dvl_scale"],
    )
    assert (
        np.degrees(Rotation.from_matrix(TOP_FROM_BOTTOM[:3, :3].T @ found[:3, :3]).magnitude())
        < turned
    )
    assert 1e-3 < marginal < 0.01
    assert abs(adjusted.state.navigation[0] - NAVIGATION[0]) < 2.5 * marginal
    assert abs(np.linalg.norm(found[:3, 3]) / LENGTH_M - 1) < 2.5 * marginal
    (sentence,) = [w for w in outcome.warnings if "disagree about lengths" in w]
    assert "shorter than calibrated" in sentence
    assert "by all else that was measured it is " in sentence


def test_wrong_dvl_is_not_taken_for_wrong_rig():
    dive, adjusted, outcome = _adjusted("DVL too long", True)
    assert adjusted.verdict.stereo is None
    sigma = outcome.summary["navigation_sigma"]["dvl_scale"]
    assert abs(adjusted.state.navigation[0] - (1 - 1.08 * (1 - NAVIGATION[0]))) < 2.5 * sigma < 0.01
    assert position_rms_m(dive, outcome) < 5e-3


def test_a_calibration_that_holds_stays_as_it_is():
    for cad in (True, False):
        found = solved(cad=cad)
        assert found.adjusted.verdict.stereo is None
        np.testing.assert_array_equal(
            found.adjusted.state.mounts.top_from_bottom.translation[0], BASELINE
        )
        assert "stereo_contradiction" not in found.outcome.summary
        assert not [w for w in found.outcome.warnings if "stereo" in w.lower()]


def test_a_rig_that_its_package_doubts_needs_no_finding():
    _, adjusted, outcome = _adjusted("doubted by its package", True)
    assert adjusted.verdict.stereo is None
    found = adjusted.state.mounts.top_from_bottom.matrix()[0]
    assert (
        np.degrees(Rotation.from_matrix(TOP_FROM_BOTTOM[:3, :3].T @ found[:3, :3]).magnitude())
        < 0.02
    )
    assert not [w for w in outcome.warnings if "stereo" in w.lower()]


def found_off(shift=(0.0, 0.0, 0.0), turn_deg=(0.0, 0.0, 0.0)):
    """A rig beside the true one: shift in the top camera's axes."""
    out = TOP_FROM_BOTTOM.copy()
    out[:3, 3] += shift
    out[:3, :3] = out[:3, :3] @ Rotation.from_rotvec(np.radians(turn_deg)).as_matrix()
    return records_poses(out)


SIGMA = np.diag(np.r_[np.full(3, 1e-4), np.full(3, 2e-5)]) ** 2
TRUE = records_poses(TOP_FROM_BOTTOM)


def test_what_lies_within_its_sigma_contradicts_nothing():
    assert compare_rigs(TRUE, found_off(1e-4 * np.ones(3), (2e-3, -1e-3, 1e-3)), SIGMA) is None
    along = BASELINE / LENGTH_M
    assert compare_rigs(TRUE, found_off(3e-4 * along), SIGMA) is None
    assert not compare_rigs(TRUE, found_off(4e-4 * along), SIGMA).by_images
    assert compare_rigs(TRUE, found_off(turn_deg=(0.0, 0.02, 0.0)), SIGMA).by_images


def test_what_only_the_solver_cares_for_is_not_spoken_of():
    little, much = (found_off(turn_deg=(0.0, turn, 0.0)) for turn in (0.02, 0.04))
    assert stereo_warning(compare_rigs(TRUE, little, SIGMA), TRUE, little, SIGMA) is None
    assert "turned by 0.04 degrees" in stereo_warning(
        compare_rigs(TRUE, much, SIGMA), TRUE, much, SIGMA
    )


def test_contradiction_omits_what_rounds_to_zero():
    across = np.cross(BASELINE / LENGTH_M, [1.0, 0.0, 0.0])
    said = [
        describe_contradiction(compare_rigs(TRUE, found_off(shift, turn), SIGMA))
        for shift, turn in (
            (2e-3 * across, (0, 0, 0)),
            ((0, 0, 0), (0, 0.04, 0)),
            (2e-3 * across, (0, 0.04, 0)),
        )
    ]
    assert ["mm" in sentence for sentence in said] == [True, False, True]
    assert ["degrees" in sentence for sentence in said] == [False, True, True]


@pytest.mark.parametrize(
    ("share", "word"), [(0.04, "longer"), (0.0, "the DVL is wrong"), (0.02, "nothing else tells")]
)
def test_length_warning_names_wrong_sensor_if_known(share, word):
    disagrees = compare_rigs(TRUE, records_poses(longer(0.04)), SIGMA)
    assert word in stereo_warning(disagrees, TRUE, records_poses(longer(share)), SIGMA)

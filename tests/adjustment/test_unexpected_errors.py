# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A sensor or a mount that is far off what its package allows: named, with the sign and the size
that are true.
"""

import re
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from adjustment.simulated_dive import (
    NAVIGATION,
    NAVIGATION_SIGMA,
    TOP_FROM_BOTTOM,
    TRAY_FROM_TOP,
    motion,
    records_poses,
    simulate,
)
from adjustment.solved_dives import solved
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.bundle_adjustment import adjust, solve_path_and_place
from hullrecon.adjustment.options import PRODUCT, AdjustOptions
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.adjustment.results.unexpected_errors import (
    MountFit,
    mount_warnings,
    navigation_warnings,
    scale_warning,
)
from hullrecon.adjustment.rounds import RoundSolver
from hullrecon.geometry.poses import from_mount
from hullrecon.rig import mount_prior

OPTIONS = AdjustOptions()
CERTAIN = np.diag(np.r_[1e-3, 1e-5, 1e-4, 1e-4, 0.01, 1e-3]) ** 2
SAID = ("DVL measures", "heading drifts", "Roll is off", "Pitch is off", "Depths read")


@pytest.mark.parametrize(
    ("place", "correction", "sentence"),
    [
        (0, -0.05, "The DVL measures distances 5.0 ± 0.1 % too long, 5 times dvl.scale_sigma"),
        (0, 0.05, "The DVL measures distances 5.0 ± 0.1 % too short, 5 times dvl.scale_sigma"),
        (
            1,
            -0.005,
            "The heading drifts by 1031 ± 2 degrees an hour, "
            "5 times imu.heading_drift_deg_per_hour",
        ),
        (2, 0.0175, "Roll is off by 1.00 ± 0.01 degrees, 6 times imu.bias_sigma_deg"),
        (3, -0.0175, "Pitch is off by -1.00 ± 0.01 degrees, 6 times imu.bias_sigma_deg"),
        (4, 0.3, "Depths read 0.30 ± 0.01 m too deep, 6 times pressure.bias_sigma_m"),
        (4, -0.3, "Depths read 0.30 ± 0.01 m too shallow, 6 times pressure.bias_sigma_m"),
    ],
)
def test_each_error_is_said_with_its_sign_and_what_was_allowed(place, correction, sentence):
    found = np.zeros(6)
    found[place] = correction
    (said,) = navigation_warnings(found, NAVIGATION_SIGMA, CERTAIN)
    assert said.startswith(sentence)
    assert navigation_warnings(0.6 * found, NAVIGATION_SIGMA, CERTAIN) == []
    unsure = np.diag(0.9 * NAVIGATION_SIGMA) ** 2  # so large an error in a seventh of its size
    assert navigation_warnings(found, NAVIGATION_SIGMA, unsure) == []


@pytest.mark.parametrize(("pull", "said"), [(11.0, True), (-11.0, True), (3.0, False)])
def test_a_scale_that_a_dive_hardly_knows_is_doubted_where_it_pulls(pull, said):
    """Of an eighth of the prior's variance that a dive takes away."""
    prior = NAVIGATION_SIGMA[0]
    found, left = np.zeros(6), CERTAIN.copy()
    found[0], left[0, 0] = pull * prior * np.sqrt(1 / 8), 7 / 8 * prior**2
    warned = scale_warning(found, NAVIGATION_SIGMA, left)
    assert bool(warned) == said
    if said:
        assert f"too {'short' if pull > 0 else 'long'}" in warned[0]
        assert f"{100 * 8 * abs(found[0]):.0f} ± {100 * np.sqrt(7) * prior:.0f} %" in warned[0]
    assert scale_warning(found, np.r_[np.inf, NAVIGATION_SIGMA[1:]], left) == []


def test_what_lies_within_its_sigmas_is_not_spoken_of():
    warnings = solved(cad=True).outcome.warnings
    assert not [
        w for w in warnings if any(words in w for words in (*SAID, "from where dive.toml has it"))
    ]


SIX = (0.03, 0.05, -0.05, 90.0, 0.0, 90.0)  # of the camera's mount
CAMERA, DVL = "camera.top.mount", "dvl.mount"
MOUNT = from_mount(SIX)
PRIOR = mount_prior(MOUNT, (0.01, 0.01, 0.01, 0.5, 0.5, 0.5))
KNOWN = np.diag([1e-3] * 3 + [1e-3] * 3) ** 2


def displaced(off, six=SIX):
    """Where a mount was found: moved and turned in the vehicle's axes by off (4, 4)."""
    found = motion(*six)
    found[:3, 3] += off[:3, 3]
    found[:3, :3] = off[:3, :3] @ found[:3, :3]
    return records_poses(found)


def fit(found, covariance=KNOWN):
    """The camera's mount as found."""
    return MountFit(MOUNT, PRIOR, found, covariance)


@pytest.mark.parametrize(
    ("off", "words"),
    [
        (motion(0, 0.05, 0, 0, 0, 0), "moved across by 50 ± 1 mm from"),
        (motion(0, 0, 0, 0, 2.5, 0), "turned by 2.5 ± 0.1 degrees from"),
        (
            motion(0, -0.05, 0, 0, 0, -2.5),
            "moved across by 50 ± 1 mm and turned by 2.5 ± 0.1 degrees from",
        ),
    ],
)
def test_a_mount_far_from_its_place_is_said(off, words):
    (sentence,) = mount_warnings(
        {CAMERA: fit(displaced(off)), DVL: MountFit(None, None, None, KNOWN)}, 1.0
    )
    assert words in sentence
    assert sentence.startswith("The dive fits with camera.top.mount ")
    assert ", 5 times what camera.top.mount_sigma allows" in sentence
    near = records_poses(motion(0.06, *SIX[1:5], 91.0))  # 30 mm along its axis, and a degree
    assert mount_warnings({CAMERA: fit(near)}, 1.0) == []
    assert mount_warnings({CAMERA: fit(displaced(off), 1e4 * KNOWN)}, 1.0) == []
    assert mount_warnings({CAMERA: MountFit(MOUNT, None, displaced(off), KNOWN)}, 1.0) == []


def test_a_camera_off_along_its_axis_names_its_focal_length():
    for off, way, long in ((0.08, "nearer to", "short"), (-0.08, "farther from", "long")):
        found = MOUNT @ records_poses(motion(0, 0, off, 0, 0, 0))
        (sentence,) = mount_warnings({CAMERA: fit(found)}, 1.6)
        assert f"along the camera's axis by 80 ± 1 mm, {way} the hull, 8 times" in sentence
        assert f"calibration is 5 % too {long}" in sentence


def test_two_mounts_that_are_turned_alike_point_at_the_imu():
    beside = (0.02, -0.15, 0.0, 0.0, 90.0, 0.0)
    dvl = from_mount(beside)
    prior = mount_prior(dvl, (0.01, 0.01, 0.01, 0.5, 0.5, 0.5))

    def said(camera_off, dvl_off):
        camera_found, dvl_found = (
            displaced(motion(0, 0, 0, *camera_off)),
            displaced(motion(0, 0, 0, *dvl_off), beside),
        )
        return mount_warnings(
            {DVL: MountFit(dvl, prior, dvl_found, KNOWN), CAMERA: fit(camera_found)}, 1.0
        )

    *_, alike = said((3.0, 0.1, 0.2), (2.8, 0.2, 0.0))
    assert alike.startswith(
        "dvl.mount and camera.top.mount are turned the same way, by 2.9 degrees: "
    )
    assert "(imu.mount_deg)." in alike
    *_, about_the_tray = said((0.1, -3.0, 0.2), (0.2, -2.8, 0.0))
    assert about_the_tray.endswith("(imu.mount_deg), or the zero of the tray's angles.")
    assert len(said((3.0, 0, 0), (0, 2.8, 0))) == 2
    assert len(said((3.0, 0, 0), (0.2, 0, 0))) == 1
    assert said((1.0, 0, 0), (1.0, 0, 0)) == []


@lru_cache
def _turned_camera(cad):
    """The simulated dive with its camera 1.5 degrees off, seven times what its package allows."""
    dive = simulate(cad=cad)
    off = TRAY_FROM_TOP @ motion(0, 0, 0, 0, 0, 1.5)
    prior = np.diag(1 / np.r_[np.full(3, 0.01), np.radians(np.full(3, 0.2))])
    rig = replace(dive.measured.rig, tray_from_top=records_poses(off))
    measured = replace(dive.measured, rig=rig.with_priors(tray_from_top=prior))
    adjusted = adjust(measured, OPTIONS, lambda _: None)
    return adjusted, summarise_adjustment(measured, adjusted, OPTIONS)


@pytest.mark.parametrize("cad", [True, False], ids=["CAD", "no CAD"])
def test_contradicted_mount_is_found_and_warned_of(cad):
    adjusted, outcome = _turned_camera(cad)
    found = adjusted.state.mounts.tray_from_top.rotation.inv() * Rotation.from_matrix(
        TRAY_FROM_TOP[:3, :3]
    )
    assert np.degrees(found.magnitude()[0]) < 0.15
    (mount,) = [w for w in outcome.warnings if "from where dive.toml has it" in w]
    assert "camera.top.mount turned by 1.5 ± 0.1 degrees from" in mount
    assert not [w for w in outcome.warnings if any(words in w for words in SAID)]


@pytest.mark.parametrize("cad", [True, False], ids=["CAD", "no CAD"])
def test_exceeding_heading_drift_is_found_and_warned_of(cad):
    """The dive alone knows the drift little better than a package that allows a seventh of it."""
    dive = simulate(cad=cad)
    sigma = NAVIGATION_SIGMA.copy()
    sigma[1] = NAVIGATION[1] / 7
    measured = replace(dive.measured, rig=dive.measured.rig.with_priors(navigation_sigma=sigma))
    adjusted = adjust(measured, OPTIONS, lambda _: None)
    outcome = summarise_adjustment(measured, adjusted, OPTIONS)
    (sentence,) = [w for w in outcome.warnings if any(words in w for words in SAID)]
    found, known = (float(word) for word in re.findall(r"by (-\d+) ± (\d+) degrees", sentence)[0])
    assert abs(found + np.degrees(NAVIGATION[1]) * 3600) < 2.5 * known < 100


@lru_cache
def _fast_sound(stereo, turned_deg=0.0):
    """The simulated dive, without its CAD model; its DVL was set to a speed of sound 8 % too high,
    its bottom camera is turned from its calibration.
    """
    dive = simulate(cad=False, stereo=stereo, landmarks=800)
    odometry, returns = dive.measured.odometry, dive.measured.returns
    by_navigation = odometry.by_navigation * np.r_[np.full(3, 1.08), np.ones(3)][:, None]
    odometry = replace(
        odometry, translation=1.08 * odometry.translation, by_navigation=by_navigation
    )
    measured = replace(
        dive.measured, odometry=odometry, returns=replace(returns, range_m=1.08 * returns.range_m)
    )
    if stereo:
        calibrated = records_poses(TOP_FROM_BOTTOM @ motion(0, 0, 0, turned_deg, 0, 0))
        measured = replace(measured, rig=replace(measured.rig, top_from_bottom=calibrated))
    adjusted = adjust(measured, OPTIONS, lambda _: None)
    return dive, adjusted, summarise_adjustment(measured, adjusted, OPTIONS)


def test_mono_dive_covers_wrong_speed_of_sound():
    """Velocities and ranges agree, and are wrong; depths know better."""
    _, adjusted, outcome = _fast_sound(False)
    assert adjusted.verdict.length_conflict == pytest.approx(0.08, abs=0.03)
    assert len([w for w in outcome.warnings if "contradict all else" in w]) == 1
    assert not [w for w in outcome.warnings if SAID[0] in w]
    sigma = outcome.summary["navigation_sigma"]["dvl_scale"]
    assert abs(adjusted.state.navigation[0] - (1 - 1.08 * (1 - NAVIGATION[0]))) < 2.5 * sigma < 0.08


def test_stereo_dive_finds_wrong_speed_of_sound():
    _, adjusted, outcome = _fast_sound(True)
    assert adjusted.verdict.length_conflict is None
    assert adjusted.problem.priors.navigation_sigma[0] == pytest.approx(0.07, abs=0.01)
    np.testing.assert_array_equal(
        adjusted.problem.priors.navigation_sigma[1:], NAVIGATION_SIGMA[1:]
    )
    assert len([w for w in outcome.warnings if SAID[0] in w]) == 1
    sigma = outcome.summary["navigation_sigma"]["dvl_scale"]
    assert abs(adjusted.state.navigation[0] - (1 - 1.08 * (1 - NAVIGATION[0]))) < 2.5 * sigma < 0.01


def test_turned_rig_does_not_hide_dvl_error():
    _, adjusted, outcome = _fast_sound(True, 0.2)
    assert adjusted.verdict.stereo.by_images
    assert len([w for w in outcome.warnings if "stereo calibration does not hold" in w]) == 1
    assert len([w for w in outcome.warnings if SAID[0] in w]) == 1
    sigma = outcome.summary["navigation_sigma"]["dvl_scale"]
    assert abs(adjusted.state.navigation[0] - (1 - 1.08 * (1 - NAVIGATION[0]))) < 2.5 * sigma < 0.02


@pytest.mark.parametrize(
    ("cad", "sigma_times"), [(False, 5.0), (True, 10.0)], ids=["path", "place"]
)
def test_scale_that_depths_hardly_tell_is_found(cad, sigma_times):
    """Velocities 10 % too long. Of the prior's variance depths take away an eighth, or less: then
    ranges and CAD model tell it.
    """
    dive = simulate(cad=cad, stereo=False, landmarks=150)
    odometry, attitude = dive.measured.odometry, dive.measured.attitude
    by_navigation = odometry.by_navigation * np.r_[np.full(3, 1.1), np.ones(3)][:, None]
    sigma = np.r_[0.003, NAVIGATION_SIGMA[1:]]
    measured = replace(
        dive.measured,
        odometry=replace(
            odometry, translation=1.1 * odometry.translation, by_navigation=by_navigation
        ),
        attitude=replace(attitude, sigma=attitude.sigma * np.r_[sigma_times, 1.0, 1.0]),
        rig=dive.measured.rig.with_priors(navigation_sigma=sigma),
    )
    options = AdjustOptions(rounds=2)
    solver = RoundSolver(
        calibrated=measured.rig, options=options, strategy=PRODUCT, report=lambda _: None
    )
    placed = solve_path_and_place(measured, solver)
    assert placed.verdict.accepted
    assert placed.verdict.length_conflict == pytest.approx(0.09, abs=0.03)
    true = 1 - 1.1 * (1 - NAVIGATION[0])
    assert placed.estimate.state.navigation[0] == pytest.approx(true, abs=0.02)


def test_priors_that_hold_are_left_alone():
    for cad in (True, False):
        np.testing.assert_array_equal(
            solved(cad=cad).adjusted.problem.priors.navigation_sigma, NAVIGATION_SIGMA
        )

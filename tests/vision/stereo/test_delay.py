# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from vision.scene import camera_rig

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, exp, from_rpy
from hullrecon.steps.stereo_check import delay_finding
from hullrecon.vision.stereo.delay import Delay, MatchedRays, estimate_delay, move_to_top

MODEL = CameraModel(400, 320, 350.0, 350.0, 199.0, 160.0)
RIG = camera_rig(
    MODEL,
    MODEL,
    exp([0.002, 0.1, 0.001, 0.01, -0.02, 0.01]),
    tray_from_top=from_rpy([0.0, 0.05, -0.05], np.radians([90.0, 0.0, 90.0])),
)
THERE_AND_BACK = (1.0, 1.0, 1.0, -1.0, -1.0, -1.0)
ALONG = np.array([0.3, 0.0, 0.0])  # m/s in the top camera: across the baseline


def seen_pairs(
    delay_s, courses=THERE_AND_BACK, noise_px=0.2, stamped_s=(0.0,) * 6, seed=1, vary=1.0
):
    """Matches of a rig whose bottom camera fires so much after its stamps."""
    random, out = np.random.default_rng(seed), []
    for course, stamp_s in zip(courses, stamped_s, strict=True):
        top = random.uniform([-0.4, -0.2, 1.0], [0.4, 0.3, 1.5], (150, 3))
        turn = vary * random.normal(0, 0.02, 3)
        tray_from_top = RIG.tray_from(Camera.TOP).rotation
        velocity = tray_from_top.apply(course * ALONG + vary * random.normal(0, 0.02, 3))[0]
        twist = np.r_[velocity, turn]
        mount = RIG.tray_from(Camera.BOTTOM)
        moved = mount.inverse() @ exp((delay_s + stamp_s) * twist[None]) @ mount
        bottom = (RIG.top_from_bottom @ moved).inverse().apply(top)
        noise = random.normal(0, noise_px / MODEL.fx, (2, len(top), 2))
        out.append(
            MatchedRays(
                top=top[:, :2] / top[:, 2:] + noise[0],
                bottom=bottom[:, :2] / bottom[:, 2:] + noise[1],
                twist=twist,
                stamped_s=stamp_s,
            )
        )
    return out


@pytest.mark.parametrize("delay_s", [-0.02, 0.005, 0.06])
def test_delay_is_found_within_its_sigma(delay_s):
    found = estimate_delay(RIG, seen_pairs(delay_s))
    assert found.is_significant
    assert found.early_s == pytest.approx(delay_s, abs=3 * found.sigma_s)
    assert found.sigma_s < 0.0005 + 0.02 * abs(delay_s)


def test_delay_is_that_beyond_stamps():
    stamped_s = (0.01, 0.004, 0.0, 0.007, 0.012, 0.009)
    found = estimate_delay(RIG, seen_pairs(0.02, stamped_s=stamped_s))
    assert found.early_s == pytest.approx(0.02, abs=0.001)


def test_offset_that_is_advised_heals():
    pairs = seen_pairs(0.02)
    said = delay_finding(estimate_delay(RIG, pairs), 0.1)
    added_s = said.values["offset_s"] - 0.1
    assert "states it" in said.sentence
    stated = [replace(pair, stamped_s=added_s) for pair in pairs]
    assert not estimate_delay(RIG, stated).is_significant


@pytest.mark.parametrize("seed", range(3))
def test_cameras_fired_together_have_no_delay(seed):
    assert not estimate_delay(RIG, seen_pairs(0.0, seed=seed)).is_significant


def test_rig_that_is_turned_is_no_delay():
    turn = Rotation.from_rotvec([0.0, 0.0, np.radians(0.5)])
    pose = RIG.top_from_bottom
    wrong = replace(RIG, top_from_bottom=Poses((pose.rotation * turn).as_quat(), pose.translation))
    assert not estimate_delay(wrong, seen_pairs(0.0)).is_significant


def test_at_one_velocity_rig_and_delay_are_not_told_apart():
    pairs = seen_pairs(0.02, courses=(1.0,) * 6, vary=0.0)
    assert not estimate_delay(RIG, pairs).is_significant


def test_without_known_motion_there_is_no_estimate():
    still = [replace(pair, twist=np.full(6, np.nan)) for pair in seen_pairs(0.02)]
    assert estimate_delay(RIG, still) is None


def test_moved_features_lie_where_rig_sees_them_together():
    pair, together = (seen_pairs(delay_s, noise_px=0.0)[0] for delay_s in (0.03, 0.0))
    np.testing.assert_allclose(move_to_top(RIG, pair, 0.03), together.bottom, atol=1e-5)


def test_delay_within_five_sigmas_is_not_believed():
    assert not Delay(early_s=0.02, sigma_s=0.005).is_significant
    assert Delay(early_s=0.02, sigma_s=0.003).is_significant

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated pairs of a moving stereo rig with each fault of calibration and stamps."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.records.sensors import DvlPings
from hullrecon.vision.features.extraction import no_features
from hullrecon.vision.stereo import rig_check
from hullrecon.vision.stereo.rig_check import StereoFrames, check_baseline, check_stereo_rig

COUNT = 12
PERIOD_NS = 500_000_000
STAMPS = 10**15 + PERIOD_NS * np.arange(COUNT)


@pytest.fixture
def dive(look, monkeypatch):
    """Features of a rig that moves by 8 cm from frame to frame: an 'image' is its camera and
    number.
    """
    move_past(look, monkeypatch)


def move_past(look, monkeypatch, noise_px=0.2):
    nodes = [look([0.08 * k, 0.01 * (k % 3), 0, 0, 0, 0], noise_px, seed=k) for k in range(COUNT)]

    def features(image, options):
        camera, row = image
        return getattr(nodes[row], camera.value)

    monkeypatch.setattr(rig_check, "extract", features)


def check(rig, bottom_from=0, swap=False, sigma_rad=0.0):
    """The rig against frames whose bottom camera's images are `bottom_from` places away from where
    their stamps put them.
    """
    rows = np.arange(COUNT)
    fit = rows[(rows + bottom_from >= 0) & (rows + bottom_from < COUNT)]
    frames = StereoFrames(
        pair=np.stack([fit, fit], axis=1),
        top=(STAMPS, rows),
        bottom=(STAMPS, np.roll(rows, -bottom_from)),
    )
    other = {Camera.TOP: Camera.BOTTOM, Camera.BOTTOM: Camera.TOP}
    return check_stereo_rig(
        rig, frames, lambda camera, row: (other[camera] if swap else camera, row), sigma_rad
    )


def with_rig(rig, pose):
    return replace(rig, top_from_bottom=pose)


def turned(pose, axis, deg):
    return Poses(
        (pose.rotation * Rotation.from_rotvec(np.radians(deg) * np.eye(3)[axis])).as_quat(),
        pose.translation,
    )


def test_sound_rig_raises_nothing(rig, dive):
    found = check(rig)
    assert found.problem is None
    assert found.error_px < 0.3
    np.testing.assert_allclose(found.depth_m, 1.3, atol=0.05)


@pytest.mark.parametrize("noise_px", [0.1, 0.3, 0.6])
def test_sound_rig_before_plane_raises_nothing(rig, wall, look, monkeypatch, noise_px):
    """Two motions explain the images of a plane: the other one is no evidence against the
    calibration.
    """
    wall.points[:, 2] = 1.3 + 0.001 * np.sin(50 * wall.points[:, 0])
    move_past(look, monkeypatch, noise_px)
    assert check(rig).problem is None


@pytest.mark.parametrize("deg", [1.0, -1.0])
def test_turned_rig_before_plane_is_named(rig, wall, look, monkeypatch, deg):
    wall.points[:, 2] = 1.3 + 0.001 * np.sin(50 * wall.points[:, 0])
    move_past(look, monkeypatch)
    found = check(with_rig(rig, turned(rig.top_from_bottom, 0, deg)))
    assert found.problem is not None


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("deg", [1.0, -1.0])
def test_rig_turned_by_a_degree_is_named_with_its_angle(rig, dive, axis, deg):
    problem = check(with_rig(rig, turned(rig.top_from_bottom, axis, deg))).problem
    assert "turned by 1.0 degrees" in problem.what
    assert "px from the epipolar lines" in problem.what
    assert "pose_in_top" in problem.remedy


@pytest.mark.parametrize("deg", [0.1, -0.1])
def test_what_usual_calibration_leaves_is_not_named(rig, dive, deg):
    for axis in range(3):
        assert check(with_rig(rig, turned(rig.top_from_bottom, axis, deg))).problem is None


def test_rig_that_is_said_to_be_rough_may_be_rough(rig, dive):
    rough = with_rig(rig, turned(rig.top_from_bottom, 1, 1.0))
    assert check(rough, sigma_rad=np.radians(1.0)).problem is None


def test_swapped_images_are_named(rig, dive):
    assert "swapped" in check(rig, swap=True).problem.what


def test_inverted_pose_is_named(rig, dive):
    assert "swapped" in check(with_rig(rig, rig.top_from_bottom.inverse())).problem.what


@pytest.mark.parametrize("places", [1, -1, 2])
def test_stamps_off_by_frames_are_named_with_offset_to_add(rig, dive, places):
    problem = check(rig, bottom_from=places).problem
    assert f"{abs(places)} frame" in problem.what
    assert ("earlier" if places > 0 else "later") in problem.what
    assert f"{0.5 * places:+.3f} s" in problem.remedy


def test_too_few_features_say_nothing(rig, monkeypatch):
    monkeypatch.setattr(rig_check, "extract", lambda image, options: no_features())
    assert check(rig) is None


def test_no_pairs_say_nothing(rig, dive):
    none = np.zeros(0, np.int64)
    frames = StereoFrames(pair=np.zeros((0, 2), np.int64), top=(none, none), bottom=(none, none))
    assert check_stereo_rig(rig, frames, lambda camera, row: None) is None


def pings(rig, range_m=1.3):
    """Beams straight along the top camera's axis."""
    mounted = replace(rig, tray_from_dvl=rig.tray_from(Camera.TOP))
    n = len(STAMPS)
    record = DvlPings(
        t_ns=STAMPS,
        velocity=np.zeros((n, 3)),
        velocity_sigma=np.full(n, 0.003),
        ranges=np.full((n, 1), range_m),
        beams=np.array([[0.0, 0.0, 1.0]]),
    )
    return record, mounted


def test_baseline_of_another_length_is_named_against_dvl(rig, dive):
    longer = with_rig(
        rig, Poses(rig.top_from_bottom.quaternion, 1.3 * rig.top_from_bottom.translation)
    )
    found = check(longer)
    assert found.problem is None  # the images cannot know
    problem = check_baseline(found, *pings(longer))
    assert "1.3" in problem.what
    assert "baseline of 0.130 m" in problem.what
    assert "pose_in_top" in problem.remedy


def test_right_baseline_agrees_with_dvl(rig, dive):
    assert check_baseline(check(rig), *pings(rig)) is None
    assert check_baseline(check(rig), *pings(rig, range_m=1.2)) is None


def test_dvl_that_saw_nothing_says_nothing_of_baseline(rig, dive):
    assert check_baseline(check(rig), *pings(rig, range_m=np.nan)) is None


def test_wrong_lens_is_no_pose_of_camera(rig, dive):
    """A bottom camera with the distortion of another: no turn of it brings the matches onto their
    lines.
    """
    models = dict(rig.camera_models)
    models[Camera.BOTTOM] = replace(models[Camera.BOTTOM], k1=0.4, fx=900.0)
    problem = check(replace(rig, camera_models=models)).problem
    assert problem is not None
    assert "contradict the stereo calibration" in problem.what


def test_figure_is_that_of_median_match(rig, dive):
    """Half a degree about the axis that looks ahead moves a match by its distance from the middle
    of the image.
    """
    sound, off = check(rig), check(with_rig(rig, turned(rig.top_from_bottom, 1, 0.5)))
    assert off.error_px > 5 * sound.error_px
    assert f"{off.error_px:.1f} px" in off.problem.what

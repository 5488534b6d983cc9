# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated pairs of a moving stereo rig with each fault of calibration and stamps."""

import re
from dataclasses import replace
from datetime import datetime

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.dead_reckoning.nodes import pair_frames
from hullrecon.records.sensors import DvlPings
from hullrecon.vision.features.extraction import no_features
from hullrecon.vision.stereo import image_matcher
from hullrecon.vision.stereo.baseline_check import check_baseline, compare_distances
from hullrecon.vision.stereo.image_matcher import StereoFrames
from hullrecon.vision.stereo.rig_check import check_stereo_rig

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

    monkeypatch.setattr(image_matcher, "extract", features)


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


@pytest.mark.parametrize("early", [False, True])
def test_pairs_that_are_wrong_for_a_part_of_the_dive_are_told_from_a_wrong_rig(rig, dive, early):
    rows = np.arange(COUNT)
    slipped = np.where((rows < 6) == early, np.minimum(rows + 2, COUNT - 1), rows)

    def checked(part):
        frames = StereoFrames(
            pair=np.stack([rows, rows], axis=1)[part], top=(STAMPS, rows), bottom=(STAMPS, slipped)
        )
        return check_stereo_rig(rig, frames, lambda camera, row: (camera, row))

    problem = checked(slice(None)).problem
    assert "of 6 pairs of images, spread over the dive, fit the stereo calibration" in problem.what
    assert ("dive.from" if early else "dive.to") in problem.remedy
    (stamp,) = re.findall(r"= (\S+Z)", problem.remedy)
    kept = stamp_s(stamp) <= STAMPS / 1e9 if early else stamp_s(stamp) >= STAMPS / 1e9
    assert checked(kept).problem is None


def stamp_s(text):
    return datetime.fromisoformat(text).timestamp()


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


@pytest.mark.parametrize(("axis", "deg"), [(0, 1.0), (1, -1.0), (2, 1.0)])
def test_rig_turned_by_a_degree_is_named_with_its_angle(rig, dive, axis, deg):
    problem = check(with_rig(rig, turned(rig.top_from_bottom, axis, deg))).problem
    assert "turned by 1.0 degrees" in problem.what
    assert "px from the epipolar lines" in problem.what
    assert "pose_in_top" in problem.remedy


def test_pictures_that_stand_on_their_head_are_no_wrong_pose(rig, dive):
    problem = check(with_rig(rig, turned(rig.top_from_bottom, 2, 180.0))).problem
    assert "pictures" in problem.remedy
    assert "turned by 180.0 degrees" in problem.what
    upright = turned(turned(rig.top_from_bottom, 2, 180.0), 2, 180.0)  # as it was calibrated
    assert check(with_rig(rig, upright)).problem is None


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
    problem = check(with_rig(rig, rig.top_from_bottom.inverse())).problem
    assert problem.what.endswith("they fit with camera.bottom.pose_in_top inverted")


def test_baseline_with_signs_turned_is_named_before_plane(rig, wall, look, monkeypatch):
    """Two motions explain a plane; the one that was written with other signs is named."""
    wall.points[:, 2] = 1.3 + 0.001 * np.sin(50 * wall.points[:, 0])
    move_past(look, monkeypatch)
    pose = Poses(rig.top_from_bottom.quaternion, -rig.top_from_bottom.translation)
    problem = check(with_rig(rig, pose)).problem
    assert "behind the cameras; they fit" in problem.what
    assert "turn the signs of x, y and z" in problem.remedy


@pytest.mark.parametrize("places", [1, -1, 2])
def test_stamps_off_by_frames_are_named_with_offset_to_add(rig, dive, places):
    problem = check(rig, bottom_from=places).problem
    assert f"{abs(places)} frame" in problem.what
    assert ("earlier" if places > 0 else "later") in problem.what
    assert f"{0.5 * places:+.3f} s" in problem.remedy


def test_too_few_features_say_nothing(rig, monkeypatch):
    monkeypatch.setattr(image_matcher, "extract", lambda image, options: no_features())
    assert check(rig) is None


def test_no_pairs_say_nothing(rig, dive):
    none = np.zeros(0, np.int64)
    frames = StereoFrames(pair=np.zeros((0, 2), np.int64), top=(none, none), bottom=(none, none))
    assert check_stereo_rig(rig, frames, lambda camera, row: None) is None


def pings(rig, range_m=1.3):
    """Beams straight along the top camera's axis, and the velocity of the rig."""
    mounted = replace(rig, tray_from_dvl=rig.tray_from(Camera.TOP))
    n = len(STAMPS)
    record = DvlPings(
        t_ns=STAMPS,
        velocity=np.tile([0.16, 0.0, 0.0], (n, 1)),
        velocity_sigma=np.full(n, 0.003),
        ranges=np.full((n, 1), range_m),
        beams=np.array([[0.0, 0.0, 1.0]]),
    )
    return record, mounted


def lengths(rig, range_m=1.3):
    """The problem that depths and ways by stereo have with the DVL's."""
    dvl, mounted = pings(rig, range_m)
    rows = np.arange(COUNT)
    frames = StereoFrames(
        pair=np.stack([rows, rows], axis=1), top=(STAMPS, rows), bottom=(STAMPS, rows)
    )
    return check_baseline(
        check(rig),
        dvl,
        mounted,
        lambda: compare_distances(mounted, frames, lambda *image: image, dvl),
    )


def with_baseline(rig, factor):
    mount = rig.top_from_bottom
    return with_rig(rig, Poses(mount.quaternion, factor * mount.translation))


def with_focal_lengths(rig, factor):
    models = {
        camera: replace(model, fx=factor * model.fx, fy=factor * model.fy)
        for camera, model in rig.camera_models.items()
    }
    return replace(rig, camera_models=models)


@pytest.mark.parametrize("factor", [1.3, 0.7])
def test_baseline_of_another_length_is_named_and_corrected(rig, dive, factor):
    longer = with_baseline(rig, factor)
    assert check(longer).problem is None  # the images cannot know
    problem = lengths(longer)
    (would_be,) = re.findall(r"would have to be (0\.\d+) m", problem.what)
    assert "focal" not in problem.what
    assert "principal points" in problem.what  # nor which of the two it is
    assert problem.remedy.startswith("calibrate the two cameras again")
    assert lengths(with_baseline(longer, float(would_be) / longer.baseline_m)) is None


def test_calibration_in_air_is_no_baseline(rig, dive):
    """Depths are a third too small, the way is right: another baseline would make it wrong."""
    air = with_focal_lengths(rig, 1 / 1.333)
    problem = lengths(air)
    assert "calibrated in air" in problem.what
    assert "baseline" not in problem.what
    assert "in water" in problem.remedy
    (factor,) = re.findall(r"to be (\d\.\d+) times as long", problem.what)
    assert lengths(with_focal_lengths(air, float(factor))) is None


def test_what_cannot_be_told_apart_has_no_remedy(rig, dive):
    dvl, mounted = pings(with_baseline(rig, 1.3))
    problem = check_baseline(check(mounted), dvl, mounted, lambda: None)
    assert "baseline" in problem.what
    assert "focal lengths" in problem.what
    assert problem.remedy == ""


def test_right_baseline_agrees_with_dvl(rig, dive):
    assert lengths(rig) is None
    assert lengths(rig, range_m=1.2) is None


def test_ranges_in_millimetres_are_the_dvls_and_no_wrong_lens(rig, dive):
    problem = lengths(rig, range_m=1300.0)
    assert problem.sentence.endswith("the DVL's ranges are in mm, not in m")


def test_dvl_that_saw_nothing_says_nothing_of_baseline(rig, dive):
    assert lengths(rig, range_m=np.nan) is None


def test_remedies_of_swapped_cameras_heal(rig, dive):
    """The exchange is told from the inversion by the lenses, which differ."""
    assert check(rig, swap=True).problem.remedy.startswith("exchange the topics")
    assert check(rig).problem is None
    inverted = with_rig(rig, rig.top_from_bottom.inverse())
    assert "invert camera.bottom.pose_in_top" in check(inverted).problem.remedy
    assert check(with_rig(rig, inverted.top_from_bottom.inverse())).problem is None


@pytest.mark.parametrize("places", [1, -2])
def test_offset_that_is_advised_heals_stamps(rig, dive, places):
    rows = np.arange(COUNT)
    stamped = STAMPS - places * PERIOD_NS  # of the images that those of the top camera fit
    wrong = StereoFrames(
        pair=pair_frames(STAMPS, stamped),
        top=(STAMPS, rows),
        bottom=(stamped, rows),
    )
    problem = check_stereo_rig(rig, wrong, lambda *image: image).problem
    (offset_s,) = re.findall(r"add ([+-]\d\.\d+) s", problem.remedy)
    put_right = stamped + round(float(offset_s) * 1e9)
    right = replace(
        wrong,
        pair=pair_frames(STAMPS, put_right),
        bottom=(put_right, rows),
    )
    assert check_stereo_rig(rig, right, lambda *image: image).problem is None


@pytest.mark.parametrize("camera", Camera)
def test_a_transposed_matrix_is_no_turned_camera(rig, dive, camera):
    models = dict(rig.camera_models)
    models[camera] = replace(models[camera], cx=0.0, cy=0.0)
    problem = check(replace(rig, camera_models=models)).problem
    assert "one camera's principal point" in problem.what
    assert problem.remedy.startswith("calibrate the two cameras again")


def test_exchanged_calibrations_are_named_and_exchanging_them_heals(rig, dive):
    models = dict(rig.camera_models)
    wrong = {Camera.TOP: models[Camera.BOTTOM], Camera.BOTTOM: models[Camera.TOP]}
    problem = check(replace(rig, camera_models=wrong)).problem
    assert problem.remedy == "exchange camera.top.calibration and camera.bottom.calibration"
    assert check(replace(rig, camera_models=models)).problem is None


def test_coefficients_in_another_order_are_named(rig, dive):
    """As k1, k2, k3, p1, p2 is read where k1, k2, p1, p2, k3 is meant."""
    wrong = {
        camera: replace(lens, p1=lens.k3, p2=lens.p1, k3=lens.p2)
        for camera, lens in rig.camera_models.items()
    }
    problem = check(replace(rig, camera_models=wrong)).problem
    assert problem.remedy.startswith("write distortion_coefficients of both cameras as k1, k2, p1")


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

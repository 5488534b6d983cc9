# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses
import json
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from hullrecon.artifacts.execution.runner import run_stage
from hullrecon.dive.config.schema import CameraBottom, Cameras, CameraTop, Dvl, Pressure, Tray
from hullrecon.errors import StageError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import exp, from_mount
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import Trajectory, TrajectoryErrorModel
from hullrecon.steps.matches import STAGE
from hullrecon.vision.features.extraction import FeatureOptions, extract
from hullrecon.vision.features.store import GrowingArray
from hullrecon.vision.options import MatchOptions

CAMERA = CameraModel(320, 256, 330.0, 330.0, 160.0, 128.0)
BELOW = (0.0, 0.1, 0.0, 0.0, 0.0, 0.0)
WALL_M, PIXELS_PER_M = 1.3, 400.0  # a flat painted wall ahead of the camera


@pytest.fixture(scope="module")
def dive(tmp_path_factory):
    """Two legs of five nodes along a painted wall, there and back, with navigation off by 3 mm."""
    folder = tmp_path_factory.mktemp("dive")
    x = 0.12 * np.arange(5)
    place = np.concatenate([np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + 0.35])])
    global_from_top = exp(np.column_stack([place, np.zeros((10, 4))]))
    paint = cv2.GaussianBlur(np.random.default_rng(0).integers(0, 255, (1000, 1200)).astype(np.uint8), (0, 0), 2.0)
    paint = cv2.normalize(paint, None, 0, 255, cv2.NORM_MINMAX)
    write_features(folder / "features", global_from_top, paint)
    (folder / "ingest").mkdir()
    (folder / "ingest" / "cameras.json").write_text(json.dumps({k: dataclasses.asdict(CAMERA) for k in ("top", "bottom")}))
    write_trajectory(folder / "navigate", global_from_top)
    return SimpleNamespace(folder=folder, global_from_top=global_from_top)


def write_features(folder, global_from_top, paint):
    folder.mkdir()
    options, index = FeatureOptions(reduction=1.0, max_features=600), {}
    for camera, offset in zip(("camera_top", "camera_bottom"), (from_mount((0,) * 6), from_mount(BELOW)), strict=True):
        found = [extract(see(pose.matrix()[0], paint), options) for pose in ((global_from_top @ offset)[k] for k in range(10))]
        index[f"{camera}_start"] = np.concatenate([[0], np.cumsum([len(f) for f in found])])
        index[f"{camera}_saliency"] = np.ones(10)
        for kind, width, dtype in (("keypoints", 4, np.float32), ("descriptors", 128, np.uint8), ("color", 3, np.uint8)):
            with GrowingArray(folder / f"{kind}_{camera}.npy", width, dtype) as file:
                for features in found:
                    file.append(getattr(features, kind))
    np.savez(folder / "index.npz", **index)


def see(global_from_camera, paint):
    """The wall z = 1.3 m as that camera sees it; the paint's pixel (500, 500) is at x = y = 0."""
    wall_from_paint = np.array([[1, 0, -500], [0, 1, -500], [0, 0, PIXELS_PER_M]]) / PIXELS_PER_M
    x, y, z, origin = np.linalg.inv(global_from_camera)[:3].T
    plane = np.column_stack([x, y, z * WALL_M + origin])
    return cv2.warpPerspective(paint, CAMERA.matrix() @ plane @ wall_from_paint, (CAMERA.width, CAMERA.height))


def write_trajectory(folder, global_from_top, image=None):
    """The camera sits in the vehicle's origin and looks along its z (mount and tray are the identity)."""
    folder.mkdir()
    n = len(global_from_top)
    covariance = np.tile(np.diag([1e-4] * 3 + [1e-5] * 3), (n, 1, 1)) * (1 + np.arange(n))[:, None, None]
    off = 0.003 * np.random.default_rng(2).standard_normal((n, 3))
    rows = np.column_stack([np.arange(n)] * 2) if image is None else image
    record = Trajectory(
        t_ns=np.arange(n) * 10**9,
        quaternion=global_from_top.quaternion,
        translation=global_from_top.translation + off,
        covariance=covariance,
        tray=np.zeros(n),
        image=rows,
    )
    np.savez(folder / "trajectory.npz", **to_arrays(record))
    errors = TrajectoryErrorModel(
        by_error=np.zeros((n, 6, 0)), error_covariance=np.zeros((0, 0)), walk=covariance, white=np.zeros((n, 6, 6))
    )
    np.savez(folder / "error_model.npz", **to_arrays(errors))


def run(dive, out, navigate="navigate", stereo=True, jobs=1, **options):
    top, bottom = CameraTop(calibration="t", mount=(0,) * 6), CameraBottom(calibration="b", pose_in_top=BELOW)
    sections = {
        "camera": Cameras(top=top, bottom=bottom if stereo else None),
        "tray": Tray(),
        "dvl": Dvl(),
        "pressure": Pressure(),
        "sonar": None,
        "matches": MatchOptions(**options),
    }
    inputs = {name: dive.folder / (navigate if name == "navigate" else name) for name in ("ingest", "navigate", "features")}
    run_stage(STAGE, sections, inputs, out, jobs=jobs)
    with np.load(out / "tracks.npz") as tracks, np.load(out / "pairs.npz") as pairs:
        return from_arrays(Tracks, dict(tracks)), dict(pairs), json.loads((out / "pairs.json").read_text())


def wall_points(dive, tracks, camera=0):
    """Where each observation's ray meets the wall (m, 2), NaN where that camera did not see."""
    pixel = (tracks.top, tracks.bottom)[camera]
    centre = dive.global_from_top.translation[tracks.node][:, :2] + ([0, 0], [0, 0.1])[camera]
    return centre + WALL_M * (pixel - [CAMERA.cx, CAMERA.cy]) / CAMERA.fx


def test_every_observation_of_a_landmark_is_of_one_point_of_the_wall(dive, tmp_path):
    tracks, _, report = run(dive, tmp_path / "out")
    point = wall_points(dive, tracks)
    mean = np.stack([np.bincount(tracks.landmark, point[:, k]) for k in range(2)], 1) / np.bincount(tracks.landmark)[:, None]
    error_px = np.linalg.norm(point - mean[tracks.landmark], axis=1) * CAMERA.fx / WALL_M
    assert np.median(error_px) < 0.3
    assert (error_px > 2).mean() < 0.01
    below = np.linalg.norm(wall_points(dive, tracks, 1) - point, axis=1) * CAMERA.fx / WALL_M
    assert np.nanmedian(below) < 0.3
    assert report["counts"]["landmarks"] > 500
    assert report["chains"] == [10]


def test_landmarks_span_the_two_legs(dive, tmp_path):
    tracks, pairs, report = run(dive, tmp_path / "out", sequential=1)
    assert report["counts"]["matched_across_legs"] > 0
    assert pairs["reason"][pairs["across"]].min() == 0
    first, last = np.full(len(tracks.color), 99), np.full(len(tracks.color), -1)
    np.minimum.at(first, tracks.landmark, tracks.node)
    np.maximum.at(last, tracks.landmark, tracks.node)
    assert ((first < 5) & (last >= 5)).sum() > 50


def test_tracks_are_sorted_and_hold_a_node_once(dive, tmp_path):
    tracks, _, _ = run(dive, tmp_path / "out")
    rows = np.column_stack([tracks.landmark, tracks.node])
    np.testing.assert_array_equal(rows, np.unique(rows, axis=0))


def test_the_same_bytes_come_out_of_one_process_and_of_two(dive, tmp_path):
    run(dive, tmp_path / "one")
    run(dive, tmp_path / "two", jobs=2)
    for name in ("tracks.npz", "pairs.npz", "pairs.json"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_a_mono_dive_gives_tracks_of_the_top_camera(dive, tmp_path):
    tracks, _, report = run(dive, tmp_path / "out", stereo=False)
    assert np.isnan(tracks.bottom).all()
    assert np.isfinite(tracks.top).all()
    assert (np.bincount(tracks.landmark) >= 2).all()
    assert report["chains"] == [10]


def test_a_node_whose_top_image_is_missing_is_seen_by_the_bottom_camera(dive, tmp_path):
    image = np.column_stack([np.arange(10)] * 2)
    image[3, 0] = image[6, 1] = -1
    gaps = SimpleNamespace(folder=tmp_path, global_from_top=dive.global_from_top)
    for name in ("ingest", "features"):
        (tmp_path / name).symlink_to(dive.folder / name)
    lower = dive.global_from_top
    write_trajectory(tmp_path / "navigate", lower, image)
    tracks, _, report = run(gaps, tmp_path / "out")
    assert np.isnan(tracks.top[tracks.node == 3]).all()
    assert np.isfinite(tracks.bottom[tracks.node == 3]).all()
    assert np.isnan(tracks.bottom[tracks.node == 6]).all()
    assert (tracks.node == 3).sum() > 50
    assert report["chains"] == [10]


def test_why_a_pair_failed_is_kept_as_a_text(dive, tmp_path):
    astray = SimpleNamespace(folder=tmp_path, global_from_top=dive.global_from_top)
    for name in ("ingest", "features"):
        (tmp_path / name).symlink_to(dive.folder / name)
    shift = np.zeros((10, 6))
    shift[5:, 0] = 0.5  # navigation jumps by half a metre between the legs
    write_trajectory(tmp_path / "navigate", exp(shift) @ dive.global_from_top)
    _, pairs, report = run(astray, tmp_path / "out", sequential=1, across=0)
    jump = (pairs["first"] == 4) & (pairs["second"] == 5)
    assert report["reasons"][str(int(pairs["reason"][jump][0]))] == "inconsistent with navigation"
    assert report["failed"] == {"inconsistent with navigation": 1}
    assert report["chains"] == [5, 5]


def test_a_dive_on_which_nothing_matches_ends_with_the_reason(dive, tmp_path):
    with pytest.raises(StageError, match="too few inliers"):
        run(dive, tmp_path / "out", min_inliers=100_000)


def test_a_dive_without_camera_has_no_matches():
    assert STAGE.applies({"camera.top.mount": None}) == "no camera was carried"

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from steps.painted_wall import CAMERA, WALL_M, build_dive, run_links, run_matches, with_navigation

from hullrecon.errors import InputError, StageError
from hullrecon.geometry.poses import exp
from hullrecon.records.serialisation import from_arrays
from hullrecon.records.tracks import Tracks
from hullrecon.steps.chain import stage
from hullrecon.vision import match_images
from hullrecon.vision.options import LinkOptions

STAGE = stage("matches")


@pytest.fixture(scope="module")
def dive(tmp_path_factory):
    return build_dive(tmp_path_factory.mktemp("dive"))


def run(dive, out, **options):
    """Links and matches of a dive: tracks, pairs and what is said of them."""
    run_links(dive, out, **options)
    run_matches(dive, out, **options)
    return left(out)


def left(out):
    folder = out / "matches"
    with np.load(folder / "tracks.npz") as tracks, np.load(folder / "pairs.npz") as pairs:
        return (
            from_arrays(Tracks, dict(tracks)),
            dict(pairs),
            json.loads((folder / "pairs.json").read_text()),
        )


@pytest.fixture(scope="module")
def matched(dive, tmp_path_factory):
    """The dive as it is matched by default."""
    out = tmp_path_factory.mktemp("out")
    tracks, pairs, report = run(dive, out)
    return SimpleNamespace(tracks=tracks, pairs=pairs, report=report, out=out)


def wall_points(dive, tracks, camera=0):
    """Where each observation's ray meets the wall (m, 2), NaN where that camera did not see."""
    pixel = (tracks.top, tracks.bottom)[camera]
    centre = dive.global_from_top.translation[tracks.node][:, :2] + ([0, 0], [0, 0.1])[camera]
    return centre + WALL_M * (pixel - [CAMERA.cx, CAMERA.cy]) / CAMERA.fx


def test_observations_of_a_landmark_are_of_one_point(dive, matched):
    tracks, report = matched.tracks, matched.report
    point = wall_points(dive, tracks)
    mean = (
        np.stack([np.bincount(tracks.landmark, point[:, k]) for k in range(2)], 1)
        / np.bincount(tracks.landmark)[:, None]
    )
    error_px = np.linalg.norm(point - mean[tracks.landmark], axis=1) * CAMERA.fx / WALL_M
    assert np.median(error_px) < 0.3
    assert (error_px > 2).mean() < 0.01
    below = np.linalg.norm(wall_points(dive, tracks, 1) - point, axis=1) * CAMERA.fx / WALL_M
    assert np.nanmedian(below) < 0.3
    assert report["counts"]["landmarks"] > 500
    assert report["chains"] == [10]


def test_landmarks_span_the_two_legs(dive, tmp_path):
    tracks, pairs, report = run(dive, tmp_path, sequential=1)
    assert report["counts"]["matched_across_legs"] > 0
    assert pairs["reason"][pairs["across"]].min() == 0
    first, last = np.full(len(tracks.color), 99), np.full(len(tracks.color), -1)
    np.minimum.at(first, tracks.landmark, tracks.node)
    np.maximum.at(last, tracks.landmark, tracks.node)
    assert ((first < 5) & (last >= 5)).sum() > 50


def test_tracks_are_sorted_and_hold_a_node_once(matched):
    rows = np.column_stack([matched.tracks.landmark, matched.tracks.node])
    np.testing.assert_array_equal(rows, np.unique(rows, axis=0))


def test_pairs_are_those_of_links_with_their_inliers(matched):
    with (
        np.load(matched.out / "links" / "pairs.npz") as pairs,
        np.load(matched.out / "links" / "features.npz") as features,
    ):
        for name in pairs.files:
            np.testing.assert_array_equal(matched.pairs[name], pairs[name])
        joined = (pairs["reason"] == 0) & ~pairs["rejected"]
        np.testing.assert_array_equal(matched.pairs["inliers"][joined], np.diff(features["start"]))
        assert not matched.pairs["inliers"][~joined].any()
    assert matched.report["counts"]["pairs"] == len(joined)
    assert matched.report["counts"]["matched"] == joined.sum()
    assert matched.report["counts"]["keyframes"] == matched.report["counts"]["nodes"] == 10


def test_a_second_run_in_smaller_blocks_leaves_the_same_bytes(dive, matched, tmp_path, monkeypatch):
    monkeypatch.setattr(match_images, "BLOCK_ROWS", 500)
    (tmp_path / "links").symlink_to(matched.out / "links")
    run_matches(dive, tmp_path)
    for name in ("tracks.npz", "pairs.npz", "pairs.json"):
        assert (tmp_path / "matches" / name).read_bytes() == (
            matched.out / "matches" / name
        ).read_bytes()


def test_a_mono_dive_gives_tracks_of_the_top_camera(dive, tmp_path):
    tracks, _, report = run(dive, tmp_path, stereo=False)
    assert np.isnan(tracks.bottom).all()
    assert np.isfinite(tracks.top).all()
    assert (np.bincount(tracks.landmark) >= 2).all()
    assert report["chains"] == [10]


def test_node_without_top_image_is_seen_by_bottom_camera(dive, tmp_path):
    image = np.column_stack([np.arange(10)] * 2)
    image[3, 0] = image[6, 1] = -1
    gaps = with_navigation(dive, tmp_path, dive.global_from_top, image)
    tracks, _, report = run(gaps, tmp_path)
    assert np.isnan(tracks.top[tracks.node == 3]).all()
    assert np.isfinite(tracks.bottom[tracks.node == 3]).all()
    assert np.isnan(tracks.bottom[tracks.node == 6]).all()
    assert (tracks.node == 3).sum() > 50
    assert report["chains"] == [10]


def test_why_a_pair_failed_is_kept_as_a_text(dive, tmp_path):
    shift = np.zeros((10, 6))
    shift[5:, 0] = 0.5  # navigation jumps by half a metre between the legs
    astray = with_navigation(dive, tmp_path, exp(shift) @ dive.global_from_top)
    _, pairs, report = run(astray, tmp_path, links=LinkOptions(max_rounds=0), sequential=1)
    jump = (pairs["first"] == 4) & (pairs["second"] == 5)
    assert report["reasons"][str(int(pairs["reason"][jump][0]))] == "inconsistent with navigation"
    assert report["failed"] == {"inconsistent with navigation": 1}
    assert report["chains"] == [5, 5]


def test_a_dive_on_which_nothing_matches_ends_with_the_reason(dive, tmp_path):
    with pytest.raises(StageError, match="too few inliers"):
        run(dive, tmp_path, min_inliers=100_000)


def test_links_that_are_damaged_are_named(dive, matched, tmp_path):
    folder = tmp_path / "links"
    folder.mkdir()
    for file in (matched.out / "links").iterdir():
        if file.name != "stereo.npz":
            (folder / file.name).write_bytes(file.read_bytes())
    with pytest.raises(InputError, match=r"stereo\.npz is missing"):
        run_matches(dive, tmp_path)
    shutil.copy(matched.out / "links" / "stereo.npz", folder)  # as the step leaves it again
    run_matches(dive, tmp_path)


def test_a_dive_without_camera_has_no_matches():
    assert STAGE.applies({"camera.top.mount": None}, Path()) == "no camera was carried"

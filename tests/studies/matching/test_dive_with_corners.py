# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A dive before a painted wall, linked and matched with corners beside SIFT features."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from steps.painted_wall import CAMERA, WALL_M, build_dive, run_links, run_matches

from hullrecon.geometry.frames import Camera
from hullrecon.steps import links
from hullrecon.steps.artifacts import LinksArtifact
from hullrecon.studies.matching.corners import MatchWithCorners, extract_with_corners
from hullrecon.vision.features.store import FeatureStore
from hullrecon.vision.pairs.matching import MatchStrategy
from hullrecon.vision.stereo.node_view import NodeFeatures

SHARE = 0.3


def run(dive, out, share=None):
    """The links and tracks of a dive, with corners up to a share of the matches, or as ever."""
    links_of = links.run
    if share is not None:
        links_of = partial(
            links.run, strategy=MatchStrategy(match_descriptors=MatchWithCorners(share))
        )
    run_links(dive, out, links_of=links_of)
    run_matches(dive, out)
    with np.load(out / "matches" / "tracks.npz") as tracks:
        tracks = SimpleNamespace(**dict(tracks))
    with np.load(out / "matches" / "pairs.npz") as pairs:
        return SimpleNamespace(
            tracks=tracks, inliers=pairs["inliers"], links=LinksArtifact(out / "links")
        )


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The dive with corners in store, matched with and without a share of them."""
    dive = build_dive(tmp_path_factory.mktemp("corners"), find=extract_with_corners)
    found = {share: run(dive, tmp_path_factory.mktemp("out"), share) for share in (0.0, SHARE)}
    return SimpleNamespace(dive=dive, found=found)


def wall_points(dive, tracks):
    """Where the top camera's rays meet the wall (m, 2)."""
    centre = dive.global_from_top.translation[tracks.node][:, :2]
    return centre + WALL_M * (tracks.top - [CAMERA.cx, CAMERA.cy]) / CAMERA.fx


def test_landmarks_of_corners_are_as_right_as_those_of_sift(both):
    sift, tracks = (both.found[share].tracks for share in (0.0, SHARE))
    assert len(sift.color) < len(tracks.color)
    assert np.isnan(tracks.response).any()
    point = wall_points(both.dive, tracks)
    mean = np.stack([np.bincount(tracks.landmark, point[:, k]) for k in range(2)], 1)
    mean /= np.bincount(tracks.landmark)[:, None]
    error_px = np.linalg.norm(point - mean[tracks.landmark], axis=1) * CAMERA.fx / WALL_M
    assert np.median(error_px) < 0.3
    assert (error_px > 2).mean() < 0.01


def test_corners_are_their_share_of_each_pairs_matches(both):
    store = FeatureStore(both.dive.folder / "features", Camera.TOP)
    corner = [~NodeFeatures(top=store.read(k), bottom=store.read(-1)).leading.scored
              for k in range(len(store))]  # fmt: skip
    features = both.found[SHARE].links.features
    links = both.found[SHARE].links.links
    counts = np.array(
        [
            (corner[node][features.rows["first"][a:b]].sum(), b - a)
            for node, a, b in zip(links.first, features.start[:-1], features.start[1:], strict=True)
        ]
    )
    assert (counts[:, 0] <= SHARE * counts[:, 1] + 1e-6).all()
    assert counts[:, 0].sum() == pytest.approx(
        SHARE * counts[:, 1].sum(), abs=0.05 * counts[:, 1].sum()
    )


def test_no_pair_has_fewer_features_in_common_with_corners(both):
    sift, with_corners = (both.found[share].inliers for share in (0.0, SHARE))
    assert (with_corners >= sift).mean() >= 0.95


def test_corners_in_store_without_share_change_no_track(both, tmp_path_factory):
    plain = run(build_dive(tmp_path_factory.mktemp("plain")), tmp_path_factory.mktemp("out"))
    for name in ("landmark", "node", "top", "bottom", "color", "response"):
        np.testing.assert_array_equal(
            getattr(both.found[0.0].tracks, name), getattr(plain.tracks, name)
        )

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import exp
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.tracks.track_verification import Link, contradicted_observations


@pytest.fixture
def case(rig, wall):
    """60 landmarks seen by five nodes a decimetre apart, every pair of which is verified."""
    poses = [exp([[0.1 * k, 0.01 * k, 0, 0, 0.01 * k, 0]]) for k in range(5)]
    ahead = np.flatnonzero((np.abs(wall.points[:, :2] - [0.2, 0.05]) < [0.35, 0.3]).all(axis=1))[
        :60
    ]
    node, label = np.repeat(np.arange(5), len(ahead)), np.tile(np.arange(len(ahead)), 5)
    top = np.concatenate(
        [rig.model(Camera.TOP).project(p.inverse().apply(wall.points[ahead])) for p in poses]
    )
    bottom = np.concatenate(
        [
            rig.model(Camera.BOTTOM).project(
                (p @ rig.top_from_bottom).inverse().apply(wall.points[ahead])
            )
            for p in poses
        ]
    )
    links = [
        Link(
            first=i,
            second=j,
            motion=Motion((poses[j].inverse() @ poses[i]).matrix()[0], 1e-8 * np.eye(6)),
            scaled=True,
        )
        for i in range(5)
        for j in range(i + 1, 5)
    ]
    return node, label, top, bottom, links


def test_true_tracks_are_kept(rig, case):
    assert not contradicted_observations(rig, *case, 0.4).any()


@pytest.mark.parametrize("shift", [[0.0, 6.0], [8.0, 0.0]])
def test_observation_off_in_both_images_alone_is_rejected(rig, case, shift):
    """Off across the lines of the motion, or along them at the wrong depth."""
    node, label, top, bottom, links = case
    wrong = np.flatnonzero((node == 2) & (label == 7))
    top[wrong] += shift
    bottom[wrong] += shift
    assert (
        np.flatnonzero(
            contradicted_observations(rig, node, label, top, bottom, links, 0.4)
        ).tolist()
        == wrong.tolist()
    )


def test_landmark_without_stereo_is_held_to_its_lines(rig, case):
    node, label, top, bottom, links = case
    bottom[:] = np.nan
    wrong = np.flatnonzero((node == 2) & (label == 7))
    top[wrong] += [0.0, 6.0]
    assert (
        np.flatnonzero(
            contradicted_observations(rig, node, label, top, bottom, links, 0.4)
        ).tolist()
        == wrong.tolist()
    )


def test_two_halves_of_wrong_track_lose_smaller_one(rig, case):
    node, label, top, bottom, links = case
    mixed = label.copy()
    # nodes 3 and 4 call landmark 7 number 8, and 8 is not seen there
    mixed[(node >= 3) & (label == 7)] = 8
    keep = ~((node >= 3) & (label == 8))
    found = contradicted_observations(
        rig, node[keep], mixed[keep], top[keep], bottom[keep], links, 0.4
    )
    rejected = np.flatnonzero(found)
    assert set(node[keep][rejected].tolist()) == {3, 4}
    assert set(mixed[keep][rejected].tolist()) == {8}


def test_without_verified_pairs_nothing_is_rejected(rig, case):
    node, label, top, bottom, _ = case
    assert not contradicted_observations(rig, node, label, top, bottom, [], 0.4).any()

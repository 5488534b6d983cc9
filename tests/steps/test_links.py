# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import json
from functools import partial

import numpy as np
import pytest
from steps.painted_wall import build_dive, run_links, with_navigation

from hullrecon.geometry.poses import Poses, exp
from hullrecon.records.trajectory import Trajectory
from hullrecon.steps import links
from hullrecon.steps.artifacts import LinksArtifact, NavigateArtifact
from hullrecon.vision.appearance.recognition import ALIKE, Recognition
from hullrecon.vision.options import LinkOptions
from hullrecon.vision.pairs.pair_match import Reason, failed_match
from hullrecon.vision.pairs.selection import Proposal


@pytest.fixture(scope="module")
def dive(tmp_path_factory):
    return build_dive(tmp_path_factory.mktemp("dive"))


def run(dive, out, **options):
    run_links(dive, out, **options)
    return LinksArtifact(out / "links")


@pytest.fixture(scope="module")
def linked(dive, tmp_path_factory):
    """The dive as it is linked where only the next node is a neighbour: the legs are tied by
    rounds.
    """
    return run(dive, tmp_path_factory.mktemp("out"), sequential=1)


def relative_error_m(dive, links):
    """How far off the true relative position each link is, and by how many radians."""
    camera = dive.global_from_top
    truth = camera[links.second].inverse() @ camera[links.first]
    turn = truth.rotation.inv() * Poses(links.quaternion, links.translation).rotation
    return np.linalg.norm(links.translation - truth.translation, axis=1), turn.magnitude()


def path_error_m(dive, translation):
    """Largest distance from the truth of the path laid onto it at its mean, m."""
    truth = dive.global_from_top.translation
    return float(
        np.linalg.norm(translation - truth - (translation - truth).mean(axis=0), axis=1).max()
    )


def test_every_link_is_the_true_relative_pose(dive, linked):
    shift, turn = relative_error_m(dive, linked.links)
    assert len(linked.links) == linked.pairs.joined.sum() > 9
    assert shift.max() < 0.01
    assert turn.max() < 0.01
    assert linked.links.scaled.all()
    assert not linked.links.bottom.any()


def test_links_err_by_no_more_than_a_few_of_their_sigmas(dive, linked):
    shift, _ = relative_error_m(dive, linked.links)
    sigma = np.sqrt(np.trace(linked.links.covariance[:, :3, :3], axis1=1, axis2=2))
    assert np.median(shift / sigma) < 1.5
    assert (shift / sigma).max() < 5


def test_pairs_across_legs_are_compared_after_neighbours(linked):
    pairs = linked.pairs
    assert (pairs.round[~pairs.across] == 0).all()
    assert (pairs.round[pairs.across] > 0).all()
    assert (pairs.joined & pairs.across).any()
    rows = np.column_stack([pairs.first, pairs.second])
    np.testing.assert_array_equal(rows, np.unique(rows, axis=0))


def test_the_rounds_are_counted(linked):
    facts, pairs = linked.facts, linked.pairs
    assert facts["keyframes"] == 10
    for number, counted in enumerate(facts["rounds"]):
        rows = pairs.round == number
        assert counted == {
            "compared": rows.sum(),
            "joined": (pairs.joined & rows).sum(),
            "rejected": (pairs.rejected & rows).sum(),
        }
    assert facts["rounds"][0]["compared"] == 9


def test_the_features_of_each_pair_and_node_lie_together(linked):
    links, features, stereo = linked.links, linked.features, linked.stereo
    assert len(features.start) == len(links) + 1
    assert features.start[-1] == len(features.rows)
    assert (np.diff(features.start) >= 12).all()
    top_count = stereo.features[links.first]
    for k in range(len(links)):
        rows = features.rows[features.start[k] : features.start[k + 1]]
        assert rows["first"].max() < top_count[k]
    assert len(stereo.start) == 11
    assert np.median(stereo.point[:, 2]) == pytest.approx(1.3, abs=0.02)


def test_the_path_is_straighter_than_navigation_has_it(dive, linked):
    reckoned = NavigateArtifact(dive.folder / "navigate").trajectory
    assert (
        path_error_m(dive, linked.path.pose[:, :3])
        < 0.003
        < path_error_m(dive, reckoned.translation)
    )
    assert linked.path.part.tolist() == [0] * 10
    assert linked.path.covariance.shape == (10, 6, 6)


def drifted(dive, folder, drift_rad):
    """Navigation whose heading turns at each step: the second leg lies askew over the first."""
    start = dive.global_from_top[np.zeros(1, int)]
    chain = [start]
    for k in range(9):
        step = (
            dive.global_from_top[np.array([k])].inverse() @ dive.global_from_top[np.array([k + 1])]
        )
        chain.append(chain[-1] @ step @ exp([[0, 0, 0, 0, 0, drift_rad]]))
    path = Poses(
        np.vstack([p.quaternion for p in chain]), np.vstack([p.translation for p in chain])
    )
    return with_navigation(dive, folder, path, sigma_m=0.02)


def test_a_heading_that_drifts_is_straightened(dive, tmp_path):
    askew = drifted(dive, tmp_path, np.radians(1.5))
    found = run(askew, tmp_path, sequential=1)
    reckoned: Trajectory = NavigateArtifact(tmp_path / "navigate").trajectory
    assert path_error_m(dive, reckoned.translation) > 0.03
    assert path_error_m(dive, found.path.pose[:, :3]) < 0.006
    assert (found.pairs.joined & found.pairs.across).any()


def test_without_rounds_only_neighbours_are_linked(dive, tmp_path):
    found = run(dive, tmp_path, links=LinkOptions(max_rounds=0), sequential=1)
    assert not found.pairs.across.any()
    assert len(found.pairs) == 9


def test_the_same_bytes_come_out_of_one_process_and_of_two(dive, linked, tmp_path):
    found = run(dive, tmp_path, jobs=2, sequential=1)
    for name in (
        "pairs.npz",
        "features.npz",
        "features.npy",
        "links.npz",
        "stereo.npz",
        "path.npz",
        "links.json",
    ):
        assert (found.folder / name).read_bytes() == (linked.folder / name).read_bytes()


@pytest.mark.parametrize("kernel", ["switch", "none"])
def test_any_kernel_gives_the_path_where_all_links_are_right(dive, linked, tmp_path, kernel):
    found = run(dive, tmp_path, links_of=partial(links.run, kernel=kernel), sequential=1)
    np.testing.assert_allclose(found.path.pose[:, :3], linked.path.pose[:, :3], atol=0.004)


def test_links_of_one_camera_have_a_direction_and_no_length(dive, tmp_path):
    found = run(dive, tmp_path, stereo=False, sequential=1)
    assert not found.links.scaled.any()
    assert len(found.stereo.point) == 0
    camera = dive.global_from_top
    truth = (camera[found.links.second].inverse() @ camera[found.links.first]).translation
    way = found.links.translation / np.linalg.norm(found.links.translation, axis=1, keepdims=True)
    truth /= np.linalg.norm(truth, axis=1, keepdims=True)
    assert np.degrees(np.arccos(np.einsum("mi,mi->m", way, truth).clip(-1, 1))).max() < 8


def test_node_without_top_image_is_linked_by_bottom_camera(dive, tmp_path):
    image = np.column_stack([np.arange(10)] * 2)
    image[3, 0] = -1
    found = run(
        with_navigation(dive, tmp_path, dive.global_from_top, image), tmp_path, sequential=1
    )
    touched = found.links.first == 3, found.links.second == 3
    assert touched[0].any() or touched[1].any()
    np.testing.assert_array_equal(found.links.bottom, np.column_stack(touched))
    assert path_error_m(dive, found.path.pose[:, :3]) < 0.003
    assert found.path.part[3] == 0


def test_a_dive_in_two_parts_is_said_to_be(dive, tmp_path):
    shift = np.zeros((10, 6))
    shift[5:, 0] = 0.5  # navigation jumps by half a metre between the legs
    astray = with_navigation(dive, tmp_path, exp(shift) @ dive.global_from_top)
    found = run(astray, tmp_path, links=LinkOptions(max_rounds=0), sequential=1)
    assert found.path.part.tolist() == [0] * 5 + [1] * 5
    assert found.path.part_sigma[0] == 0.0 < found.path.part_sigma[1]
    warning = json.loads((found.folder / "manifest.json").read_text())["warnings"][0]
    assert warning.startswith(
        "The images fall into 2 parts that navigation alone ties together: "
        "5 nodes from 00:00:00 to 00:00:04; 5 nodes"
    )


def test_appearance_result_is_written_and_refusal_warned_of(dive, linked, tmp_path, monkeypatch):
    pairs = Proposal(
        first=np.array([1]), second=np.array([8]), across=np.ones(1, bool), overlap=np.ones(1)
    )
    refused = Recognition(
        proposal=pairs,
        found=(failed_match(5, Reason.FEW_INLIERS),),
        accepted=np.zeros(1, bool),
        counts={"offered": 1},
        refusal=ALIKE,
    )
    monkeypatch.setattr("hullrecon.vision.link_images.recognise_places", lambda *asked: refused)
    found = run(dive, tmp_path, sequential=1)
    assert found.facts["appearance"] == [{"offered": 1, "accepted": 0, "refusal": ALIKE}]
    assert "appearance" not in linked.facts
    warnings = json.loads((found.folder / "manifest.json").read_text())["warnings"]
    assert warnings == [f"How images look does not say what lies where: {ALIKE}."]
    np.testing.assert_array_equal(found.path.pose, linked.path.pose)


def test_dive_without_matches_keeps_dead_reckoned_path(dive, tmp_path):
    found = run(dive, tmp_path, min_inliers=100_000)
    assert len(found.links) == 0
    assert (found.path.part == -1).all()
    reckoned = NavigateArtifact(dive.folder / "navigate").trajectory
    np.testing.assert_allclose(found.path.pose[:, :2], reckoned.translation[:, :2], atol=0.01)

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Links between two parts of a path that is known within each, and not between them."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, exp
from hullrecon.vision.appearance.consistency import (
    agreement,
    compose,
    extent_m,
    independent_links,
    largest_group,
)
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.pair_match import PairMatch, Reason

EACH, LINK_SIGMA = 8, 2e-3
ROWS = np.arange(20)


@dataclass(frozen=True)
class Pieces:
    """Errors of a path of two pieces: a step of 1 mm and 0.02 degrees a node within one, metres
    between them.
    """

    between_m: float = 4.0

    def relative_covariance(self, first, second):
        steps = np.abs(first - second)
        out = steps[:, None, None] * np.diag(np.repeat([1e-6, np.radians(0.02) ** 2], 3))
        apart = (first < EACH) != (second < EACH)
        return out + apart[:, None, None] * np.diag(np.repeat([self.between_m**2, 0.01**2], 3))


def path():
    """Cameras along two parallel pieces, the second's way back."""
    out = np.arange(EACH) * 0.3
    at = np.zeros((2 * EACH, 3))
    at[:, 0], at[EACH:, 1] = np.r_[out, out[::-1]], 0.4
    turn = Rotation.from_rotvec(np.repeat([0.0, 0.05], EACH)[:, None] * [0, 0, 1.0]).as_quat()
    return CameraTrack(global_from_camera=Poses(turn, at), errors=Pieces())


def matched(track, first, second, shift=(0.0, 0.0, 0.0), seed=1):
    """What the images of true pairs give, with noise; of a second piece that lies elsewhere by the
    shift.
    """
    rng = np.random.default_rng(seed)
    at = track.global_from_camera
    moved = Poses(at.quaternion[second], at.translation[second] + shift)
    truth = (moved.inverse() @ at[first]).matrix()
    noise = exp(LINK_SIGMA * rng.standard_normal((len(first), 6))).matrix()
    covariance = np.diag(np.repeat(LINK_SIGMA**2, 6))
    return [
        PairMatch(
            first=ROWS,
            second=ROWS,
            distance=ROWS.astype(np.float32),
            putative=40,
            reason=Reason.MATCHED,
            motion=Motion(t @ n, covariance),
        )
        for t, n in zip(truth, noise, strict=True)
    ]


FIRST = np.array([0, 1, 2, 4, 5, 6])
SECOND = 2 * EACH - 1 - FIRST


def test_links_of_one_place_confirm_each_other():
    track = path()
    found = agreement(
        track, FIRST, SECOND, matched(track, FIRST, SECOND, shift=[2.5, -1.0, 0.3]), 0.2
    )
    np.testing.assert_array_equal(found.agree, ~np.eye(6, dtype=bool))
    assert not found.contradict.any()


def test_link_to_another_place_is_contradicted_by_all_others():
    track = path()
    right, wrong = (matched(track, FIRST, SECOND, shift=[x, 0.0, 0.0]) for x in (0.0, 0.1))
    found = agreement(track, FIRST, SECOND, [*right[:3], wrong[3], *right[4:]], 0.2)
    assert found.contradict[3].sum() == 5
    assert not found.agree[3].any()
    np.testing.assert_array_equal(largest_group(found.agree, np.arange(6)), [0, 1, 2, 4, 5])


def test_links_across_unknown_path_say_nothing_of_each_other():
    track = path()
    # the second link stays within the first piece
    first, second = np.array([0, 1]), np.array([14, 2])
    found = agreement(track, first, second, matched(track, first, second), 0.2)
    assert not found.agree.any()
    assert not found.contradict.any()


def test_composed_motions_have_covariance_of_drawn_ones():
    rng = np.random.default_rng(7)
    outer, inner = (
        exp([[0.4, -0.2, 0.9, 0.3, 0.1, -0.4]]).matrix()[0],
        exp([[-0.3, 0.8, 0.2, -0.2, 0.5, 0.1]]).matrix()[0],
    )
    roots = [1e-3 * rng.standard_normal((6, 6)) for _ in range(2)]
    motion = compose(Motion(outer, roots[0] @ roots[0].T), Motion(inner, roots[1] @ roots[1].T))
    np.testing.assert_allclose(motion.second_from_first, outer @ inner)

    def drawn(matrix, root):
        step = rng.standard_normal((20000, 6)) @ root.T
        out = np.tile(matrix, (20000, 1, 1))
        out[:, :3, 3] += step[:, :3]
        out[:, :3, :3] = matrix[:3, :3] @ Rotation.from_rotvec(step[:, 3:]).as_matrix()
        return out

    both = drawn(outer, roots[0]) @ drawn(inner, roots[1])
    turn = np.linalg.inv((outer @ inner)[:3, :3]) @ both[:, :3, :3]
    gap = np.hstack(
        [both[:, :3, 3] - (outer @ inner)[:3, 3], Rotation.from_matrix(turn).as_rotvec()]
    )
    found = np.cov(gap.T)
    np.testing.assert_allclose(motion.covariance, found, atol=0.05 * np.abs(found).max())


def test_largest_group_is_one_in_which_all_agree():
    agree = np.zeros((7, 7), bool)
    for group in ([0, 1, 2, 3], [3, 4], [5, 6, 4]):
        agree[np.ix_(group, group)] = True
    agree[np.arange(7), np.arange(7)] = False
    np.testing.assert_array_equal(largest_group(agree, np.arange(7)), [0, 1, 2, 3])
    np.testing.assert_array_equal(largest_group(agree, np.array([0, 4, 5, 6])), [4, 5, 6])
    assert len(largest_group(agree, np.zeros(0, np.int64))) == 0


def test_links_that_share_image_count_once():
    assert independent_links(np.array([0, 0, 1, 2]), np.array([8, 9, 9, 8])) == 2
    assert independent_links(np.arange(3), np.arange(3) + 5) == 3


def test_extent_is_between_farthest_points():
    assert extent_m(np.array([[0, 0, 0], [3, 4, 0], [1, 1, 1.0]])) == 5.0
    assert extent_m(np.zeros((0, 3))) == 0.0

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Cycles of three links: a wrong one among right ones is the one that is named."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.records.links import CameraLinks
from hullrecon.vision.pairs import cycles
from hullrecon.vision.pairs.cycles import MAX_CHI2, contradicted_links

SIGMA_RAD = 0.004


def links(pairs, seed=0, noise=1.0, wrong=(), turn_rad=0.1, sigma_rad=SIGMA_RAD):
    """Links second_from_first of cameras of random attitude; the rows `wrong` are turned by
    turn_rad about a random axis.
    """
    rng = np.random.default_rng(seed)
    pairs = np.asarray(pairs, np.int64).reshape(-1, 2)
    attitude = Rotation.random(int(pairs.max(initial=0)) + 1, rng=rng)
    error = noise * sigma_rad * rng.standard_normal((len(pairs), 3))
    axis = rng.standard_normal((len(pairs), 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    error[list(wrong)] += turn_rad * axis[list(wrong)]
    if len(pairs):
        turn = attitude[pairs[:, 1]].inv() * attitude[pairs[:, 0]] * Rotation.from_rotvec(error)
        quaternion = turn.as_quat()
    else:
        quaternion = np.zeros((0, 4))
    covariance = np.tile(
        np.diag(np.r_[np.full(3, 0.01), np.full(3, sigma_rad)] ** 2), (len(pairs), 1, 1)
    )
    return CameraLinks(
        first=pairs[:, 0],
        second=pairs[:, 1],
        translation=np.zeros((len(pairs), 3)),
        quaternion=quaternion,
        covariance=covariance,
        scaled=np.ones(len(pairs), bool),
        bottom=np.zeros((len(pairs), 2), bool),
    )


def two_legs(n=8):
    """Pairs of two legs of n nodes: neighbours of either, and every node with three of the other
    leg; which are across.
    """
    along = [(k, k + s) for s in (1, 2) for k in range(2 * n - s) if (k < n) == (k + s < n)]
    across = [
        (k, 2 * n - 1 - k + s)
        for k in range(n)
        for s in (-1, 0, 1)
        if n <= 2 * n - 1 - k + s < 2 * n
    ]
    return np.array(along + across), np.arange(len(along) + len(across)) >= len(along)


@pytest.mark.parametrize("seed", range(5))
def test_right_links_are_kept(seed):
    pairs, across = two_legs()
    assert not contradicted_links(links(pairs, seed), across).any()


@pytest.mark.parametrize("seed", range(5))
def test_wrong_link_among_right_ones_is_one_that_is_named(seed):
    pairs, across = two_legs()
    wrong = int(np.random.default_rng(seed).choice(np.flatnonzero(across)))
    found = contradicted_links(links(pairs, seed, wrong=[wrong]), across)
    assert np.flatnonzero(found).tolist() == [wrong]


@pytest.mark.parametrize("seed", range(5))
def test_several_wrong_links_are_named_each(seed):
    pairs, across = two_legs(12)
    wrong = np.sort(
        np.random.default_rng(seed).choice(np.flatnonzero(across)[::5], 3, replace=False)
    )
    found = contradicted_links(links(pairs, seed, wrong=wrong), across)
    assert np.flatnonzero(found).tolist() == wrong.tolist()


def test_order_of_links_makes_no_difference():
    pairs, across = two_legs()
    wrong = int(np.flatnonzero(across)[5])
    made, order = links(pairs, 3, wrong=[wrong]), np.random.default_rng(1).permutation(len(pairs))
    names = ("first", "second", "translation", "quaternion", "covariance", "scaled", "bottom")
    shuffled = CameraLinks(**{name: getattr(made, name)[order] for name in names})
    np.testing.assert_array_equal(
        contradicted_links(shuffled, across[order]), contradicted_links(made, across)[order]
    )


def test_neighbours_along_dive_are_never_named():
    """They are what holds the dive together: a wrong one is left to the graph."""
    pairs, across = two_legs()
    found = contradicted_links(links(pairs, 2, wrong=[3]), across)
    assert not found[~across].any()


def test_link_in_no_cycle_is_not_judged():
    found = contradicted_links(
        links([(0, 1), (1, 2), (2, 3), (0, 3)], wrong=[3]), np.array([False, False, False, True])
    )
    assert not found.any()


def test_one_cycle_that_fails_names_its_link_across_legs():
    across = np.array([False, False, True])
    assert contradicted_links(links([(0, 1), (1, 2), (0, 2)], wrong=[2]), across).tolist() == [
        False,
        False,
        True,
    ]
    assert not contradicted_links(links([(0, 1), (1, 2), (0, 2)]), across).any()


def test_as_many_cycles_for_it_as_against_it_leave_link():
    """Nodes 0 and 9 are linked, both with 1 and with 2; the cycle over 1 closes, that over 2 does
    not, by the link 0-2.
    """
    pairs = [(0, 9), (0, 1), (1, 9), (0, 2), (2, 9)]
    across = np.array([True, False, False, False, False])
    assert not contradicted_links(links(pairs, noise=0.0, wrong=[3]), across).any()
    assert contradicted_links(links(pairs, noise=0.0, wrong=[0]), across).tolist() == [
        True,
        False,
        False,
        False,
        False,
    ]


def test_cycle_fails_where_its_gap_is_beyond_its_sigma():
    """Three links of 4 mrad and what is left out, 0.1 degrees each, let a cycle gap by some 31
    mrad.
    """
    across = np.array([False, False, True])
    limit = np.sqrt(3 * MAX_CHI2 * (SIGMA_RAD**2 + np.radians(0.1) ** 2))
    near, far = (
        contradicted_links(
            links([(0, 1), (1, 2), (0, 2)], noise=0.0, wrong=[2], turn_rad=factor * limit), across
        )
        for factor in (0.99, 1.01)
    )
    assert (near[2], far[2]) == (False, True)


def test_right_cycles_gap_as_chi_square_of_three():
    """Of a thousand cycles of right links one may fail at 99.9 %."""
    pairs = np.array(
        [(3 * k + a, 3 * k + b) for k in range(1000) for a, b in ((0, 1), (1, 2), (0, 2))]
    )
    found = contradicted_links(links(pairs, 6, sigma_rad=0.02), np.tile([False, False, True], 1000))
    assert found.sum() <= 5


def test_anisotropic_sigma_is_rotated_into_axes_of_cycle():
    """The first two links' errors lie about one axis each, known badly; a gap about these is no
    contradiction.
    """
    rng = np.random.default_rng(8)
    failed = 0
    for seed in range(200):
        made = links([(0, 1), (1, 2), (0, 2)], seed, noise=0.0)
        turn = np.radians([[5.0, 0.1, 0.1], [0.1, 5.0, 0.1], [0.1, 0.1, 0.1]])
        made.covariance[:, 3:, 3:] = np.einsum("mi,ij->mij", turn**2, np.eye(3))
        noisy = Rotation.from_quat(made.quaternion) * Rotation.from_rotvec(
            turn * rng.standard_normal((3, 3))
        )
        made.quaternion[:] = noisy.as_quat()
        failed += contradicted_links(made, np.array([False, False, True])).any()
    assert failed <= 4


def test_no_links_contradict_nothing():
    assert contradicted_links(links([]), np.zeros(0, bool)).shape == (0,)


@pytest.mark.parametrize("seed", range(5))
def test_cycles_are_counted_anew_after_each_link_that_goes(seed):
    """Against the definition: all cycles counted again for every link."""
    pairs, across = two_legs(20)
    rng = np.random.default_rng(seed)
    asked = links(pairs, seed, wrong=rng.choice(np.flatnonzero(across), 12, replace=False))
    cycle = cycles._cycles(asked)
    closed = cycles._chi2(asked, cycle) < MAX_CHI2
    out, alive = np.zeros(len(asked), bool), np.ones(len(cycle), bool)
    while True:
        bad, good = (
            np.bincount(cycle[alive & which].ravel(), minlength=len(asked))
            for which in (~closed, closed)
        )
        excess = np.where(across & ~out, bad - good, 0)
        worst = int(np.argmax(excess))
        if excess[worst] <= 0:
            break
        out[worst] = True
        alive &= ~(cycle == worst).any(axis=1)
    assert out.sum() >= 12
    assert (contradicted_links(asked, across) == out).all()

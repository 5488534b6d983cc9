# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Submaps on a small survey: how sure they are, how they are joined, what that costs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest

from hullrecon.studies.association.point_sets import chi_square
from hullrecon.studies.submaps.consistency_study import nees_after_reading
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits
from hullrecon.studies.submaps.end_errors import build_variant, ends_of, together
from hullrecon.studies.submaps.filters import Gaussian, update
from hullrecon.studies.submaps.global_map import GlobalMap, Submap, chain
from hullrecon.studies.submaps.hierarchy import Hierarchy
from hullrecon.studies.submaps.join import fuse, landmarks_in_one_frame, refer_to_base
from hullrecon.studies.submaps.missions import (
    Strategy,
    Track,
    build_submaps,
    map_errors,
    run_filter,
    run_strategy,
)
from hullrecon.studies.submaps.models import compose, invert, place, rotation, wrap
from hullrecon.studies.submaps.selective import SelectiveJoining
from hullrecon.studies.submaps.sequence import JoinedSequence
from hullrecon.studies.submaps.shared import SharedSeparators
from hullrecon.studies.submaps.world_study import SEEDS, simulate_world
from hullrecon.studies.submaps.worlds import (
    Noise,
    Scan,
    Survey,
    World,
    dead_reckon,
    simulate_survey,
)
from hullrecon.typing import Array

SMALL = Survey(cells=6, leg_m=28.0, legs=3, steps_a_scan=10)


@dataclass(frozen=True)
class Survey3:
    """A survey of three legs with its submaps."""

    world: World
    submaps: list[EkfMap]
    effort: Effort


@pytest.fixture(scope="module")
def survey() -> Survey3:
    world, effort = simulate_survey(SMALL, Noise(), seed=1), Effort()
    return Survey3(world, build_submaps(world.log, Limits(), effort), effort)


@pytest.fixture(scope="module")
def selective(survey: Survey3) -> tuple[SelectiveJoining, Track, Effort]:
    effort = Effort()
    strategy = SelectiveJoining(0.4, Limits().landmarks, effort)
    return strategy, run_strategy(survey.submaps, strategy), effort


def true_links(survey: Survey3) -> Array:
    ends = [0, *(m.path[-1].step + 1 for m in survey.submaps)]
    poses = survey.world.track[ends]
    return np.array([compose(invert(a), b) for a, b in pairwise(poses)])


def test_441_landmarks_at_five_metres_take_100_metres_square_not_100_square_metres() -> None:
    """[Aulinas2011 3.4.1] prints 100 m2, which hold nine."""
    for cells, count, area_m2 in ((20, 441, 100.0**2), (2, 9, 100.0)):
        field = Survey(cells=cells, jitter_m=0.0, leg_m=5.0, legs=1)
        landmarks = simulate_survey(field, Noise(), seed=1).landmarks
        assert len(landmarks) == count
        assert np.prod(np.ptp(landmarks, axis=0)) == pytest.approx(area_m2)


def test_submaps_hold_no_more_than_a_scan_above_their_limit(survey: Survey3) -> None:
    for built in survey.submaps[:-1]:
        assert 15 <= len(built.landmarks) < 15 + 13


def test_no_reading_is_paired_with_a_wrong_landmark(survey: Survey3) -> None:
    assert sum(built.wrong_pairs for built in survey.submaps) == 0


@pytest.mark.slow
def test_our_submaps_end_as_surely_as_they_say_and_the_printed_ones_do_not() -> None:
    """In four of the study's twenty worlds, by Jacobians at first estimates and at the newest.

    Both see the same readings, so the difference of an end's NEES tells more than either mean.
    """
    worlds = [simulate_world(seed) for seed in SEEDS[:4]]
    ours, printed = (
        together([ends_of(world, build_variant(world, first_estimates=first)) for world in worlds])
        for first in (True, False)
    )
    assert ours.inside == "inside the band"
    assert printed.inside == "above the band"
    surer = printed.nees - ours.nees
    assert surer.mean() > 3 * surer.std() / np.sqrt(len(surer))


@pytest.mark.parametrize(("first_estimates", "learnt"), [(False, True), (True, False)])
def test_a_car_that_stands_learns_its_heading_only_as_printed(
    first_estimates: bool, learnt: bool
) -> None:
    """Readings of one new landmark tell nothing of a heading that nothing else tells of."""
    world, rng = simulate_survey(SMALL, Noise(), seed=1), np.random.default_rng(0)
    built, noise = EkfMap(Effort(), first_estimates=first_estimates), Noise().laser
    built.covariance[2, 2] = 0.1**2
    for step in range(40):
        built.predict(world.log.car, np.zeros((1, 2)), np.ones(1), np.zeros((2, 2)))
        reading = [6.0, np.pi / 2] + rng.standard_normal((1, 2)) @ np.sqrt(noise)
        built.observe(step, Scan(readings=reading, truth=(0,)), noise)
    assert len(built.landmarks) == 1
    sigma = np.sqrt(built.covariance[2, 2])
    assert (sigma < 0.099) == learnt
    assert sigma <= 0.1 + 1e-9


def test_chained_transforms_have_their_derivatives() -> None:
    rng = np.random.default_rng(0)
    world = GlobalMap()
    for link in rng.standard_normal((5, 3)):
        world.append(link, 0.01 * np.eye(3))
    for first, second in ((1, 4), (4, 1), (0, 5), (2, 2)):
        pose, jacobian = world.relative(first, second)
        frames = chain(world.mean.reshape(-1, 3))
        np.testing.assert_allclose(pose, compose(invert(frames[first]), frames[second]), atol=1e-9)
        for column in range(15):
            changed = GlobalMap()
            changed.mean = world.mean + 1e-6 * np.eye(15)[column]
            off = changed.relative(first, second)[0] - pose
            np.testing.assert_allclose(jacobian[:, column], off / 1e-6, atol=1e-4)


def test_landmarks_behind_an_unsure_chain_are_unsure_not_as_printed() -> None:
    rng = np.random.default_rng(0)
    points = np.array([[5.0, 1.0], [2.0, -4.0]])
    transform, spread = np.array([20.0, 3.0, 0.8]), np.diag([0.2, 0.1, 0.02]) ** 2
    own = 0.01 * np.eye(4)
    moved, covariance = refer_to_base(points, own, transform, spread)
    poses = rng.multivariate_normal(transform, spread, 4000)
    drawn = rng.multivariate_normal(points.ravel(), own, 4000).reshape(-1, 2, 2)
    truth = np.array([place(p, d).ravel() for p, d in zip(poses, drawn, strict=True)])
    off = truth - moved.ravel()
    nees = np.einsum("ni,ni->n", off, np.linalg.solve(covariance, off.T).T)
    assert nees.mean() == pytest.approx(4.0, abs=0.25)
    _, printed = refer_to_base(points, own, transform, np.zeros((3, 3)))
    assert np.einsum("ni,ni->n", off, np.linalg.solve(printed, off.T).T).mean() > 8.0


def test_fusions_are_of_true_pairs_of_enough_landmarks(
    selective: tuple[SelectiveJoining, Track, Effort],
) -> None:
    fusions = selective[0].fusions
    assert fusions
    assert sum(fusion.wrong for fusion in fusions) == 0
    assert min(fusion.shared for fusion in fusions) >= 6  # 40 % of 15


def test_fused_maps_are_as_sure_as_they_say(
    survey: Survey3, selective: tuple[SelectiveJoining, Track, Effort]
) -> None:
    world = selective[0].world
    off = world.mean - true_links(survey).ravel()
    off[2::3] = wrap(off[2::3])
    nees = off @ np.linalg.solve(world.covariance, off)
    assert chi_square(0.001, len(off)) < nees < chi_square(0.999, len(off))


def test_fusion_leaves_each_common_landmark_once(
    selective: tuple[SelectiveJoining, Track, Effort],
) -> None:
    for submap in selective[0].submaps:
        if len(submap.frames) > 1:
            assert len(set(submap.truth)) == len(submap.truth)


def test_selective_joining_drifts_less_than_dead_reckoning(
    survey: Survey3, selective: tuple[SelectiveJoining, Track, Effort]
) -> None:
    world = survey.world
    reckoned = np.linalg.norm((dead_reckon(world.log) - world.track)[-1, :2])
    assert selective[1].distances(world)[-1] < 0.25 * reckoned


def test_no_two_maps_are_fused_that_share_too_little(survey: Survey3) -> None:
    strategy = SelectiveJoining(3.0, Limits().landmarks, Effort())
    run_strategy(survey.submaps, strategy)
    assert len(strategy.submaps) == len(survey.submaps)


@pytest.mark.parametrize("name", ["LMJ", "DCS", "HS"])
def test_every_way_of_joining_maps_the_landmarks(survey: Survey3, name: str) -> None:
    ways: dict[str, Strategy] = {
        "LMJ": JoinedSequence(Effort(), tree=False),
        "DCS": JoinedSequence(Effort(), tree=True),
        "HS": Hierarchy(Effort()),
    }
    strategy = ways[name]
    run_strategy(survey.submaps, strategy)
    if isinstance(strategy, JoinedSequence):
        strategy.finish()
    errors = map_errors(strategy.landmarks(), survey.world)
    assert errors.mean() < 0.6
    seen = {number for built in survey.submaps for number in built.truth}
    assert {number for number, _ in strategy.landmarks()} == seen


def test_tree_and_sequence_make_the_same_map_of_fine_readings() -> None:
    """They differ in where they linearise, by the square of the noise: here a twentieth."""
    fine = Noise(speed_m_s=0.05, steering_rad=0.006, range_m=0.005, bearing_rad=0.001)
    world = simulate_survey(SMALL, fine, seed=1)
    submaps, places = build_submaps(world.log, Limits(), Effort()), []
    for tree in (False, True):
        strategy = JoinedSequence(Effort(), tree=tree)
        run_strategy(submaps, strategy)
        strategy.finish()
        places.append(dict(strategy.landmarks()))
    off = [np.linalg.norm(places[0][n] - places[1][n]) for n in places[0]]
    assert max(off) < 0.003


def test_one_filter_multiplies_ten_times_as_often_on_more_landmarks() -> None:
    wide = Survey(cells=8, leg_m=36.0, legs=4, steps_a_scan=10)
    world = simulate_survey(wide, Noise(), seed=2)
    filter_effort, submap_effort = Effort(), Effort()
    built, track = run_filter(world.log, filter_effort)
    submaps = build_submaps(world.log, Limits(), submap_effort)
    assert built.wrong_pairs == 0
    reckoned = np.linalg.norm((dead_reckon(world.log) - world.track)[:, :2], axis=1)
    assert track.distances(world).mean() < 0.25 * reckoned.mean()
    most = max(len(m.mean) for m in submaps)
    assert most < 3 + 2 * (15 + 13)
    ratio = filter_effort.total_multiplications / submap_effort.total_multiplications
    assert ratio > 10.0


def test_maps_that_share_their_borders_are_one_filter(survey: Survey3) -> None:
    shared = SharedSeparators(Limits(), Effort())
    track, places = shared.run(survey.world.log), dict(shared.landmarks())
    built, filter_track = run_filter(survey.world.log, Effort())
    np.testing.assert_allclose(track.poses, filter_track.poses, atol=1e-9)
    np.testing.assert_allclose(track.covariances, filter_track.covariances, atol=1e-10)
    for number, place_m in zip(built.truth, built.landmarks, strict=True):
        np.testing.assert_allclose(places[number], place_m, atol=1e-9)


def loops_nees() -> float:
    """Close loops of four links, each unsure by 1.5 degrees, at landmarks known to a centimetre."""
    rng, nees = np.random.default_rng(0), []
    spread = np.diag([0.3, 0.3, np.radians(1.5)]) ** 2
    marks = np.array([[4.0, 3.0], [6.0, -2.0], [-3.0, 5.0]])
    for _ in range(25):
        true = [np.array([20.0, 0.0, np.pi / 2])] * 4
        world = GlobalMap()
        for link in true:
            world.append(rng.multivariate_normal(link, spread), spread)
        seen = place(invert(chain(np.array(true))[-1]), marks)
        old, new = (exact_map(world, n, m, rng) for n, m in ((0, marks), (4, seen)))
        fuse(world, old, new, ((0, 0), (1, 1), (2, 2)), Effort())
        off = world.mean - np.concatenate(true)
        off[2::3] = wrap(off[2::3])
        nees.append(off @ np.linalg.solve(world.covariance, off))
    return float(np.mean(nees))


def test_a_loop_is_closed_as_surely_as_it_says_not_by_one_update(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bound = chi_square(0.999, 12 * 25) / 25
    assert loops_nees() < bound
    monkeypatch.setattr("hullrecon.studies.submaps.join.ITERATIONS", 1)
    assert loops_nees() > 2 * bound


def test_fusion_is_the_update_of_the_joint_state(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of transforms and both maps' landmarks at once, by one update, in Joseph's form."""
    monkeypatch.setattr("hullrecon.studies.submaps.join.ITERATIONS", 1)
    world, maps = two_maps()
    size, pairs, marks = len(world.mean), ((0, 1), (2, 0)), (np.arange(3), np.arange(3))
    joint, covariance = joint_state(world, maps)

    def second_in_first(state: Array) -> Array:
        moved = GlobalMap()
        moved.mean = state[:size]
        return place(moved.relative(0, 3)[0], state[size + 6 :].reshape(-1, 2))

    def difference(state: Array) -> Array:
        held = state[size : size + 6].reshape(-1, 2)
        return np.concatenate([second_in_first(state)[j] - held[i] for i, j in pairs])

    jacobian = differentiate(difference, joint)
    updated = update(
        Gaussian(mean=joint, covariance=covariance), -difference(joint), jacobian, 1e-8 * np.eye(4)
    )
    sets = landmarks_in_one_frame(world, *maps, marks, Effort())
    by_state = differentiate(lambda state: second_in_first(state).ravel(), joint)
    carried = covariance @ by_state.T
    np.testing.assert_allclose(sets.second_covariance, by_state @ carried, atol=1e-7)
    assert sets.cross_covariance is not None
    np.testing.assert_allclose(sets.cross_covariance, carried[size : size + 6], atol=1e-7)
    fused = fuse(world, *maps, pairs, Effort())
    np.testing.assert_allclose(world.mean, updated.mean[:size], atol=1e-7)
    np.testing.assert_allclose(world.covariance, updated.covariance[:size, :size], atol=1e-7)
    held = updated.mean[size : size + 6]
    left = second_in_first(updated.mean)[2]
    np.testing.assert_allclose(fused.mean, [*held, *left], atol=1e-7)
    kept = np.concatenate(
        [
            np.eye(len(joint))[size : size + 6],
            differentiate(lambda state: second_in_first(state)[2], updated.mean),
        ]
    )
    spread = fused.rest + fused.gain @ world.covariance @ fused.gain.T
    np.testing.assert_allclose(spread, kept @ updated.covariance @ kept.T, atol=1e-6)


def two_maps() -> tuple[GlobalMap, tuple[Submap, Submap]]:
    """Make two maps at the ends of a chain, correlated with it."""
    rng, world = np.random.default_rng(4), GlobalMap()
    for _ in range(4):
        world.append(np.array([4.0, 0.5, 0.3]), np.diag([0.02, 0.02, 1e-3]))
    marks = np.array([[3.0, 1.0], [5.0, -2.0], [2.0, 4.0]])
    end = world.relative(0, 3)[0]
    maps = []
    for base, points in ((0, marks), (3, place(invert(end), marks)[[2, 0, 1]])):
        gain = np.zeros((6, 12))
        gain[:, 3 * base : 3 * base + 3] = 0.2 * rng.standard_normal((6, 3))
        root = 0.1 * rng.standard_normal((6, 6))
        maps.append(
            Submap(
                base=base,
                frames=(base,),
                mean=points.ravel() + 0.05 * rng.standard_normal(6),
                gain=gain,
                given=world.mean.copy(),
                rest=root @ root.T + 0.01 * np.eye(6),
                truth=(0, 1, 2),
            )
        )
    return world, (maps[0], maps[1])


def joint_state(world: GlobalMap, maps: tuple[Submap, Submap]) -> tuple[Array, Array]:
    """Put transforms and landmarks into one state with its covariance."""
    by_world = np.concatenate([np.eye(len(world.mean)), *(m.gain for m in maps)])
    covariance = by_world @ world.covariance @ by_world.T
    for number, own in enumerate(maps):
        rows = slice(len(world.mean) + 6 * number, len(world.mean) + 6 * number + 6)
        covariance[rows, rows] += own.rest
    return np.concatenate([world.mean, *(m.mean for m in maps)]), covariance


def differentiate(function: Callable[[Array], Array], at: Array) -> Array:
    columns = [(function(at + s) - function(at - s)) / 2e-6 for s in 1e-6 * np.eye(len(at))]
    return np.stack(columns, axis=-1)


def test_newest_frame_is_as_unsure_as_its_chain_says() -> None:
    world, _ = two_maps()
    root = np.random.default_rng(0).standard_normal((12, 12))
    world.covariance = root @ root.T
    spreads, frames = world.spreads_seen_from_each(3), world.frames()
    for number in range(3):
        _, jacobian = world.relative(number, 3)
        turn = np.eye(3)
        turn[:2, :2] = rotation(frames[number, 2])
        expected = turn @ jacobian @ world.covariance @ jacobian.T @ turn.T
        np.testing.assert_allclose(spreads[number], expected, atol=1e-9)


def test_whole_matrices_as_printed_are_the_same_filter_at_more_work(survey: Survey3) -> None:
    whole, blocks = Effort(), Effort()
    log = replace(survey.world.log, scans=dict(list(survey.world.log.scans.items())[:60]))
    printed, _ = run_filter(log, whole, whole=True)
    built, _ = run_filter(log, blocks)
    np.testing.assert_allclose(printed.mean, built.mean, atol=1e-9)
    np.testing.assert_allclose(printed.covariance, built.covariance, atol=1e-10)
    assert whole.total_multiplications > 3 * blocks.total_multiplications


def test_a_reading_of_what_the_car_runs_over_makes_it_too_sure() -> None:
    """A bearing is linearised by more than the landmark is far."""
    low, high = chi_square(0.001, 5 * 300) / 300, chi_square(0.999, 5 * 300) / 300
    assert low < nees_after_reading(Survey().blind_m) < high
    assert nees_after_reading(0.5) > 2 * high


def exact_map(world: GlobalMap, base: int, points: Array, rng: np.random.Generator) -> Submap:
    """Make a map whose landmarks are known to centimetres, whatever the transforms."""
    return Submap(
        base=base,
        frames=(base,),
        mean=points.ravel() + 0.01 * rng.standard_normal(points.size),
        gain=np.zeros((points.size, len(world.mean))),
        given=world.mean.copy(),
        rest=1e-4 * np.eye(points.size),
        truth=tuple(range(len(points))),
    )

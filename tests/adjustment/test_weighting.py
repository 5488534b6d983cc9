# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sigmas that residuals settle: depths of a vehicle whose adjusted path is known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon.adjustment.options import PRODUCT, Strategy
from hullrecon.adjustment.problem.state import ResponseSigmas, State, Weights
from hullrecon.adjustment.problem.weighting import (
    depth_sigma,
    estimate_pixel_sigmas,
    estimate_weights,
)
from hullrecon.geometry import poses
from hullrecon.records.trajectory import Attitude

WEIGHTS = Weights(
    pixel=1.0,
    by_response=ResponseSigmas(pixel=1.0, least=0.0),
    depth=1.0,
    tray=0.01,
    range_sigma=0.02,
    surface=np.ones(0),
    tray_direction=np.ones(400),
    lens=np.zeros(2),
)
GIVEN_M = 0.02


def dive(scene, depth, noise_m, given_m=GIVEN_M, nodes_per_reading=1):
    """Measurements and state of a dive at depths (n,) m, its pressure read with white noise, its
    tray as logged.
    """
    n = len(depth)
    noise = noise_m * np.random.default_rng(1).standard_normal(n)
    level, sigma = np.zeros(n), np.tile([given_m, 0.002, 0.002], (n, 1))
    attitude = Attitude(
        node=np.arange(n),
        depth=depth + noise,
        roll=level,
        pitch=level,
        sigma=sigma * np.sqrt([nodes_per_reading, 1, 1]),
        nodes_per_reading=np.full(n, float(nodes_per_reading)),
        tray_direction=np.ones(n),
        tray_sigma=np.zeros(n),
    )
    measured = SimpleNamespace(
        attitude=attitude,
        rig=scene.rig,
        tracks=scene.tracks,
        trajectory=SimpleNamespace(tray=level),
        lenses=np.zeros((2, 36)),
    )
    nodes = poses.from_rpy(np.c_[level, level, depth], np.zeros((n, 3)))
    return measured, SimpleNamespace(nodes=nodes, tray=level, navigation=np.zeros(6))


@pytest.fixture
def depth_weight(scene, monkeypatch):
    """The sigma of depths that a round settles, in the sigma given."""
    monkeypatch.setattr(
        "hullrecon.adjustment.problem.weighting.estimate_pixel_sigmas",
        lambda *_: WEIGHTS.by_response,
    )

    def found(*of, **more):
        measured, state = dive(scene, *of, **more)
        return estimate_weights(measured, state, None, WEIGHTS, PRODUCT).depth

    return found


@pytest.fixture
def seen_with(scene):
    """Returns the sigmas that images get, of observations whose errors have these sigmas, by the
    detector's response.
    """

    def found(response, sigma_px):
        t, rng = scene.tracks, np.random.default_rng(4)
        noise = [sigma_px[:, None] * rng.standard_normal((len(t.node), 2)) for _ in range(2)]
        tracks = replace(t, top=t.top + noise[0], bottom=t.bottom + noise[1], response=response)
        measured = SimpleNamespace(rig=scene.rig, tracks=tracks, lens_steps=())
        state = State(
            nodes=scene.nodes,
            tray=scene.tray,
            landmark=scene.points,
            mounts=scene.rig.mounts,
            navigation=np.zeros(6),
            hull=None,
        )
        every = [np.isfinite(pixels[:, 0]) for pixels in (t.top, t.bottom)]
        landmarks, rays = np.unique(
            np.r_[t.landmark[every[0]], t.landmark[every[1]]], return_counts=True
        )
        of_each = np.zeros(len(scene.points), np.int32)
        of_each[landmarks] = rays
        chosen = SimpleNamespace(top=every[0], bottom=every[1], landmarks=landmarks, rays=of_each)
        found = estimate_pixel_sigmas(measured, state, chosen, WEIGHTS)
        return found.pixel * found.ratio(response)

    return found


def test_an_observation_gets_the_sigma_of_those_of_like_response(scene, seen_with) -> None:
    response = np.random.default_rng(5).uniform(0.02, 0.1, len(scene.points))[scene.tracks.landmark]
    true_px = 0.003 / response
    np.testing.assert_allclose(seen_with(response, true_px), true_px, rtol=0.2)


def test_where_the_response_says_nothing_all_have_one_sigma(scene, seen_with) -> None:
    response = np.random.default_rng(5).uniform(0.008, 0.1, len(scene.points))[
        scene.tracks.landmark
    ]
    np.testing.assert_allclose(seen_with(response, np.full(len(response), 0.2)), 0.2, rtol=0.1)
    np.testing.assert_allclose(
        seen_with(np.full(len(response), 0.02), np.full(len(response), 0.2)), 0.2, rtol=0.1
    )


def test_corners_have_a_sigma_of_their_own(scene, seen_with) -> None:
    corner = scene.tracks.landmark % 2 == 0
    found = seen_with(np.where(corner, np.nan, 0.02), np.where(corner, 0.4, 0.1))
    np.testing.assert_allclose(found[corner], 0.4, rtol=0.1)
    np.testing.assert_allclose(found[~corner], 0.1, rtol=0.1)


def test_depths_get_the_sigma_of_their_residuals(depth_weight) -> None:
    assert depth_weight(np.full(400, 3.0), noise_m=0.004) == pytest.approx(0.004 / GIVEN_M, rel=0.1)


def test_nodes_sharing_reading_do_not_improve_its_sigma(depth_weight) -> None:
    """The sigma at a node is that of the reading times the root of the nodes that share it, before
    and after.
    """
    found = depth_weight(np.full(400, 3.0), noise_m=0.004, nodes_per_reading=25)
    assert found == pytest.approx(depth_weight(np.full(400, 3.0), noise_m=0.004))


def test_shared_readings_count_once_against_density(scene, depth_weight) -> None:
    depth = np.linspace(2.0, 3.0, 400)
    found = depth_weight(depth, noise_m=0.0, nodes_per_reading=25)
    assert found == pytest.approx(scene.rig.priors.density_sigma * 4 * np.std(depth) / GIVEN_M)


def test_depths_tell_scale_no_better_than_density(scene, depth_weight) -> None:
    depth = np.linspace(2.0, 3.0, 400)
    assert depth_weight(depth, noise_m=0.0) == pytest.approx(
        scene.rig.priors.density_sigma * 20 * np.std(depth) / GIVEN_M
    )


def test_where_the_density_was_measured_many_depths_tell_more(
    scene, depth_weight, monkeypatch
) -> None:
    depth, sigma = np.linspace(1.0, 5.0, 400), 3e-4
    monkeypatch.setattr(scene, "rig", scene.rig.with_priors(density_sigma=sigma))
    assert depth_weight(depth, noise_m=0.0) == pytest.approx(sigma * 20 * np.std(depth) / GIVEN_M)


def test_depths_that_were_not_measured_do_not_count(scene) -> None:
    measured, _ = dive(scene, np.full(400, 3.0), 0.004)
    measured.attitude.sigma[:300, 0], measured.attitude.nodes_per_reading[:300] = 1e3, 0
    assert depth_sigma(measured, replace(WEIGHTS, depth=0.5)) == pytest.approx(0.5 * GIVEN_M)


def test_no_sigma_grows_beyond_what_navigation_gave(depth_weight) -> None:
    assert depth_weight(np.full(400, 3.0), noise_m=0.5) == 1.0


def test_depths_that_no_pressure_gave_keep_their_sigma(depth_weight) -> None:
    assert depth_weight(np.full(400, 3.0), noise_m=0.004, given_m=10.0, nodes_per_reading=0) == 1.0


@pytest.mark.parametrize(
    ("strategy", "camera"), [(Strategy(estimate_sigmas=False), True), (PRODUCT, False)]
)
def test_as_published_and_without_a_camera_all_weights_stay(scene, strategy, camera) -> None:
    measured, state = dive(scene, np.full(400, 3.0), 0.004)
    measured.tracks = measured.tracks if camera else None
    assert estimate_weights(measured, state, None, WEIGHTS, strategy) is WEIGHTS


def test_the_sigma_of_a_depth_is_told_in_metres(scene) -> None:
    measured, _ = dive(scene, np.full(4, 3.0), 0.0)
    assert depth_sigma(measured, replace(WEIGHTS, depth=0.3)) == pytest.approx(0.3 * GIVEN_M)
    assert np.isnan(depth_sigma(dive(scene, np.zeros(0), 0.0)[0], WEIGHTS))

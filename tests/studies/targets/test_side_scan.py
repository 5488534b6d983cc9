# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Targets in side-scan sonar, by thresholds and by a cascade."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.targets import cascade, haar
from hullrecon.studies.targets.detector_trials import CascadeTrial, try_cascade, try_thresholds
from hullrecon.studies.targets.side_scan import (
    ACROSS_M,
    Kind,
    Thing,
    column_of,
    draw_thing,
    draw_tile,
    row_of,
)
from hullrecon.studies.targets.thresholds import detect_by_thresholds

ROWS = 60
AT = {"along_m": 3.0, "range_m": 25.0, "width_m": 1.2, "brightness": 3.0, "shade": 0.2}


@pytest.fixture(scope="module")
def trial() -> CascadeTrial:
    return try_cascade(1, 45, positives=500, negatives=1250)


def tile_with(kind: Kind, highlight_m: float, shadow_m: float) -> np.ndarray:
    thing = Thing(kind=kind, highlight_m=highlight_m, shadow_m=shadow_m, **AT)
    return draw_tile(np.random.default_rng(0), ROWS, [thing])


def test_shadow_is_as_long_as_the_height_casts() -> None:
    thing = draw_thing(np.random.default_rng(0), Kind.TARGET, 3.0, 30.0, altitude_m=4.0)
    height_m = thing.highlight_m
    # The ray over the top, at 30 m + height, meets the floor where it has fallen 4 m.
    end_m = 30.0 + thing.length_m
    assert (end_m - 30.0 - height_m) / end_m == pytest.approx(height_m / 4.0)


def test_a_target_is_found_at_its_spot() -> None:
    found = detect_by_thresholds(tile_with(Kind.TARGET, 0.4, 3.0))
    assert found.row == pytest.approx([row_of(3.0)], abs=2)
    assert found.column * ACROSS_M == pytest.approx([column_of(25.0) * ACROSS_M], abs=0.4)


@pytest.mark.parametrize(
    ("kind", "highlight_m", "shadow_m"),
    [(Kind.BRIGHT, 0.4, 0.0), (Kind.DARK, 0.0, 3.0), (Kind.HOLLOW, 0.4, 3.0)],
)
def test_what_is_no_target_is_refused(kind: Kind, highlight_m: float, shadow_m: float) -> None:
    assert len(detect_by_thresholds(tile_with(kind, highlight_m, shadow_m)).row) == 0


def test_thresholds_find_targets_and_little_else() -> None:
    tried = try_thresholds(7, 20)
    assert tried.found[Kind.TARGET] >= 0.975
    assert max(tried.found[kind] for kind in (Kind.BRIGHT, Kind.DARK, Kind.HOLLOW)) <= 0.05


def test_four_look_ups_sum_a_rectangle(rng: np.random.Generator) -> None:
    pictures = rng.uniform(size=(3, 9, 12))
    integral = haar.integral_images(pictures)
    expected = pictures[:, 2:7, 3:11].sum(axis=(1, 2))
    np.testing.assert_allclose(haar.sum_in(integral, 2, 7, 3, 11), expected, rtol=1e-12)


def test_eight_to_one_is_the_far_part_less_the_near(rng: np.random.Generator) -> None:
    pictures = rng.uniform(size=(2, 6, 18))
    shape = haar.Rectangles(first=8, second=1, along="range")
    integral = haar.integral_images(pictures)
    means = pictures[:, :, :16].mean(axis=(1, 2)) - pictures[:, :, 16:].mean(axis=(1, 2))
    np.testing.assert_allclose(shape.value(integral), means, rtol=1e-12)
    sums = pictures[:, :, :16].sum(axis=(1, 2)) - pictures[:, :, 16:].sum(axis=(1, 2))
    np.testing.assert_allclose(shape.value(integral, by_sums=True), sums, rtol=1e-12)


def test_centroid_distance_of_a_disc_is_its_radius() -> None:
    row, column = np.mgrid[:48, :48]
    picture = np.where((row - 24) ** 2 + (column - 24) ** 2 < 15**2, 0.1, 1.0)
    mean, spread, place, share = haar.centroid_distances(picture)
    assert mean * 48 == pytest.approx(14.3, abs=0.5)
    assert spread < 0.05
    assert place == pytest.approx(0.5, abs=0.02)
    assert share == pytest.approx(np.pi * 15**2 / 48**2, rel=0.02)


def test_adaboost_takes_the_feature_of_least_error(rng: np.random.Generator) -> None:
    is_target = np.arange(200) < 80
    values = rng.standard_normal((200, 3))
    values[:, 1] += np.where(is_target, -5.0, 5.0)
    first = cascade.Boost(values, is_target).add()[0]
    assert first.feature == 1
    np.testing.assert_array_equal(first.is_target(values), is_target)


def test_wrongly_judged_samples_weigh_more_next() -> None:
    # Either feature errs at one sample: the next has to be right where the first is wrong.
    is_target = np.array([True, True, True, False, False, False])
    values = np.array([[0.0, 9], [3, 8], [4, 0], [1, 1], [2, 1], [1.5, 1]])
    boost = cascade.Boost(values, is_target)
    first = boost.add()[0]
    second = boost.add()[1]
    missed = first.is_target(values) != is_target
    assert missed.sum() == 1
    assert (second.is_target(values) == is_target)[missed].all()


def test_layers_can_only_refuse(trial: CascadeTrial) -> None:
    assert (np.diff(trial.by_table.false) <= 0).all()
    assert (np.diff(trial.by_table.detection) <= 0).all()


def test_table_of_layers_falls_to_99_and_a_twentieth_percent() -> None:
    detection, false, count = np.array(cascade.TARGETS).T
    assert detection.tolist() == [0.999, 0.997, 0.996, 0.995, 0.995, 0.993, 0.99]
    assert false.tolist() == [0.5, 0.2, 0.1, 0.05, 0.01, 0.005, 0.0005]
    assert count.tolist() == [1, 2, 6, 11, 20, 30, 30]


def test_first_feature_is_some_8_to_1_dark_to_bright(trial: CascadeTrial) -> None:
    name = trial.names[trial.layers[0].weak[0].feature]
    assert "range" in name
    assert 6 <= int(name.split(":")[0]) <= 10


def test_cascade_detects_99_percent_at_1_percent_false_with_4_features(
    trial: CascadeTrial,
) -> None:
    assert trial.by_count.detection[-1] >= 0.98  # of 360 targets
    assert trial.by_count.false[-1] <= 0.01
    assert trial.by_count.features.sum() <= 4


def test_training_ends_where_no_more_is_asked() -> None:
    is_target = np.arange(400) < 200
    values = np.where(is_target, 1.0, -1.0)[:, None] + 0.1 * np.sin(np.arange(400))[:, None]
    layers = cascade.train_cascade(values, is_target, values, is_target)
    assert len(layers) == 1

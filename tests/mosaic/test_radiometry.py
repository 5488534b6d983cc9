# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from hullrecon.mosaic.imagery import radiometry
from hullrecon.mosaic.imagery.radiometry import (
    FIELD,
    LightModel,
    LightSamples,
    first_fields,
    solve_light,
)


def lamp() -> np.ndarray:
    """A lamp that falls to a half at the corners: logarithms about zero, one channel."""
    v, u = np.meshgrid(np.linspace(-1, 1, FIELD[0]), np.linspace(-1, 1, FIELD[1]), indexing="ij")
    field = np.log(0.5) * (u**2 + v**2) / 2
    return (field - field.mean())[..., None]


def dive(gain: np.ndarray, seed: int = 0) -> LightSamples:
    """Each view sees 400 of 2000 scene points at random cells, under the lamp and its own gain."""
    rng = np.random.default_rng(seed)
    scene = rng.normal(4.0, 0.3, 2000)
    view = np.repeat(np.arange(len(gain)), 400)
    texel = rng.integers(0, 2000, len(view))
    cell = rng.integers(0, FIELD[0] * FIELD[1], len(view))
    value = scene[texel] + lamp().reshape(-1)[cell] + gain[view] + rng.normal(0, 0.02, len(view))
    return LightSamples(
        view=view,
        texel=texel,
        cell=cell,
        log_value=value[:, None],
        camera=np.zeros(len(gain), np.int64),
    )


def test_the_lamp_is_told_from_the_scene() -> None:
    light = solve_light(dive(np.zeros(80)), [np.zeros((*FIELD, 1))], rounds=4)
    inner = np.s_[3:-3, 3:-3]
    assert np.abs(light.log_field[0] - lamp())[inner].max() < 0.05


def test_each_images_brightness_is_found() -> None:
    gain = np.where(np.arange(80) % 5 == 0, 0.15, -0.0375)
    light = solve_light(dive(gain), [lamp()])
    np.testing.assert_allclose(light.log_gain, gain, atol=0.03)


def test_a_corrected_image_of_an_even_plate_is_even() -> None:
    import cv2

    shown = cv2.resize(np.exp(lamp()[..., 0]), (128, 96), interpolation=cv2.INTER_CUBIC)
    picture = np.rint(100 * shown * np.exp(0.2))[..., None].astype(np.uint8)
    even = LightModel(log_field=(lamp(),), log_gain=np.array([0.2])).correct(
        picture, np.s_[:, :], camera=0, view=0
    )
    np.testing.assert_allclose(even[8:-8, 8:-8], 100, atol=2.0)


def test_a_dark_corner_is_not_blown_up_without_end() -> None:
    picture = np.full((48, 64, 1), 10, np.uint8)
    light = LightModel(log_field=(np.full((*FIELD, 1), -9.0),), log_gain=np.zeros(1))
    assert light.correct(picture, np.s_[:, :], 0, 0).max() == pytest.approx(80.0)


def test_the_first_field_is_the_cameras_own_median() -> None:
    bright = np.full((48, 64, 3), 200, np.uint8)
    dark_left = bright.copy()
    dark_left[:, :32] = 50
    thumbnails = [bright, bright, bright, dark_left, dark_left, dark_left]
    fields = first_fields(thumbnails, np.array([0, 0, 0, 1, 1, 1]))
    np.testing.assert_allclose(fields[0], 0, atol=1e-9)
    assert fields[1][12, 4, 0] - fields[1][12, 28, 0] == pytest.approx(np.log(0.25), abs=0.02)


def test_the_first_field_takes_no_more_memory_for_more_images(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(radiometry, "MOST_IMAGES", 60)
    peaks = []
    for count in (60, 600):
        thumbnails = [np.full((48, 64, 3), 100, np.uint8)] * count
        tracemalloc.start()
        first_fields(thumbnails, np.zeros(count, np.int64))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0]


def test_first_field_takes_images_of_whole_dive(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two thirds of the dive have the lamp to the left: the median is theirs wherever they lie."""
    left, right = (np.full((48, 64, 3), 100, np.uint8) for _ in range(2))
    left[:, 32:], right[:, :32] = 40, 40
    for thumbnails in ([left] * 400 + [right] * 200, [right] * 200 + [left] * 400):
        whole = first_fields(thumbnails, np.zeros(600, np.int64))
        with monkeypatch.context() as patched:
            patched.setattr(radiometry, "MOST_IMAGES", 7)
            np.testing.assert_allclose(
                first_fields(thumbnails, np.zeros(600, np.int64)), whole, atol=1e-12
            )

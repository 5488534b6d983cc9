# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The preview."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from PIL import Image

from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.output.deliverables import Caption, preview_png, stretch_contrast

GRID = TexelGrid(west=-0.8, north=0.6, step_m=0.01, height=120, width=160)


def checks() -> np.ndarray:
    picture = np.zeros((120, 160, 4), np.uint8)
    picture[..., :3] = np.where((np.indices((120, 160)).sum(axis=0) // 20) % 2, 90, 140)[..., None]
    picture[:, 20:, 3] = 255
    return picture


def test_the_preview_is_a_picture_with_the_same_bytes_each_time() -> None:
    caption = Caption(
        title="Optical mosaic",
        legend="a legend",
        frame="M",
        frame_spacing_m=0.6,
        flips=(True, False),
    )
    first, second = (preview_png(checks(), -0.8, 0.6, 0.01, caption) for _ in range(2))
    assert first == second
    with Image.open(BytesIO(first)) as picture:
        assert picture.width > picture.height > 500
        assert "Software" not in picture.info


def test_a_flipped_preview_shows_the_unseen_side_on_the_right() -> None:
    plain, flipped = (
        np.asarray(
            Image.open(
                BytesIO(
                    preview_png(
                        checks(),
                        -0.8,
                        0.6,
                        0.01,
                        Caption(title="t", legend="l", frame="M", frame_spacing_m=None, flips=f),
                    )
                )
            ).convert("RGB")
        )
        for f in ((False, False), (True, False))
    )
    unseen = [
        np.mean(np.nonzero((p == (0xE9, 0xED, 0xF1)).all(axis=2))[1]) / p.shape[1]
        for p in (plain, flipped)
    ]
    assert unseen[0] < 0.4
    assert unseen[1] > 0.6


def test_stretching_spreads_the_seen_brightness_and_leaves_alpha() -> None:
    picture = checks()
    out = stretch_contrast(picture)
    np.testing.assert_array_equal(out[..., 3], picture[..., 3])
    assert np.ptp(out[:, 20:, 0].astype(int)) > 200


def test_stretching_an_empty_mosaic_changes_nothing() -> None:
    empty = np.zeros((4, 5, 4), np.uint8)
    np.testing.assert_array_equal(stretch_contrast(empty), empty)


def test_colour_is_kept_while_brightness_is_spread() -> None:
    picture = np.full((20, 20, 4), 255, np.uint8)
    picture[..., :3] = [100, 120, 80]
    picture[6:12, :, :3] = [110, 130, 90]
    picture[12:, :, :3] = [120, 140, 100]
    out = stretch_contrast(picture).astype(int)
    # 40 apart before, 1.25 times at most
    np.testing.assert_allclose(out[8, 0, 1] - out[8, 0, 2], 40 * 1.25, atol=2)
    assert out[15, 0, :3].mean() - out[0, 0, :3].mean() > 100


def test_an_even_mosaic_is_not_stretched_to_noise() -> None:
    rng = np.random.default_rng(0)
    picture = np.full((40, 40, 4), 255, np.uint8)
    picture[..., :3] = rng.integers(99, 102, (40, 40, 1))
    assert np.ptp(stretch_contrast(picture)[..., 0].astype(int)) <= 2 * 220 / 25 + 1


def test_a_gray_mosaic_is_shown_in_gray() -> None:
    gray = checks()[..., [0, 3]]
    caption = Caption(title="Sonar mosaic", legend="a legend", frame="g")
    shown = np.asarray(
        Image.open(BytesIO(preview_png(gray, -0.8, 0.6, 0.01, caption))).convert("RGB")
    ).astype(int)
    middle = shown[
        shown.shape[0] // 3 : shown.shape[0] // 2, shown.shape[1] // 2 : -shown.shape[1] // 6
    ]
    assert np.ptp(middle, axis=2).max() == 0
    assert np.ptp(middle[..., 0]) > 100


def test_a_long_legend_does_not_widen_the_picture() -> None:
    short, long = (
        Image.open(
            BytesIO(
                preview_png(checks(), -0.8, 0.6, 0.01, Caption(title="t", legend=text, frame="M"))
            )
        )
        for text in ("a legend", "a legend of many words " * 20)
    )
    assert long.size == short.size

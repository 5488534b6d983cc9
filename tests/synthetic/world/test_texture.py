# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.synthetic.atlas import Atlas, paint_atlas
from hullrecon.synthetic.items import Item
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.texture import value_noise

WINDOW = ((10.0, 11.5), (4.0, 5.0))


def atlas(items: tuple[Item, ...] = (), seed: int = 1) -> Atlas:
    return paint_atlas(spec_from(seed=seed), items, *WINDOW, 0.002)


def test_noise_is_smooth_within_cell_and_unrelated_beyond() -> None:
    noise = value_noise(np.random.default_rng(0), (400, 400), 20.0)
    assert noise.shape == (400, 400)
    step = lambda k: np.abs(noise[:, k:] - noise[:, :-k]).mean()  # noqa: E731
    assert step(1) < 0.15 * step(40)


def test_atlas_covers_its_window() -> None:
    assert atlas().image.shape == (500, 750, 3)


def test_looking_up_texel_gives_its_colour() -> None:
    made = atlas()
    row, column = np.array([[7, 300]]), np.array([[11, 600]])
    a = (10.0 + 0.002 * column).astype(np.float32)
    g = (4.0 + 0.002 * row).astype(np.float32)
    expected = made.image[row, column] / 255
    np.testing.assert_allclose(made.look_up(a, g, np.ones((1, 2), bool)), expected, atol=0.02)


def test_looking_up_between_texels_is_linear() -> None:
    made = Atlas(
        np.tile(np.arange(0, 200, 10, np.uint8)[:, None, None], (1, 20, 3)), (0.0, 0.0), 0.1
    )
    value = made.look_up(
        np.full((1, 1), 0.55, np.float32), np.full((1, 1), 0.75, np.float32), np.ones((1, 1), bool)
    )
    np.testing.assert_allclose(value[0, 0] * 255, 75, atol=1)


def test_same_seed_same_texture() -> None:
    np.testing.assert_array_equal(atlas().image, atlas().image)
    assert (atlas().image != atlas(seed=2).image).any()


def test_there_is_detail_at_every_scale() -> None:
    grey = atlas().image.mean(2)
    for width in (2, 8, 32):
        blocks = (
            grey[: 500 // width * width, : 750 // width * width]
            .reshape(500 // width, width, 750 // width, width)
            .mean((1, 3))
        )
        assert np.abs(np.diff(blocks, axis=0)).mean() > 2.5


def test_what_is_not_seen_does_not_widen_look_up() -> None:
    """A ray that misses the hull has no chart coordinates; OpenCV takes no image wider than 32,767
    pixels.
    """
    wide = Atlas(np.full((8, 40_000, 3), 51, np.uint8), (0.0, 0.0), 0.001)
    along = np.array([[39.9, 0.0]], np.float32)
    value = wide.look_up(along, np.full((1, 2), 0.004, np.float32), np.array([[True, False]]))
    np.testing.assert_allclose(value[0, 0], 0.2)

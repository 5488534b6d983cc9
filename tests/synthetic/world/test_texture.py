# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.world.items import Item, Kind
from hullrecon.synthetic.world.plate_atlas import paint_atlas
from hullrecon.synthetic.world.texture import Atlas, value_noise

WINDOW = ((10.0, 11.5), (4.0, 5.0))


def atlas(items: tuple[Item, ...] = (), seed: int = 1) -> Atlas:
    return paint_atlas(spec_from(seed=seed), items, *WINDOW, 0.002)


def test_noise_is_smooth_within_a_cell_and_unrelated_beyond() -> None:
    noise = value_noise(np.random.default_rng(0), (400, 400), 20.0)
    assert noise.shape == (400, 400)
    step = lambda k: np.abs(noise[:, k:] - noise[:, :-k]).mean()  # noqa: E731
    assert step(1) < 0.15 * step(40)


def test_the_atlas_covers_its_window() -> None:
    assert atlas().image.shape == (500, 750, 3)


def test_looking_up_a_texel_gives_its_colour() -> None:
    made = atlas()
    row, column = np.array([[7, 300]]), np.array([[11, 600]])
    a = (10.0 + 0.002 * column).astype(np.float32)
    g = (4.0 + 0.002 * row).astype(np.float32)
    expected = made.image[row, column] / 255
    np.testing.assert_allclose(made.look_up(a, g, np.ones((1, 2), bool)), expected, atol=0.02)


def test_looking_up_between_texels_is_linear() -> None:
    made = Atlas(np.tile(np.arange(0, 200, 10, np.uint8)[:, None, None], (1, 20, 3)), (0.0, 0.0), 0.1)
    value = made.look_up(np.full((1, 1), 0.55, np.float32), np.full((1, 1), 0.75, np.float32), np.ones((1, 1), bool))
    np.testing.assert_allclose(value[0, 0] * 255, 75, atol=1)


def test_same_seed_same_texture() -> None:
    np.testing.assert_array_equal(atlas().image, atlas().image)
    assert (atlas().image != atlas(seed=2).image).any()


def test_there_is_detail_at_every_scale() -> None:
    grey = atlas().image.mean(2)
    for width in (2, 8, 32):
        blocks = (
            grey[: 500 // width * width, : 750 // width * width].reshape(500 // width, width, 750 // width, width).mean((1, 3))
        )
        assert np.abs(np.diff(blocks, axis=0)).mean() > 2.5


@pytest.mark.parametrize(("kind", "bright"), [("digits", 0.2), ("stripe", 0.9), ("ring", 0.2)])
def test_paint_is_bright(kind: Kind, bright: float) -> None:
    item = Item(kind, 10.75, 4.5, 0.0, (0.4, 0.2))
    before, after = atlas().image.astype(float), atlas((item,)).image.astype(float)
    rows, columns = slice(200, 300), slice(275, 475)
    changed = (after - before)[rows, columns].max(2) > 20
    assert changed.mean() > bright
    assert np.abs(after - before)[:150].max() == 0


def test_a_stripe_is_where_it_was_planted() -> None:
    item = Item("stripe", 10.4, 4.3, 0.0, (0.3, 0.06))
    changed = np.abs(atlas((item,)).image.astype(int) - atlas().image.astype(int)).max(2) > 10
    row, column = np.argwhere(changed).mean(0)
    assert 4.0 + 0.002 * row == pytest.approx(4.3, abs=0.01)
    assert 10.0 + 0.002 * column == pytest.approx(10.4, abs=0.01)


def test_digits_read_from_outside_on_the_port_side() -> None:
    """The 3 stands left of the 2: forward, and the 2 has its foot at the bottom."""
    item = Item("digits", 10.75, 4.5, 0.0, (0.8, 0.5))
    mask = np.abs(atlas((item,)).image.astype(int) - atlas().image.astype(int)).max(2) > 30
    seen = mask[::-1, ::-1]  # girth upwards, forward to the left
    right = seen[:, : seen.shape[1]]
    rows, columns = np.nonzero(right)
    two = (columns > columns.mean()) & (columns < columns.max() + 1)
    lowest = rows[two] > np.quantile(rows[two], 0.85)
    assert np.ptp(columns[two][lowest]) > 0.7 * np.ptp(columns[two])


def test_an_item_outside_the_window_changes_nothing() -> None:
    np.testing.assert_array_equal(atlas((Item("ring", 30.0, 4.5, 0.0, (0.3, 0.3)),)).image, atlas().image)


def test_what_is_not_seen_does_not_widen_the_look_up() -> None:
    """A ray that misses the hull has no chart coordinates; OpenCV takes no image wider than 32,767 pixels."""
    wide = Atlas(np.full((8, 40_000, 3), 51, np.uint8), (0.0, 0.0), 0.001)
    along = np.array([[39.9, 0.0]], np.float32)
    value = wide.look_up(along, np.full((1, 2), 0.004, np.float32), np.array([[True, False]]))
    np.testing.assert_allclose(value[0, 0], 0.2)

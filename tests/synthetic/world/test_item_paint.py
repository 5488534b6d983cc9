# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.synthetic.atlas import Atlas, paint_atlas
from hullrecon.synthetic.items import Item, Kind
from hullrecon.synthetic.options import spec_from

WINDOW = ((10.0, 11.5), (4.0, 5.0))


def atlas(items: tuple[Item, ...] = (), seed: int = 1) -> Atlas:
    return paint_atlas(spec_from(seed=seed), items, *WINDOW, 0.002)


@pytest.mark.parametrize(("kind", "bright"), [("digits", 0.2), ("stripe", 0.9), ("ring", 0.2)])
def test_paint_is_bright(kind: Kind, bright: float) -> None:
    item = Item(kind, 10.75, 4.5, 0.0, (0.4, 0.2))
    before, after = atlas().image.astype(float), atlas((item,)).image.astype(float)
    rows, columns = slice(200, 300), slice(275, 475)
    changed = (after - before)[rows, columns].max(2) > 20
    assert changed.mean() > bright
    assert np.abs(after - before)[:150].max() == 0


def test_stripe_is_where_it_was_placed() -> None:
    item = Item("stripe", 10.4, 4.3, 0.0, (0.3, 0.06))
    changed = np.abs(atlas((item,)).image.astype(int) - atlas().image.astype(int)).max(2) > 10
    row, column = np.argwhere(changed).mean(0)
    assert 4.0 + 0.002 * row == pytest.approx(4.3, abs=0.01)
    assert 10.0 + 0.002 * column == pytest.approx(10.4, abs=0.01)


def test_digits_read_from_outside_on_port_side() -> None:
    """The 3 stands left of the 2: forward, and the 2 has its foot at the bottom."""
    item = Item("digits", 10.75, 4.5, 0.0, (0.8, 0.5))
    mask = np.abs(atlas((item,)).image.astype(int) - atlas().image.astype(int)).max(2) > 30
    seen = mask[::-1, ::-1]  # girth upwards, forward to the left
    right = seen[:, : seen.shape[1]]
    rows, columns = np.nonzero(right)
    two = (columns > columns.mean()) & (columns < columns.max() + 1)
    lowest = rows[two] > np.quantile(rows[two], 0.85)
    assert np.ptp(columns[two][lowest]) > 0.7 * np.ptp(columns[two])


def test_item_outside_window_changes_nothing() -> None:
    np.testing.assert_array_equal(
        atlas((Item("ring", 30.0, 4.5, 0.0, (0.3, 0.3)),)).image, atlas().image
    )

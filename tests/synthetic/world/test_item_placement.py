# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.errors import UsageError
from hullrecon.synthetic.built_hull import place_items
from hullrecon.synthetic.items import MARKS, STRUCTURES, Item
from hullrecon.synthetic.options import DiveSpec, Items, spec_from

ROOM = ((10.0, 16.0), (3.0, 6.0))


def test_there_are_as_many_of_each_as_asked_for() -> None:
    items = place_items(spec_from(structures=6, marks=3, barnacles=2), *ROOM)
    kinds = [item.kind for item in items]
    assert sum(kind in STRUCTURES for kind in kinds) == 6
    assert sum(kind in MARKS for kind in kinds) == 3
    assert kinds.count("barnacles") == 2


def test_items_keep_clear_of_each_other_and_inside() -> None:
    items = place_items(spec_from(structures=8, marks=3), *ROOM)
    for k, a in enumerate(items):
        assert ROOM[0][0] <= a.along_m <= ROOM[0][1]
        assert ROOM[1][0] <= a.girth_m <= ROOM[1][1]
        for b in items[:k]:
            assert (
                np.hypot(a.along_m - b.along_m, a.girth_m - b.girth_m) > a.reach_m() + b.reach_m()
            )


def test_paint_has_no_height_and_recesses_go_in() -> None:
    for item in place_items(spec_from(structures=5, marks=3), *ROOM):
        assert (item.height_m == 0) == (item.kind in MARKS)
        assert (item.height_m < 0) == (item.kind == "recess")


def test_second_of_kind_has_another_size() -> None:
    items = [
        i
        for i in place_items(spec_from(structures=6, marks=0, barnacles=0), *ROOM)
        if i.kind == "cylinder"
    ]
    assert len({item.height_m for item in items}) == 2


def test_given_items_are_taken_as_they_are() -> None:
    given = (Item("box", 1.0, 2.0, 0.1, (0.2, 0.2)),)
    assert place_items(DiveSpec(items=Items(placed=given)), *ROOM) == given


def test_too_many_are_refused_with_advice() -> None:
    with pytest.raises(UsageError, match="fewer structures"):
        place_items(spec_from(structures=60), (0.0, 1.0), (0.0, 1.0))


def test_seed_decides_where() -> None:
    assert place_items(spec_from(seed=5), *ROOM) == place_items(spec_from(seed=5), *ROOM)
    assert place_items(spec_from(seed=5), *ROOM) != place_items(spec_from(seed=6), *ROOM)


def test_second_dive_of_hull_has_same_items() -> None:
    assert place_items(spec_from(seed=9, hull_seed=5), *ROOM) == place_items(
        spec_from(seed=5), *ROOM
    )


def test_what_changed_since_is_what_was_asked_for() -> None:
    before = place_items(spec_from(seed=5, structures=4), *ROOM)
    after = place_items(
        spec_from(seed=9, hull_seed=5, structures=4, added=3, removed=1, grown_m=0.03), *ROOM
    )
    assert after[0].height_m == pytest.approx(before[0].height_m + 0.03)
    assert [i for i in before if i not in after] == [before[0], before[3]]
    assert len([i for i in after if i not in before]) == 4


def test_what_is_added_keeps_clear_of_what_went() -> None:
    before = place_items(spec_from(seed=5, structures=4), *ROOM)
    added = place_items(spec_from(seed=9, hull_seed=5, structures=4, added=3, removed=1), *ROOM)[
        -3:
    ]
    for item in added:
        assert (
            np.hypot(item.along_m - before[3].along_m, item.girth_m - before[3].girth_m)
            > item.reach_m()
        )


def test_what_is_to_grow_grows_by_so_much() -> None:
    assert place_items(spec_from(seed=5, structures=1, grown_m=0.02), *ROOM)[
        0
    ].height_m == pytest.approx(0.13)


def test_more_changes_than_structures_are_refused() -> None:
    with pytest.raises(UsageError, match="too few to change"):
        place_items(spec_from(structures=1, removed=2), *ROOM)

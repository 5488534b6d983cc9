# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Structures, painted marks and barnacles placed at random, clear of each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.errors import UsageError
from hullrecon.synthetic.spec import DiveSpec
from hullrecon.synthetic.world.items import MARKS, STRUCTURES, Item, Kind

# Height, size along and across, m, of the k-th of a kind, taken in turn.
SHAPES: dict[Kind, tuple[tuple[float, float, float], ...]] = {
    "cylinder": ((0.11, 0.16, 0.16), (0.09, 0.2, 0.2)),
    "dome": ((0.12, 0.3, 0.3), (0.1, 0.24, 0.24)),
    "box": ((0.10, 0.26, 0.2), (0.13, 0.18, 0.3)),
    "lump": ((0.14, 0.42, 0.3), (0.07, 0.26, 0.22)),
    "recess": ((-0.04, 0.25, 0.25), (-0.06, 0.2, 0.2)),
    "digits": ((0.0, 0.5, 0.3),),
    "stripe": ((0.0, 0.8, 0.09),),
    "ring": ((0.0, 0.34, 0.34),),
    "barnacles": ((0.016, 0.6, 0.4), (0.018, 0.5, 0.35)),
}
CLEAR_M = 0.05  # between items


def place_items(
    spec: DiveSpec, along_m: tuple[float, float], girth_m: tuple[float, float]
) -> tuple[Item, ...]:
    """Place the dive's items at random within a window of the chart, clear of each other.

    Structures first, then marks, then barnacles, then structures added since. Raises UsageError
    when they do not fit, or more are to be changed than there are.
    """
    if spec.items.placed is not None:
        return spec.items.placed
    wanted = spec.items
    if wanted.structures < wanted.removed + (wanted.grown_m != 0):
        raise UsageError(
            f"{wanted.structures} structures are too few to change so many",
            remedy="ask for more --structures",
        )
    kinds = [STRUCTURES[k % len(STRUCTURES)] for k in range(wanted.structures)]
    kinds += [MARKS[k % len(MARKS)] for k in range(wanted.marks)]
    kinds += ["barnacles"] * wanted.barnacles
    window = (along_m, girth_m)
    before = _draw(spec.hull_random("items"), kinds, [], *window)
    since = [
        STRUCTURES[k % len(STRUCTURES)]
        for k in range(wanted.structures, wanted.structures + wanted.added)
    ]
    added = _draw(spec.hull_random("added items"), since, before, *window)
    if wanted.grown_m:
        before[0] = _grow(before[0], wanted.grown_m)
    del before[wanted.structures - wanted.removed : wanted.structures]
    return (*before, *added)


def _draw(
    random: np.random.Generator,
    kinds: list[Kind],
    taken: list[Item],
    along_m: tuple[float, float],
    girth_m: tuple[float, float],
) -> list[Item]:
    """Draw items of those kinds, clear of each other and of those taken."""
    out = list(taken)
    for kind in kinds:
        sizes = SHAPES[kind]
        height, *size = sizes[sum(item.kind == kind for item in out) % len(sizes)]
        turn = float(random.uniform(-0.3, 0.3))
        item = Item(kind, 0.0, 0.0, height, (size[0], size[1]), turn)
        out.append(_clear_place(random, item, out, along_m, girth_m))
    return out[len(taken) :]


def _grow(item: Item, by_m: float) -> Item:
    """Raise an item by so much off the steel; a recess goes deeper."""
    return replace(item, height_m=item.height_m + (by_m if item.height_m > 0 else -by_m))


def _clear_place(
    random: np.random.Generator,
    item: Item,
    taken: list[Item],
    along_m: tuple[float, float],
    girth_m: tuple[float, float],
) -> Item:
    for _ in range(4000):
        a, g = float(random.uniform(*along_m)), float(random.uniform(*girth_m))
        if all(
            np.hypot(a - o.along_m, g - o.girth_m) > item.reach_m() + o.reach_m() + CLEAR_M
            for o in taken
        ):
            return Item(item.kind, a, g, item.height_m, item.size_m, item.turn_rad)
    raise UsageError(
        f"no room for {len(taken) + 1} items on the surveyed part",
        remedy="ask for fewer structures and marks, or longer legs",
    )

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hullrecon.errors import UsageError
from hullrecon.synthetic.atlas import PaintedHull, PlateAtlas
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.texture import PAINT

START_M = 3.1


def hull(bare_to_m: float | None = None, repeats_m: float | None = None) -> PaintedHull:
    return PaintedHull(
        albedo=PlateAtlas(spec_from(seed=1), (), 0.004),
        start_m=START_M,
        bare_to_m=bare_to_m,
        repeats_m=repeats_m,
    )


def colours(made: PaintedHull | PlateAtlas, along: np.ndarray) -> np.ndarray:
    a, g = np.meshgrid(along.astype(np.float32), np.arange(0.1, 1.0, 0.02, dtype=np.float32))
    return made.look_up(a, g, np.ones(a.shape, bool))


def test_bare_paint_has_one_tone_and_rest_keeps_its_colours() -> None:
    made, along = hull(bare_to_m=5.0), np.arange(4.0, 6.0, 0.02)
    seen, whole = colours(made, along), colours(made.albedo, along)  # type: ignore[arg-type]
    bare = along.astype(np.float32) < 5.0
    assert (seen[:, bare] == PAINT).all()
    np.testing.assert_array_equal(seen[:, ~bare], whole[:, ~bare])
    assert whole[:, bare].std() > 0.02


@pytest.mark.parametrize("times", [1, 2, 7])
def test_colours_come_again_after_that_length_and_not_before(times: int) -> None:
    made, along = hull(repeats_m=2.5), START_M + 0.2 + np.arange(0.0, 0.8, 0.02)
    first = colours(made, along)
    np.testing.assert_allclose(colours(made, along + times * 2.5), first, atol=0.02)
    assert np.abs(colours(made, along + times * 2.5 + 1.0) - first).mean() > 0.02


@pytest.mark.parametrize("values", [{"paint_bare_share": 1.1}, {"paint_repeats_m": 0.1}])
def test_impossible_paint_is_refused(values: dict[str, float]) -> None:
    ask: Callable[..., object] = spec_from
    with pytest.raises(UsageError, match="choose"):
        ask(**values)

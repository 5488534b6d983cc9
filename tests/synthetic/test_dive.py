# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from functools import partial
from typing import Any

import cv2
import numpy as np
import pytest

from hullrecon.errors import UsageError
from hullrecon.synthetic import dive as dive_module
from hullrecon.synthetic.dive import Dive, simulate_dive
from hullrecon.synthetic.hull_patch import HullSkin
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.recorder import record


def test_views_set_frame_rate(dive: Dive) -> None:
    """Three views over a footprint of standoff / 1.03 at 0.3 m/s."""
    expected = (
        dive.spec.cameras.views
        * dive.spec.survey.speed_m_per_s
        / (dive.spec.survey.standoff_m / 1.03)
    )
    assert 1 / np.diff(dive.frame_s).mean() == pytest.approx(expected, rel=0.02)


def test_items_are_where_cameras_look(dive: Dive) -> None:
    for item in dive.items:
        assert dive.seen_along[0] < item.along_m < dive.seen_along[1]
        assert dive.seen_girth[0] < item.girth_m < dive.seen_girth[1]


def test_dive_on_another_hull_follows_its_waterline() -> None:
    """Round the bow, where a line of constant girth from the keel would climb out of the water."""
    dive = simulate_dive(
        spec_from(
            along_m=44.0,
            legs=2,
            leg_length_m=3.0,
            structures=0,
            marks=0,
            barnacles=0,
            cameras="none",
        )
    )
    depth = dive.motion.position[:, 2]
    first = dive.motion.t_s < 9
    assert np.ptp(depth[first]) < 0.35


SHORT = {"leg_length_m": 1.0, "structures": 0, "marks": 0, "barnacles": 0, "cameras": "none"}
BOAT = {
    "length_m": 14.0,
    "beam_m": 1.2,
    "depth_m": 0.8,
    "draught_m": 0.6,
    "bilge_radius_m": 0.2,
    "top_m": 0.3,
}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"legs": 26}, "the hull has skin for 19 legs there, not for 26: choose fewer --legs"),
        (BOAT, "the hull has skin for 2 legs there, not for 5: choose fewer --legs"),
        (
            BOAT | {"leg_spacing_m": 1.5},
            "the hull has skin for 1 leg there, not for 5: choose fewer --legs",
        ),
        ({"top_m": 6.0}, "top_m is 6: choose less than 3.8 m, which the keel lies below the water"),
        ({"top_m": 3.8}, "top_m is 3.8: choose less than 3.8 m"),
        ({"draught_m": 8.0}, "the hull ends below the first leg: choose a larger --top-m"),
    ],
)
def test_dive_for_which_hull_is_too_small_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        simulate_dive(spec_from(**(SHORT | options)))


def test_dive_flies_as_many_legs_as_hull_has_skin_for() -> None:
    dive = simulate_dive(spec_from(**(SHORT | BOAT), legs=2))
    assert dive.hull.skin.girth_m[0] <= -dive.spec.survey.leg_spacing_m - 0.1
    assert dive.hull.skin.girth_m[-1] >= 0.1


def test_dive_along_hull_in_blocks_is_same_dive(
    dive: Dive, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the sensors give does not depend on how the hull is parted to fit into memory."""
    monkeypatch.setattr(dive_module, "HullSkin", partial(HullSkin, block_cells=1.3e4))
    parted = simulate_dive(dive.spec)
    assert len(parted.hull.skin) > 2
    np.testing.assert_allclose(parted.motion.position, dive.motion.position, atol=1e-7)
    one, several = record(dive), record(parted)
    np.testing.assert_allclose(several.dvl.velocity, one.dvl.velocity, atol=1e-6)
    np.testing.assert_allclose(several.dvl.ranges, one.dvl.ranges, atol=1e-5)
    k = len(dive.frame_s) // 2
    for name in range(2):
        first, second = (
            cv2.imdecode(np.frombuffer(s.frames[k][name], np.uint8), cv2.IMREAD_COLOR).astype(int)
            for s in (one, several)
        )
        assert np.abs(first - second).mean() < 0.1
    assert np.abs(one.pings[9].astype(int) - several.pings[9].astype(int)).mean() < 0.5

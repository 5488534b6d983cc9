# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest

from hullrecon.synthetic import dive as dive_module
from hullrecon.synthetic.dive import Dive, simulate_dive
from hullrecon.synthetic.options import spec_from, with_options
from hullrecon.synthetic.sensors.photographs import photographs
from hullrecon.synthetic.sensors.recorder import START_NS, InTurn, in_order, record, stamp_ns
from hullrecon.synthetic.sensors.sonar import pings
from hullrecon.synthetic.vehicle.rig import true_rig
from hullrecon.synthetic.world.hull_patch import HullSkin


def test_views_set_the_frame_rate(dive: Dive) -> None:
    """Three views over a footprint of standoff / 1.03 at 0.3 m/s."""
    expected = dive.spec.cameras.views * dive.spec.survey.speed_m_per_s / (dive.spec.survey.standoff_m / 1.03)
    assert 1 / np.diff(dive.frame_s).mean() == pytest.approx(expected, rel=0.02)


def test_items_are_where_the_cameras_look(dive: Dive) -> None:
    for item in dive.items:
        assert dive.seen_along[0] < item.along_m < dive.seen_along[1]
        assert dive.seen_girth[0] < item.girth_m < dive.seen_girth[1]


def test_a_stereo_rig_gives_two_different_images(dive: Dive) -> None:
    top, bottom = next(photographs(dive))
    assert bottom is not None
    assert top.shape == bottom.shape == (192, 240, 3)
    assert np.abs(top.astype(int) - bottom.astype(int)).mean() > 5


def test_a_mono_rig_gives_one(dive: Dive) -> None:
    mono = replace(dive, rig=replace(dive.rig, camera_bottom=None))
    _, bottom = next(photographs(mono))
    assert bottom is None


def test_pings_come_twice_a_second_and_see_the_hull(dive: Dive) -> None:
    t, images = pings(dive)
    assert 1 / np.diff(t).mean() == pytest.approx(2.0, rel=0.02)
    assert (next(images) > 80).mean() > 0.05


def test_the_rig_is_off_nominal_by_little_and_by_its_seed_alone() -> None:
    a, b = true_rig(spec_from(seed=1)), true_rig(spec_from(seed=1, legs=9))
    np.testing.assert_array_equal(a.T_s_ct.matrix(), b.T_s_ct.matrix())
    assert (true_rig(spec_from(seed=2)).T_s_ct.matrix() != a.T_s_ct.matrix()).any()


def test_the_camera_looks_through_pixels_as_wide_as_asked() -> None:
    rig = true_rig(spec_from(image_width=800, image_height=600))
    assert (rig.camera_top.width, rig.camera_top.height) == (800, 600)
    assert rig.camera_top.fx == pytest.approx(824)
    assert true_rig(spec_from(cameras="mono")).camera_bottom is None


def test_stamps_are_nanoseconds_since_the_start() -> None:
    np.testing.assert_array_equal(stamp_ns(np.array([0.0, 1.5])), [START_NS, START_NS + 1_500_000_000])


def test_readings_come_in_the_order_of_time(dive: Dive) -> None:
    spec = with_options(dive.spec, cameras="none", sonar=False)
    rows = list(in_order(record(replace(dive, spec=spec))))
    assert rows == sorted(rows)
    assert {name for _, name, _ in rows} == {"imu", "joints", "pressure", "dvl"}


def test_a_dive_on_another_hull_follows_its_waterline() -> None:
    """Round the bow, where a line of constant girth from the keel would climb out of the water."""
    dive = simulate_dive(spec_from(along_m=44.0, legs=2, leg_length_m=3.0, structures=0, marks=0, barnacles=0, cameras="none"))
    depth = dive.motion.position[:, 2]
    first = dive.motion.t_s < 9
    assert np.ptp(depth[first]) < 0.35


def test_images_are_made_when_they_are_asked_for_and_not_before(dive: Dive) -> None:
    made = []

    def track(items: Iterator[bytes], label: str, total: int) -> Iterator[bytes]:
        for item in items:
            made.append(label)
            yield item

    streams = record(dive, track)
    assert made == []
    top, bottom = streams.frames[1]
    assert len(made) == 4
    assert top.startswith(b"\xff\xd8")
    assert streams.frames[1] == (top, bottom)
    assert len(made) == 4


def test_items_in_turn_may_repeat_but_not_go_back() -> None:
    items = InTurn(iter("abc"))
    assert [items[k] for k in (0, 0, 2, 2)] == ["a", "a", "c", "c"]
    with pytest.raises(IndexError, match="item 1 is gone"):
        items[1]


def test_a_dive_along_a_hull_in_blocks_is_the_same_dive(dive: Dive, monkeypatch: pytest.MonkeyPatch) -> None:
    """The twin: what the sensors give must not depend on how the hull is parted to fit into memory."""
    monkeypatch.setattr(dive_module, "HullSkin", partial(HullSkin, block_cells=1e4))
    parted = simulate_dive(dive.spec)
    assert len(parted.hull.skin) > 2
    np.testing.assert_allclose(parted.motion.position, dive.motion.position, atol=1e-7)
    one, several = record(dive), record(parted)
    np.testing.assert_allclose(several.dvl.velocity, one.dvl.velocity, atol=1e-6)
    np.testing.assert_allclose(several.dvl.ranges, one.dvl.ranges, atol=1e-5)
    k = len(dive.frame_s) // 2
    for name in range(2):
        first, second = (
            cv2.imdecode(np.frombuffer(s.frames[k][name], np.uint8), cv2.IMREAD_COLOR).astype(int) for s in (one, several)
        )
        assert np.abs(first - second).mean() < 0.1
    assert np.abs(one.pings[9].astype(int) - several.pings[9].astype(int)).mean() < 0.5

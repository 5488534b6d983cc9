# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.options import with_options
from hullrecon.synthetic.recorder import (
    START_NS,
    InTurn,
    in_order,
    record,
    stamp_ns,
    without_progress,
)


def test_stamps_are_nanoseconds_since_start() -> None:
    np.testing.assert_array_equal(
        stamp_ns(np.array([0.0, 1.5])), [START_NS, START_NS + 1_500_000_000]
    )


def test_readings_come_in_order_of_time(dive: Dive) -> None:
    spec = with_options(dive.spec, cameras="none", sonar=False)
    rows = list(in_order(record(replace(dive, spec=spec))))
    assert rows == sorted(rows)
    assert {name for _, name, _ in rows} == {"imu", "joints", "pressure", "dvl"}


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


def test_what_is_not_tracked_passes_unchanged() -> None:
    assert list(without_progress(iter([b"a", b"b"]), "images", 2)) == [b"a", b"b"]


@pytest.mark.parametrize(
    ("cameras", "names"),
    [("stereo", ("camera_top", "camera_bottom")), ("mono", ("camera_top",)), ("none", ())],
)
def test_streams_name_cameras_that_are_carried(
    dive: Dive, cameras: str, names: tuple[str, ...]
) -> None:
    spec = with_options(dive.spec, cameras=cameras, sonar=False)
    streams = record(replace(dive, spec=spec))
    assert streams.cameras == names
    assert {name for _, name, _ in in_order(streams) if name.startswith("camera")} == set(names)
    assert len(streams.ping_s) == 0


def test_every_reading_is_named_once(dive: Dive) -> None:
    streams = record(dive)
    rows = list(in_order(streams))
    assert len(rows) == len({(name, k) for _, name, k in rows})
    assert sum(name == "camera_top" for _, name, _ in rows) == len(dive.frame_s)
    assert sum(name == "sonar" for _, name, _ in rows) == len(streams.ping_s)

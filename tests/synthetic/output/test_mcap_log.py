# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from hullrecon.synthetic import instruments, sonar
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.logs import TOPICS
from hullrecon.synthetic.recorder import START_NS, stamp_ns
from hullrecon.synthetic.sonar import pings

Messages = dict[str, list[Any]]


@pytest.fixture(scope="module")
def messages(package: Path) -> Messages:
    found: Messages = {}
    with AnyReader([package / "logs" / "dive.mcap"]) as reader:
        for connection, _, raw in reader.messages():
            found.setdefault(connection.topic, []).append(
                reader.deserialize(raw, connection.msgtype)
            )
    return found


def stamps(rows: list[Any]) -> np.ndarray:
    return np.array([m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in rows])


def test_every_topic_is_there(messages: Messages) -> None:
    # not asked for
    assert set(messages) == {topic for name, (topic, _) in TOPICS.items() if name != "position"}


def test_checksums_hold(package: Path) -> None:
    with (package / "logs" / "dive.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert (
            sum(1 for _ in reader.iter_messages()) == reader.get_summary().statistics.message_count
        )


def test_messages_are_logged_after_their_stamp_in_order(package: Path) -> None:
    with (package / "logs" / "dive.mcap").open("rb") as file:
        rows = [
            (m.log_time, m.publish_time)
            for _, _, m in make_reader(file).iter_messages(log_time_order=False)
        ]
    logged, stamped = np.array(rows, np.int64).T
    assert (np.diff(logged) >= 0).all()
    assert (logged > stamped).all()


def test_dvl_reads_back(messages: Messages, dive: Dive) -> None:
    true = instruments.dvl(dive.spec, dive.motion, dive.rig, dive.hull)
    rows = messages["/dvl"]
    np.testing.assert_array_equal(stamps(rows), stamp_ns(true.t_s))
    np.testing.assert_allclose(
        [[m.velocity.x, m.velocity.y, m.velocity.z] for m in rows], true.velocity
    )
    ranges = np.array([m.range for m in rows])
    np.testing.assert_allclose(ranges, np.where(np.isfinite(true.ranges), true.ranges, 0))


def test_lost_beam_is_range_zero_with_covariance_minus_one(
    messages: Messages,
) -> None:
    rows = [m for m in messages["/dvl"] if m.num_good_beams < 4]
    assert rows
    for m in rows:
        lost = np.asarray(m.range) == 0
        assert lost.sum() == 4 - m.num_good_beams
        np.testing.assert_array_equal(np.asarray(m.range_covar) == -1, lost)


def test_imu_reads_back(messages: Messages, dive: Dive) -> None:
    true = instruments.imu(dive.spec, dive.motion)
    rows = messages["/imu"]
    np.testing.assert_allclose(
        [[getattr(m.orientation, k) for k in "xyzw"] for m in rows], true.quaternion
    )
    np.testing.assert_allclose([m.linear_acceleration.z for m in rows], true.force[:, 2])


def test_joints_are_named(messages: Messages) -> None:
    assert all(
        list(m.name) == ["tray", "sonar_tray"] and len(m.position) == 2
        for m in messages["/joint_states"]
    )


def test_pressure_is_absolute(messages: Messages) -> None:
    assert all(101325 < m.fluid_pressure < 160000 for m in messages["/pressure"])


def test_images_pair_by_stamp(messages: Messages, dive: Dive) -> None:
    top, bottom = (messages[TOPICS[name][0]] for name in ("camera_top", "camera_bottom"))
    np.testing.assert_array_equal(stamps(top), stamps(bottom))
    np.testing.assert_array_equal(stamps(top), stamp_ns(dive.frame_s))
    assert all(bytes(m.data[:2]) == b"\xff\xd8" for m in (*top, *bottom))


def test_sonar_pixel_lies_at_bin_times_beams_plus_beam(messages: Messages, dive: Dive) -> None:
    _, images = pings(dive)
    first = next(images)
    message = messages["/sonar"][0]
    assert message.image.beam_count == sonar.BEAM_COUNT
    data = np.asarray(message.image.data)
    for beam, cell in ((0, 0), (5, 60), (95, 255), (40, 70)):
        assert data[cell * sonar.BEAM_COUNT + beam] == first[beam, cell]
    np.testing.assert_allclose(message.ranges, sonar.RANGE, rtol=1e-6)
    directions = [[d.x, d.y, d.z] for d in message.beam_directions]
    np.testing.assert_allclose(directions, sonar.beam_directions())


def test_log_starts_when_dive_is_dated() -> None:
    from datetime import UTC, datetime

    assert datetime.fromtimestamp(START_NS / 1e9, UTC) == datetime(2026, 5, 4, 9, 30, tzinfo=UTC)

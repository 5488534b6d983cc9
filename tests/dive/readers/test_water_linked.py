# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Reports as the protocol's documentation prints them."""

import json
import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.dvl_beams import A50_ANGLE_DEG, A50_AZIMUTH_DEG, a50_beams, tilted_beams
from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.dive.logs.readers.water_linked import LONGEST_LINE, WaterLinkedLog
from hullrecon.dive.logs.samples import DvlSample, ImuSample
from hullrecon.dive.logs.streams.dvl import dvl_pings
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

QUICK = settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)
START_US = 1_638_191_471_563_017


def velocity(number=0, **more):
    distances = (0.5568, 0.5664, 0.5376, 0.5472)
    return {
        "time": 106.4,
        "vx": 0.1,
        "vy": -0.2,
        "vz": 0.03,
        "fom": 0.002,
        "covariance": [[0.0] * 3] * 3,
        "altitude": 0.51,
        "transducers": [
            {
                "id": i,
                "velocity": 0.0,
                "distance": d,
                "rssi": -30.5,
                "nsd": -88.7,
                "beam_valid": True,
            }
            for i, d in enumerate(distances)
        ],
        "velocity_valid": True,
        "status": 0,
        "tracking_mode": "bottom",
        "format": "json_v3.2",
        "type": "velocity",
        "time_of_validity": START_US + 100_000 * number,
        "time_of_transmission": START_US + 100_000 * number + 5000,
        **more,
    }


POSITION = {
    "ts": 1638191471.809,
    "x": 12.4,
    "y": 64.6,
    "z": 1.8,
    "std": 0.002,
    "roll": 5.0,
    "pitch": 10.0,
    "yaw": 30.0,
    "type": "position_local",
    "status": 0,
    "format": "json_v3.1",
}
CONFIGURATION = {
    "response_to": "get_config",
    "success": True,
    "result": {"mounting_rotation_offset": 20.0},
    "type": "response",
}


def read(path, *reports):
    path.write_text("".join((r if isinstance(r, str) else json.dumps(r)) + "\n" for r in reports))
    log = WaterLinkedLog(path)
    return [m.data for m in log.messages()], log


def test_velocity_report_has_sigma_and_ranges_by_beam_number(tmp_path):
    report = velocity()
    report["transducers"].reverse()
    report["transducers"][0]["beam_valid"] = False  # of number 3
    (ping,), log = read(tmp_path / "x.json", report)
    assert isinstance(ping, DvlSample)
    assert ping.t_ns == START_US * 1000
    assert ping.velocity.tolist() == [0.1, -0.2, 0.03]
    assert ping.sigma == 0.002
    assert ping.altitude == 0.51
    np.testing.assert_array_equal(ping.ranges, [0.5568, 0.5664, 0.5376, np.nan])
    assert ping.beams is None
    assert not log.losses()


def test_invalid_water_or_poor_velocity_is_lost(tmp_path):
    lost = velocity(velocity_valid=False), velocity(tracking_mode="water"), velocity(fom=0.5)
    samples, _ = read(tmp_path / "x.json", *lost)
    assert all(np.isnan(s.sigma) for s in samples)
    assert all(np.isnan(s.velocity).all() and np.isnan(s.altitude) for s in samples)
    assert all(np.isfinite(s.ranges).all() for s in samples)


def test_the_dead_reckoning_report_gives_the_attitude_of_the_dvl(tmp_path):
    (attitude,), _ = read(tmp_path / "x.json", POSITION)
    assert isinstance(attitude, ImuSample)
    assert attitude.of_dvl
    assert attitude.t_ns == pytest.approx(1638191471.809e9, abs=1000)
    np.testing.assert_allclose(
        Rotation.from_quat(attitude.quaternion).as_euler("ZYX", degrees=True), [30, 10, 5]
    )


def test_the_mounting_rotation_offset_is_told(tmp_path):
    _, log = read(tmp_path / "x.json", velocity(), CONFIGURATION)
    assert any("offset of 20 degrees" in line for line in sentences(log.notes))
    # as advised, the beams are turned about z as the instrument turned its velocities
    advised = tilted_beams(A50_ANGLE_DEG, np.array(A50_AZIMUTH_DEG) + 20.0)
    turn = Rotation.from_euler("z", 20.0, degrees=True)
    np.testing.assert_allclose(advised, turn.apply(a50_beams()), atol=1e-12)
    _, log = read(tmp_path / "y.json", velocity())
    assert any("is not in the file" in line for line in sentences(log.notes))


def test_reports_of_older_protocol_lack_time_and_are_counted(tmp_path):
    old = velocity()
    del old["time_of_validity"]
    samples, log = read(tmp_path / "x.json", old, old, velocity())
    assert len(samples) == 1
    assert any(
        line.startswith("2 reports have no time_of_validity") for line in sentences(log.notes)
    )


@pytest.mark.parametrize(
    "line",
    [
        "[1, 2]",
        "x" * (2 * LONGEST_LINE),
        json.dumps(velocity(vx="fast")),
        json.dumps(velocity(transducers=[1])),
        json.dumps(velocity(time_of_validity=10**30)),
        '{"type": "velocity", "vx": 1e999, "time_of_validity": 1}',
        json.dumps({**POSITION, "yaw": None}),
        "[" * 100_000,
        json.dumps(velocity(time_of_validity=True)),
    ],
    ids=range(9),
)
def test_a_bad_line_costs_itself_and_is_named(tmp_path, line):
    samples, log = read(tmp_path / "x.json", velocity(0), line, velocity(1))
    assert [s.t_ns for s in samples] == [START_US * 1000, START_US * 1000 + 100_000_000]
    assert [loss.topic for loss in log.losses()] == ["dvl"]
    assert "line 2 cannot be read" in log.losses()[0].why


def test_file_of_timeless_reports_is_refused_with_remedy(tmp_path):
    first_protocol = {
        k: v
        for k, v in velocity().items()
        if k not in ("type", "time_of_validity", "time_of_transmission")
    }
    with pytest.raises(InputError, match="its 2 reports carry no time_of_validity") as caught:
        read(tmp_path / "x.json", first_protocol, first_protocol)
    assert "update the DVL's software" in caught.value.remedy
    assert read(tmp_path / "new.json", velocity())


def test_reading_twice_gives_the_same(tmp_path):
    _, log = read(tmp_path / "x.json", velocity(0), POSITION, velocity(1))
    first = [m.t_ns for m in log.messages()], log.losses(), sentences(log.notes)
    assert first == ([m.t_ns for m in log.messages()], log.losses(), sentences(log.notes))


@QUICK
@given(data=st.data())
def test_any_flipped_byte_costs_one_report_at_most(tmp_path, data):
    path = tmp_path / "x.json"
    content = bytearray("\n".join(json.dumps(velocity(i)) for i in range(4)).encode())
    content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    assert len(list(WaterLinkedLog(path).messages())) >= 2  # a line's end that is lost joins two


def test_other_json_in_a_folder_is_no_log(tmp_path):
    (tmp_path / "config.json").write_text('{"type": "velocity", "name": "x"}')
    with pytest.raises(InputError, match="holds no log"):
        find_logs(tmp_path)
    (tmp_path / "dvl.txt").write_text(json.dumps(velocity()) + "\n")
    (tmp_path / "notes.txt").write_text("hello")
    (tmp_path / "gone.log").symlink_to(tmp_path / "nowhere")
    os.mkfifo(tmp_path / "pipe.log")
    assert [p.name for p in find_logs(tmp_path)] == ["dvl.txt"]


def test_log_is_known_by_first_report_and_asks_for_beams(tmp_path):
    samples, _ = read(tmp_path / "x.log", *(velocity(i) for i in range(12)))
    assert isinstance(open_log(tmp_path / "x.log"), WaterLinkedLog)
    with pytest.raises(InputError, match="nothing says where the DVL's 4 beams point") as caught:
        dvl_pings(samples, None, 0.01, [])
    assert "beam_angle_deg = 22.5" in caught.value.remedy
    notes = []
    found = dvl_pings(samples, a50_beams(), 0.01, notes)
    np.testing.assert_allclose(found.beams, a50_beams())
    assert sentences(notes) == []

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import dataclasses
import json
import re
from datetime import UTC, datetime, timedelta
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fuzz.seed_ad2cp import dvl_file
from hullrecon.dive.ingest.ingest import ingest
from hullrecon.dive.ingest.request import IngestRequest, whole_ns
from hullrecon.dive.logs.streams.pressure import PressureModel
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences
from tests.dive.readers.test_pd0 import ensemble_bytes

REQUEST = IngestRequest(
    logs=("logs/dive.mcap",),
    topics={
        "dvl": "/dvl",
        "imu": "/imu",
        "pressure": "/pressure",
        "joints": "/joints",
        "camera_top": "/cam",
    },
    joints={"tray": "tray", "sonar_tray": "other"},
    imu_frame="ned",
    pressure=PressureModel(1025.0, 9.81, 101325.0),
    beams=None,
    sigma_velocity=0.003,
    calibration={"camera_top": "calibration/camera_top.yaml"},
    added_ns={"camera_top": 0, "camera_bottom": 0},
    mesh=None,
    units="m",
)


def run(package: Path, **changes):
    files: dict[str, BytesIO] = {}
    found = ingest(
        package,
        dataclasses.replace(REQUEST, **changes),
        lambda camera: files.setdefault(camera, BytesIO()),
    )
    return found, files


def test_every_sensor_becomes_a_record(package):
    found, files = run(package)
    assert {name: len(r.t_ns) for name, r in found.records.by_name().items()} == {
        "dvl": 8, "imu": 40, "pressure": 20, "tray": 20, "sonar_tray": 20,
    }  # fmt: skip
    assert found.records.pressure.depth[-1] == pytest.approx(38.0)
    assert found.records.tray.angle[1] == pytest.approx(0.2)
    assert found.records.sonar_tray.angle[0] == 9.0
    assert len(found.images["camera_top"].t_ns) == 8
    assert files["camera_top"].getbuffer().nbytes == found.images["camera_top"].size.sum()
    assert found.cameras["camera_top"].fx == 50.0
    assert sentences(found.lost) == []


START = datetime(2026, 5, 4, 9, 30, tzinfo=UTC)


@pytest.mark.parametrize("form", ["seconds", "hours"])
def test_only_what_lies_in_the_time_window_is_used(package, form):
    limits = {"start": 1.0, "end": 2.0}
    if form == "hours":
        limits = {name: START + timedelta(seconds=limit) for name, limit in limits.items()}
    whole, _ = run(package)
    part, files = run(package, **limits)
    for name, record in part.records.by_name().items():
        kept = whole.records.by_name()[name].t_ns
        np.testing.assert_array_equal(
            record.t_ns, kept[(kept >= kept[0] + 10**9) & (kept <= kept[0] + 2 * 10**9)]
        )
        assert 0 < len(record.t_ns) < len(kept)
    images = part.images["camera_top"]
    assert 0 < len(images.t_ns) < len(whole.images["camera_top"].t_ns)
    assert files["camera_top"].getbuffer().nbytes == images.size.sum()
    said = [
        note
        for note in part.document()["notes"]
        if note.startswith("dive: only what was measured from")
    ]
    assert len(said) == 1
    assert "from 2026-05-04T09:30:01.000Z to 2026-05-04T09:30:02.000Z" in said[0]


def test_a_window_with_one_limit_is_open_at_its_other_end(package):
    whole, part = (
        run(package, **limits)[0].records.pressure.t_ns for limits in ({}, {"start": 1.5})
    )
    np.testing.assert_array_equal(part, whole[whole >= whole[0] + 15 * 10**8])


def write_tables(folder: Path, **first_s: float) -> None:
    """Write 20 rows of each sensor's table, one a second, from seconds after START on."""
    rows = {"imu": "0,0,0,1", "dvl": "0.1,0,0", "position": "1,2,-3"}
    heads = {"imu": "qx,qy,qz,qw", "dvl": "vx,vy,vz", "position": "x,y,z"}
    folder.mkdir()
    for name, first in first_s.items():
        stamps = START.timestamp() + first + np.arange(20)
        (folder / f"{name}.csv").write_text(
            f"t,{heads[name]}\n" + "".join(f"{t:.0f},{rows[name]}\n" for t in stamps)
        )


def test_a_table_that_was_pasted_twice_is_read_once(tmp_path):
    write_tables(tmp_path / "logs", imu=0, dvl=0)
    table = tmp_path / "logs" / "dvl.csv"
    table.write_text(2 * table.read_text())
    found, _ = run(tmp_path, logs=("logs",), topics={}, calibration={})
    assert len(found.records.dvl.t_ns) == 20
    (said,) = (note for note in sentences(found.notes) if note.startswith("dvl: "))
    assert "20 of 40 readings stand in the log once more" in said


def test_the_window_holds_stamps_as_they_are_corrected(tmp_path):
    write_tables(tmp_path / "logs", imu=0, dvl=0, position=7200)
    limits = {"start": START + timedelta(seconds=5), "end": START + timedelta(seconds=10)}
    off = {
        "logs": ("logs",),
        "topics": {},
        "calibration": {},
        "added_ns": {"position": whole_ns(-7200.0)},
    }
    found, _ = run(tmp_path, **off, **limits)
    expected = [int(START.timestamp() + k) * 10**9 for k in range(5, 11)]
    assert found.records.position.t_ns.tolist() == found.records.dvl.t_ns.tolist() == expected


PLAIN = {"logs": ("logs",), "topics": {}, "calibration": {}}


@pytest.mark.parametrize("late_s", [7200, -3600 * 5 + 4])
def test_clocks_apart_are_refused_and_the_remedy_heals(tmp_path, late_s):
    write_tables(tmp_path / "logs", imu=0, dvl=late_s)
    with pytest.raises(InputError, match="one of the clocks is wrong") as refused:
        run(tmp_path, **PLAIN)
    key, value = re.search(r"try (\S+) = (\S+) \(", refused.value.what).groups()
    assert key == "dvl.time_offset"
    found, _ = run(tmp_path, **PLAIN, added_ns={"dvl": whole_ns(float(value))})
    left_ns = found.records.dvl.t_ns - found.records.imu.t_ns
    assert np.abs(left_ns).max() <= 4 * 10**9  # what navigate finds by itself


@pytest.mark.parametrize("sensor", ["dvl", "imu", "position"])
def test_an_offset_is_added_to_the_stamps_of_its_sensor(tmp_path, sensor):
    write_tables(tmp_path / "logs", imu=0, dvl=0, position=0)
    before, _ = run(tmp_path, **PLAIN)
    after, _ = run(tmp_path, **PLAIN, added_ns={sensor: whole_ns(-2.5)})
    for name, record in after.records.by_name().items():
        moved_ns = -2_500_000_000 if name == sensor else 0
        np.testing.assert_array_equal(record.t_ns, before.records.by_name()[name].t_ns + moved_ns)


def test_an_offset_of_the_joints_is_added_to_every_servo(package):
    before, _ = run(package)
    after, _ = run(package, added_ns={"joints": whole_ns(0.25), "camera_top": whole_ns(-0.5)})
    for name in ("tray", "sonar_tray"):
        moved_ns = after.records.by_name()[name].t_ns - before.records.by_name()[name].t_ns
        assert set(moved_ns.tolist()) == {250_000_000}
    images = after.images["camera_top"].t_ns - before.images["camera_top"].t_ns
    assert set(images.tolist()) == {-500_000_000}


def test_a_bag_with_one_sensor_on_another_time_base_is_joined(kit, package):
    before, _ = run(package)
    boot_ns = kit.start_ns - 50 * 10**9
    entries = [
        dataclasses.replace(e, message=kit.imu(e.t_ns - boot_ns)) if e.topic == "/imu" else e
        for e in kit.dive()
    ]
    kit.mcap(package / "logs" / "dive.mcap", entries)
    found, _ = run(package)
    np.testing.assert_array_equal(found.records.imu.t_ns, before.records.imu.t_ns)
    assert any("they were put onto that time base" in note for note in sentences(found.notes))


def test_seconds_of_a_window_count_from_the_earliest_table(tmp_path):
    write_tables(tmp_path / "logs", imu=0, dvl=6)
    found, _ = run(tmp_path, logs=("logs",), topics={}, calibration={}, start=10.0)
    assert (
        found.records.dvl.t_ns[0]
        == found.records.imu.t_ns[0]
        == int(START.timestamp() + 10) * 10**9
    )


@pytest.mark.parametrize(
    "rows", [[(2, 0.5)], [(1, 0.1), (2, 0.5), (12, 0.7), (19, 0.2)]], ids=["once", "as it turns"]
)
def test_a_joint_is_at_the_start_of_a_window_as_it_was_last_read(tmp_path, rows):
    write_tables(tmp_path / "logs", imu=0, dvl=0)
    lines = [f"{START.timestamp() + t:.0f},tray,{rad}" for t, rad in rows]
    (tmp_path / "logs" / "joints.csv").write_text("\n".join(["t,name,rad", *lines]) + "\n")
    found, _ = run(
        tmp_path,
        logs=("logs",),
        topics={},
        calibration={},
        start=10.0,
        end=15.0,
        joints={"tray": "tray"},
    )
    expected = [(10, 0.5), *((t, rad) for t, rad in rows if 10 < t < 15)]
    assert [
        int(t - START.timestamp() * 1e9) // 10**9 for t in found.records.tray.t_ns.tolist()
    ] == [t for t, _ in expected]
    assert found.records.tray.angle.tolist() == [rad for _, rad in expected]
    assert (
        "joint tray: at the start of the time window as last read, at 2026-05-04T09:30:02.000Z"
        in sentences(found.notes)
    )


def test_time_window_without_measurements_is_refused(package):
    with pytest.raises(
        InputError, match=r"nothing was measured from 2026-05-04T10:30:00\.000Z"
    ) as caught:
        run(package, start=START + timedelta(hours=1))
    assert caught.value.where == "dive.from"
    assert run(package, start=START)[0].records.dvl is not None


def test_a_window_that_ends_before_it_begins_is_an_input_error(package):
    with pytest.raises(InputError, match="the time window ends before it begins") as caught:
        run(package, start=2.0, end=1.0)
    assert caught.value.where == "dive.to"
    assert run(package, start=2.0, end=3.0)[0].records.dvl is not None


def test_the_findings_say_in_words_what_was_read(package):
    spans = run(package)[0].document()["spans"]
    assert "dvl: 8 pings in 3.5 s from 2026-05-04T09:30:00.000Z, 2.0 Hz" in spans
    assert "depth runs from 0.0 to 38.0 m" in spans
    assert "DVL ranges run from 1.00 to 4.00 m" in spans


def test_absent_topic_is_refused_with_a_list_of_topics(package):
    with pytest.raises(
        InputError, match="topic /ahrs is not in the log, which holds /cam, /dvl, /imu"
    ) as caught:
        run(package, topics={**REQUEST.topics, "imu": "/ahrs"})
    assert caught.value.where == "topics.imu"
    without = {sensor: topic for sensor, topic in REQUEST.topics.items() if sensor != "imu"}
    for topics, is_read in ((REQUEST.topics, True), (without, False)):
        assert (run(package, topics=topics)[0].records.imu is not None) == is_read


def test_absent_topic_of_a_damaged_log_is_only_noted(package):
    path = package / "logs" / "dive.mcap"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    found, _ = run(package, topics={**REQUEST.topics, "imu": "/ahrs"})
    assert any("nothing of /ahrs is left" in note for note in sentences(found.notes))
    assert sentences(found.lost)
    assert found.records.imu is None


def test_a_truncated_log_names_the_lost_span_of_each_topic(package):
    path = package / "logs" / "dive.mcap"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    found, _ = run(package)
    assert len(sentences(found.lost)) == 5
    assert all(
        line.startswith("dive.mcap: /") and "to the end is lost" in line
        for line in sentences(found.lost)
    )
    assert 0 < len(found.records.imu.t_ns) < 40


def test_nothing_readable_is_an_input_error(package):
    path = package / "logs" / "dive.mcap"
    whole = path.read_bytes()
    path.write_bytes(whole[:100])
    with pytest.raises(InputError, match="no sensor could be read"):
        run(package)
    path.write_bytes(whole)
    assert run(package)[0].records.dvl is not None


def test_a_camera_that_is_not_in_the_file_is_left_aside(package):
    found, files = run(package, calibration={})
    assert found.images == {}
    assert files == {}


def table(path: Path, header: str, t_ns: np.ndarray, *columns: np.ndarray) -> None:
    """A CSV whose stamps keep every nanosecond."""
    values = np.column_stack(columns).tolist()
    rows = [
        f"{t // 10**9}.{t % 10**9:09d},{','.join(map(repr, row))}"
        for t, row in zip(t_ns.tolist(), values, strict=True)
    ]
    path.write_text("\n".join([header, *rows]))


def test_plain_files_give_the_same_records_as_the_log(package):
    folder = package / "plain"
    folder.mkdir()
    whole, _ = run(package)
    imu, dvl, depth = (getattr(whole.records, name) for name in ("imu", "dvl", "pressure"))
    table(folder / "imu.csv", "t,qx,qy,qz,qw", imu.t_ns, imu.quaternion)
    table(
        folder / "dvl.csv",
        "t,vx,vy,vz,range_1,range_2,range_3,range_4",
        dvl.t_ns,
        dvl.velocity,
        dvl.ranges,
    )
    table(folder / "pressure.csv", "t,pascal", depth.t_ns, 101325 + 1025 * 9.81 * depth.depth)
    found, _ = run(package, logs=("plain",), topics={}, calibration={}, beams=dvl.beams)
    for name in ("imu", "dvl", "pressure"):
        np.testing.assert_array_equal(
            getattr(found.records, name).t_ns, getattr(whole.records, name).t_ns
        )
    np.testing.assert_array_equal(found.records.dvl.velocity, dvl.velocity)
    np.testing.assert_allclose(found.records.pressure.depth, depth.depth, atol=1e-9)
    np.testing.assert_array_equal(found.records.dvl.beams, dvl.beams)


def test_ros1_and_ros2_give_the_same_build_records(kit, package):
    kit.bag1(package / "x.bag", kit.dive(ros=1))
    kit.ros2(package / "folder", kit.dive())
    first, _ = run(package)
    for log in ("x.bag", "folder"):
        other, _ = run(package, logs=(log,))
        np.testing.assert_array_equal(other.records.dvl.ranges, first.records.dvl.ranges)
        np.testing.assert_array_equal(other.records.imu.t_ns, first.records.imu.t_ns)
        np.testing.assert_array_equal(
            other.images["camera_top"].size, first.images["camera_top"].size
        )


def test_two_logs_are_read_one_after_the_other(kit, package):
    entries = kit.dive()
    kit.mcap(package / "a.mcap", entries[:50])
    kit.mcap(package / "b.mcap", entries[50:])
    found, _ = run(package, logs=("b.mcap", "a.mcap"))
    assert (np.diff(found.records.imu.t_ns) > 0).all()
    assert len(found.records.imu.t_ns) == 40


def test_a_clock_that_jumps_is_named(kit, package):
    entries = kit.dive()
    moved = [
        dataclasses.replace(e, message=kit.imu(e.t_ns + 7 * 10**9))
        if e.topic == "/imu" and i > 50
        else e
        for i, e in enumerate(entries)
    ]
    kit.mcap(package / "logs" / "dive.mcap", moved)
    found, _ = run(package)
    assert any("imu: the clock jumps by +7.000 s" in note for note in sentences(found.notes))


def test_records_have_the_stamps_of_a_clock_that_was_put_right(kit, package):
    entries = kit.dive(seconds=8)
    kit.mcap(package / "logs" / "dive.mcap", entries)
    before, _ = run(package)
    late = [
        dataclasses.replace(
            e, message=dataclasses.replace(e.message, header=kit.header(e.t_ns + 7 * 10**9, 2))
        )
        if e.topic in ("/imu", "/cam") and i > 96
        else e
        for i, e in enumerate(entries)
    ]
    kit.mcap(package / "logs" / "dive.mcap", late)
    found, _ = run(package)
    np.testing.assert_array_equal(found.records.imu.t_ns, before.records.imu.t_ns)
    assert any(
        "stamps were put right by the logger" in r
        for r in sentences(found.notes)
        if r.startswith("imu")
    )
    # too few images to tell: they keep their stamps, and that is said
    assert found.images["camera_top"].t_ns[-1] == before.images["camera_top"].t_ns[-1] + 7 * 10**9
    assert any(
        "camera_top: the clock jumps by +7.000 s" in r and "cannot be trusted" in r
        for r in sentences(found.notes)
    )


def test_offsets_are_whole_nanoseconds():
    assert whole_ns(0.1) == 100_000_000
    assert whole_ns(-1e-9) == -1


def pd0(path: Path) -> None:
    """One ensemble of a glider's file stands for the DVL."""
    import struct

    fixed, variable, bottom = bytearray(59), bytearray(65), bytearray(81)
    struct.pack_into("<H", fixed, 4, 0x0200)
    fixed[8:10], fixed[25] = bytes([4, 0]), 0b01000
    struct.pack_into("<H", variable, 0, 0x80)
    variable[4:11] = bytes([26, 5, 4, 9, 30, 1, 0])
    struct.pack_into("<H", bottom, 0, 0x0600)
    struct.pack_into("<4H", bottom, 16, *[866] * 4)
    offsets = [12, 12 + 59, 12 + 59 + 65]
    body = (
        b"\x7f\x7f"
        + struct.pack("<HBB3H", 12 + 59 + 65 + 81, 0, 3, *offsets)
        + bytes(fixed + variable + bottom)
    )
    path.write_bytes(body + struct.pack("<H", sum(body) % 65536))


def test_a_pd0_file_beside_the_log_gives_the_dvl(package):
    pd0(package / "logs" / "dvl.pd0")
    topics = {name: topic for name, topic in REQUEST.topics.items() if name != "dvl"}
    found, _ = run(package, logs=("logs/dive.mcap", "logs/dvl.pd0"), topics=topics)
    assert found.records.dvl.ranges == pytest.approx(np.full((1, 4), 10.0), abs=0.001)
    assert len(found.records.imu.t_ns) == 40


def test_nortek_file_beside_log_gives_dvl_with_beam_ranges(package):
    (package / "logs" / "dvl.ad2cp").write_bytes(dvl_file())
    topics = {name: topic for name, topic in REQUEST.topics.items() if name != "dvl"}
    found, _ = run(package, logs=("logs/dive.mcap", "logs/dvl.ad2cp"), topics=topics, beams=None)
    assert found.records.dvl.ranges[0] == pytest.approx(
        np.array([3.0, 3.1, 3.2, 3.3]) / np.cos(np.radians(25))
    )
    assert found.records.dvl.velocity[0] == pytest.approx([0.1, -0.2, 0.035])
    assert len(found.records.imu.t_ns) == 40


@pytest.mark.parametrize("order", [("dvl.json", "tables"), ("tables", "dvl.json")])
def test_dvl_attitude_is_ignored_where_imu_was_logged(tmp_path, order):
    start_s = START.timestamp()
    write_tables(tmp_path / "tables", imu=3)
    lines = [
        json.dumps(
            {"type": "position_local", "ts": start_s + 0.1 * k, "roll": 0, "pitch": 0, "yaw": 9}
        )
        for k in range(210)
    ]
    (tmp_path / "dvl.json").write_text("\n".join(lines) + "\n")
    found, _ = run(tmp_path, logs=order, topics={}, calibration={})
    assert found.records.imu.t_ns.tolist() == [int(start_s + 3 + k) * 10**9 for k in range(20)]
    assert (
        sentences(found.notes).count(
            "imu: 210 attitudes by the DVL's own sensors were ignored, as the IMU was logged"
        )
        == 1
    )
    assert not found.attitude_is_dvls
    assert not [note for note in sentences(found.notes) if "jumps" in note]


def test_two_recordings_that_overlap_keep_their_stamps(tmp_path):
    for name, start_s in {"a": 0.0, "b": 25.3}.items():
        (tmp_path / name).mkdir()
        rows = [f"{START.timestamp() + start_s + 0.5 * k:.3f},101325" for k in range(60)]
        (tmp_path / name / "pressure.csv").write_text("\n".join(["t,pascal", *rows]) + "\n")
    found, _ = run(tmp_path, logs=("a", "b"), topics={}, calibration={})
    t_s = (found.records.pressure.t_ns - int(START.timestamp()) * 10**9) / 1e9
    assert t_s[-1] == pytest.approx(25.3 + 29.5, abs=1e-3)
    assert any(
        "logs were read in another order than they were recorded, or overlap" in note
        for note in sentences(found.notes)
    )


def test_a_dvl_topic_wins_over_a_pd0_file_and_that_is_said(package):
    pd0(package / "logs" / "dvl.pd0")
    found, _ = run(package, logs=("logs/dive.mcap", "logs/dvl.pd0"))
    assert len(found.records.dvl.t_ns) == 8
    assert "Teledyne PD0: its 1 readings were ignored, as topics.dvl is set" in sentences(
        found.notes
    )


def test_topics_do_not_apply_to_plain_files(package):
    (package / "plain").mkdir()
    (package / "plain" / "pressure.csv").write_text("t,pascal\n1,101325\n")
    found, _ = run(package, logs=("plain",), calibration={})
    assert found.records.pressure.depth.tolist() == [0.0]


def test_a_tray_that_grows_down_from_another_zero_is_counted_up_from_level(package):
    logged = run(package)[0].records.tray.angle
    found = run(package, tray_positive="down", tray_offset_deg=90.0)[0].records
    assert found.tray.angle == pytest.approx(np.pi / 2 - logged)
    assert found.sonar_tray.angle[0] == 9.0


def test_a_misspelt_joint_is_refused_with_the_nearest_name(package):
    with pytest.raises(
        InputError, match="joint tary is not in the log, which holds other, tray"
    ) as caught:
        run(package, joints={"tray": "tary"})
    assert caught.value.where == "tray.joint"
    assert caught.value.remedy == 'did you mean "tray"?'


def test_a_misspelt_joint_of_the_sonar_is_refused_too(package):
    with pytest.raises(InputError, match="joint othre is not in the log") as caught:
        run(package, joints={"tray": "tray", "sonar_tray": "othre"})
    assert caught.value.where == "sonar.joint"
    assert caught.value.remedy == 'did you mean "other"?'


def test_unknown_joint_is_refused_with_all_joints_and_remedy(package):
    with pytest.raises(InputError, match="holds other, tray") as caught:
        run(package, joints={"tray": "xyz"})
    assert 'tray.joint = ""' in caught.value.remedy
    for joints in ({"tray": "tray"}, {}):  # one of them, or none
        assert (run(package, joints=joints)[0].records.tray is None) == (not joints)


def test_a_joint_that_a_damaged_log_lost_is_only_remarked(package):
    path = package / "logs" / "dive.mcap"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    found, _ = run(package, joints={"tray": "tary"})
    assert any("no reading of tary" in note for note in sentences(found.notes))


def test_a_sonar_joint_without_any_joint_message_is_remarked(package):
    topics = {name: topic for name, topic in REQUEST.topics.items() if name != "joints"}
    found, _ = run(package, topics=topics)
    assert (
        "sonar.joint: no reading of other is in the log; it is taken as fixed at 0 degrees"
        in sentences(found.notes)
    )


def test_a_reading_of_another_millennium_is_left_out_and_counted(kit, package):
    entries = kit.dive()
    kit.mcap(
        package / "logs" / "dive.mcap",
        [*entries, dataclasses.replace(entries[-1], t_ns=(1 << 63) + 1)],
    )
    found, _ = run(package)
    assert any("beyond the year 2116" in note for note in sentences(found.notes))


def csv_package(folder: Path, stamps: list[float]) -> Path:
    (folder / "logs").mkdir()
    (folder / "logs" / "dvl.csv").write_text(
        "t,vx,vy,vz\n" + "".join(f"{t},0.1,0,0\n" for t in stamps)
    )
    (folder / "logs" / "imu.csv").write_text(
        "t,qx,qy,qz,qw\n" + "".join(f"{t},0,0,0,1\n" for t in stamps)
    )
    return folder


def test_several_dives_in_one_package_without_images_are_refused(tmp_path):
    package = csv_package(tmp_path, [0, 1, 2, 7202, 7203])
    only_logs = {"logs": ("logs",), "topics": {}, "calibration": {}}
    with pytest.raises(
        InputError, match=r"no velocity for 2\.0 h from 1970-01-01T00:00:02\.000Z on.*one at a time"
    ):
        run(package, **only_logs)
    found, _ = run(package, **only_logs, end=10.0)
    assert len(found.records.dvl.t_ns) == 3


def test_a_pause_of_minutes_is_no_second_dive(tmp_path):
    package = csv_package(tmp_path, [0, 1, 2, 1802, 1803])
    found, _ = run(package, logs=("logs",), topics={}, calibration={})
    assert len(found.records.dvl.t_ns) == 5


def test_attitude_is_the_dvl_s_own_only_where_no_imu_was_logged(package):
    assert not run(package)[0].attitude_is_dvls
    (package / "x.pd0").write_bytes(b"".join(ensemble_bytes(n, heading=100) for n in range(5)))
    assert run(package, logs=("x.pd0",), topics={}, calibration={}, imu_mount_deg=(0, 0, 0))[
        0
    ].attitude_is_dvls

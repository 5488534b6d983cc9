# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os
import tracemalloc
from datetime import UTC, date, timedelta, timezone
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hullrecon.dive.logs.formats.stamps import LoggerClock
from hullrecon.dive.logs.readers.plain import PlainLog
from hullrecon.dive.logs.samples import SonarSample
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

QUICK = settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)


def read(folder, package=None):
    log = PlainLog(folder, package)
    return [m.data for m in log.messages()], log


def test_empty_cells_of_a_dvl_row_are_lost_values(tmp_path):
    (tmp_path / "dvl.csv").write_text(
        "t,vx,vy,vz,range_1,range_2,range_3,range_4\n1.5,0.1,,0.3,1,2,,4\n"
    )
    (ping,), _ = read(tmp_path)
    assert ping.t_ns == 1_500_000_000
    np.testing.assert_array_equal(ping.velocity, [0.1, np.nan, 0.3])
    np.testing.assert_array_equal(ping.ranges, [1, 2, np.nan, 4])
    assert np.isnan(ping.sigma)


@pytest.mark.parametrize("is_named", [False, True])
def test_photos_that_no_table_names_are_named(tmp_path, is_named):
    (tmp_path / "pressure.csv").write_text("t,pascal\n0,1e5\n")
    (tmp_path / "top").mkdir()
    for name in ("a.jpg", "b.jpg"):
        (tmp_path / "top" / name).touch()
    if is_named:
        (tmp_path / "camera_top.csv").write_text("t,file\n0,top/a.jpg\n1,top/b.jpg\n")
    told = "2 photos without times are not read: put beside them camera_top.csv with columns t"
    assert [note[: len(told)] for note in sentences(read(tmp_path)[1].notes)] == [told][is_named:]


def test_columns_that_are_not_read_are_named(tmp_path):
    (tmp_path / "dvl.csv").write_text("t,vx,vy,vz,range1,range_2\n0,0,0,0,1,1\n")
    _, log = read(tmp_path)
    (note,) = sentences(log.notes)
    assert note.startswith("dvl.csv: columns that are not read: range1; read are t, vx, vy, vz,")


def test_ranges_are_taken_in_the_order_of_their_numbers(tmp_path):
    (tmp_path / "dvl.csv").write_text("range_2,range_10,t,vx,vy,vz,range_1\n2,10,0,0,0,0,1\n")
    (ping,), _ = read(tmp_path)
    assert ping.ranges.tolist() == [1, 2, 10]


def test_stamps_keep_every_nanosecond_that_is_written(tmp_path):
    (tmp_path / "pressure.csv").write_text(
        "t,pascal\n1777887000.123456789,101325\n1.777887e9,1e5\n"
    )
    samples, _ = read(tmp_path)
    assert [s.t_ns for s in samples] == [1_777_887_000_123_456_789, 1_777_887_000_000_000_000]


def test_an_imu_without_rates_is_read(tmp_path):
    (tmp_path / "imu.csv").write_text("t,qx,qy,qz,qw\n0,0,0,0,1\n")
    (sample,), _ = read(tmp_path)
    assert sample.quaternion.tolist() == [0, 0, 0, 1]
    assert np.isnan(sample.rates).all()


def test_an_imu_with_rates_and_accelerations_is_read(tmp_path):
    (tmp_path / "imu.csv").write_text("t,qx,qy,qz,qw,wx,wy,wz,ax,ay,az\n0,0,0,0,1,1,2,3,4,5,6\n")
    (sample,), _ = read(tmp_path)
    assert sample.rates.tolist() == [1, 2, 3]
    assert sample.acceleration.tolist() == [4, 5, 6]


def test_joints_have_names(tmp_path):
    (tmp_path / "joints.csv").write_text("t,name,rad\n0,tray,0.5\n0, sonar_tray ,0.25\n")
    samples, _ = read(tmp_path)
    assert [(s.name, s.angle) for s in samples] == [("tray", 0.5), ("sonar_tray", 0.25)]


def test_images_are_found_beside_the_csv_or_below_the_package(tmp_path):
    folder = tmp_path / "logs"
    (folder / "top").mkdir(parents=True)
    (folder / "top" / "a.jpg").write_bytes(b"a")
    (tmp_path / "b.jpg").write_bytes(b"b")
    (folder / "camera_top.csv").write_text("t,file\n0,top/a.jpg\n1,b.jpg\n2,gone.jpg\n")
    samples, log = read(folder, tmp_path)
    assert [s.file for s in samples] == ["logs/top/a.jpg", "b.jpg", "gone.jpg"]
    assert log.named_files() == [Path("b.jpg"), Path("logs/top/a.jpg")]


def test_a_path_of_windows_names_the_same_image(tmp_path):
    (tmp_path / "img").mkdir()
    (tmp_path / "img" / "a.jpg").write_bytes(b"a")
    (tmp_path / "camera_top.csv").write_text("t,file\n0,img\\a.jpg\n")
    assert read(tmp_path)[0][0].file == "img/a.jpg"


def test_a_sonar_ping_has_its_beams_in_the_fan_plane(tmp_path):
    azimuth = np.array([-0.5, 0.0, 0.5])
    np.savez(
        tmp_path / "p.npz",
        image=np.arange(6, dtype=np.uint8).reshape(3, 2),
        azimuth=azimuth,
        range=[1.0, 2.0],
    )
    (tmp_path / "sonar.csv").write_text("t,file\n0,p.npz\n")
    (ping,), _ = read(tmp_path)
    assert ping.directions[1] == pytest.approx([0, 0, 1])
    assert ping.directions[2] == pytest.approx([0, np.sin(0.5), np.cos(0.5)])
    assert ping.image.tolist() == [[0, 1], [2, 3], [4, 5]]


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04rubbish", None])
def test_a_sonar_file_that_is_damaged_or_gone_is_a_named_loss(tmp_path, content):
    if content is not None:
        (tmp_path / "p.npz").write_bytes(content)
    np.savez(
        tmp_path / "good.npz", image=np.eye(2, dtype=np.uint8), azimuth=[0.0, 0.1], range=[1.0, 2.0]
    )
    (tmp_path / "sonar.csv").write_text("t,file\n0,p.npz\n1,good.npz\n")
    samples, log = read(tmp_path)
    assert [s.t_ns for s in samples] == [1_000_000_000]
    assert log.losses()[0].why.startswith("line 2 of sonar.csv cannot be read: ")


def test_unreadable_row_is_a_named_loss_and_others_are_kept(tmp_path):
    (tmp_path / "pressure.csv").write_text("t,pascal\n0,1e5\n1,oops\n2\n3,1e5\n")
    samples, log = read(tmp_path)
    assert [s.t_ns for s in samples] == [0, 3_000_000_000]
    (loss,) = log.losses()
    assert (loss.topic, loss.messages) == ("pressure", 2)
    assert "lines 3, 4 of pressure.csv" in loss.why


def test_rows_that_hold_no_reading_are_no_loss(tmp_path):
    (tmp_path / "pressure.csv").write_text(
        "t,pascal\ns,Pa\n0,1e5\n# mark 3\nt,pascal\n1,null\n2,1e5\nTotal,2\n"
    )
    samples, log = read(tmp_path)
    assert [s.t_ns // 10**9 for s in samples] == [0, 2]
    assert [loss.why for loss in log.losses()] == [
        "line 6 of pressure.csv cannot be read: 'null' is no number"
    ]


def test_a_word_for_no_value_is_a_lost_one(tmp_path):
    (tmp_path / "dvl.csv").write_text("t,vx,vy,vz,range_1\n0,NULL,n/a,-,1\n")
    (ping,), log = read(tmp_path)
    assert np.isnan(ping.velocity).all()
    assert (ping.ranges.tolist(), log.losses()) == ([1.0], [])


def test_decimal_commas_between_commas_are_refused_until_semicolons_part_them(tmp_path):
    table = tmp_path / "pressure.csv"
    table.write_text("t;pascal\n1777887000,25;112896,34\n")
    assert read(tmp_path)[0][0].pascal == 112896.34
    table.write_text(table.read_text().replace(";", ","))
    with pytest.raises(InputError, match="has 4 cells, its header 2: commas stand in its numbers"):
        read(tmp_path)


def test_a_missing_column_is_an_input_error_that_names_it(tmp_path):
    (tmp_path / "pressure.csv").write_text("seconds,pascal\n0,1e5\n")
    with pytest.raises(InputError, match=r"pressure\.csv has no column t"):
        read(tmp_path)


def test_an_empty_table_is_an_input_error(tmp_path):
    (tmp_path / "imu.csv").write_text("")
    with pytest.raises(InputError, match="has no column"):
        read(tmp_path)


def test_a_byte_order_mark_and_spaces_do_no_harm(tmp_path):
    (tmp_path / "pressure.csv").write_bytes(b"\xef\xbb\xbft, pascal\r\n0, 5\r\n")
    samples, _ = read(tmp_path)
    assert samples[0].pascal == 5.0


@QUICK
@given(st.binary(max_size=200))
def test_any_bytes_below_the_header_are_survived(tmp_path, tail):
    (tmp_path / "dvl.csv").write_bytes(b"t,vx,vy,vz,range_1\n0,1,1,1,1\n" + tail)
    samples, log = read(tmp_path)
    assert all(s.ranges.shape == (1,) for s in samples)
    assert all(loss.why for loss in log.losses())


@pytest.mark.parametrize(
    ("scale", "unit"), [(10**3, "milliseconds"), (10**6, "microseconds"), (10**9, "nanoseconds")]
)  # fmt: skip
def test_stamps_in_other_units_are_refused_with_likely_unit(tmp_path, scale, unit):
    rows = "".join(f"{1_777_887_000 * scale + i},{101_325 + i}\n" for i in range(3))
    (tmp_path / "pressure.csv").write_text("t,pascal\n" + rows)
    with pytest.raises(
        InputError, match=f"pressure.csv has stamps such as .* look like {unit}"
    ) as caught:
        list(PlainLog(tmp_path).messages())
    assert "seconds since 1970" in caught.value.remedy
    rows = "".join(f"{1_777_887_000 + i / scale},{101_325 + i}\n" for i in range(3))
    (tmp_path / "pressure.csv").write_text("t,pascal\n" + rows)
    assert len(list(PlainLog(tmp_path).messages())) == 3


@pytest.mark.parametrize("began", [46_146.3958, 740_115.3958])  # of Excel, of MATLAB
def test_stamps_in_days_are_refused_until_they_are_seconds(tmp_path, began):
    for day, taken in ((began, False), (1_777_887_000 / 86400, True)):
        t = (day * 86400 + np.arange(30)) / (1 if taken else 86400)
        rows = "".join(f"{stamp!r},101325\n" for stamp in t.tolist())
        (tmp_path / "pressure.csv").write_text("t,pascal\n" + rows)
        if taken:
            assert len(list(PlainLog(tmp_path).messages())) == 30
            continue
        with pytest.raises(InputError, match="are they days") as caught:
            list(PlainLog(tmp_path).messages())
        assert "seconds since 1970" in caught.value.remedy


@pytest.mark.parametrize("sensor", ["dvl", "imu"])
def test_milliseconds_of_a_logger_are_refused_until_they_are_seconds(tmp_path, sensor):
    head = {"dvl": "t,vx,vy,vz", "imu": "t,qx,qy,qz,qw"}[sensor]
    for scale, taken in ((1e3, False), (1.0, True)):
        stamps = (scale * (123.0 + 0.05 * np.arange(30))).tolist()
        rows = "".join(f"{t!r},0,0,0{',1' if sensor == 'imu' else ''}\n" for t in stamps)
        (tmp_path / f"{sensor}.csv").write_text(f"{head}\n{rows}")
        if taken:
            assert len(list(PlainLog(tmp_path).messages())) == 30
            continue
        with pytest.raises(InputError, match="50 s from one to the next: are they milliseconds"):
            list(PlainLog(tmp_path).messages())


@pytest.mark.parametrize("stamp", ["1e300", "inf", "9" * 40])
def test_a_stamp_that_no_unit_explains_is_refused_all_the_same(tmp_path, stamp):
    (tmp_path / "pressure.csv").write_text(f"t,pascal\n{stamp},101325\n")
    with pytest.raises(InputError, match="has stamps such as") as caught:
        list(PlainLog(tmp_path).messages())
    assert "look like" not in caught.value.what


def test_one_absurd_stamp_among_good_ones_is_lost_alone(tmp_path):
    (tmp_path / "pressure.csv").write_text("t,pascal\n0,1\n99999999999999,2\n2,3\n")
    samples, log = read(tmp_path)
    assert [s.pascal for s in samples] == [1.0, 3.0]
    assert log.losses()[0].why.startswith("line 3 of pressure.csv cannot be read: ")


def test_a_row_that_is_cut_short_is_lost_alone(tmp_path):
    (tmp_path / "joints.csv").write_text("t,name,rad\n0,tray,0.1\n1")
    samples, log = read(tmp_path)
    assert [s.angle for s in samples] == [0.1]
    assert log.losses()[0].messages == 1


def test_the_tables_that_are_there_are_listed(tmp_path):
    for name in ("pressure.csv", "imu.csv", "notes.csv"):
        (tmp_path / name).write_text("t\n")
    assert PlainLog(tmp_path).tables() == ["imu.csv", "pressure.csv"]


def test_relative_and_absolute_folder_name_the_same_files(tmp_path, monkeypatch):
    folder = tmp_path / "p" / "logs"
    folder.mkdir(parents=True)
    (folder / "a.jpg").write_bytes(b"a")
    (folder / "camera_top.csv").write_text("t,file\n0,a.jpg\n")
    monkeypatch.chdir(tmp_path)
    assert PlainLog(Path("p/logs"), Path("p")).named_files() == [Path("logs/a.jpg")]
    assert PlainLog(folder, tmp_path / "p").named_files() == [Path("logs/a.jpg")]


@pytest.mark.parametrize(
    ("sensor", "text", "reason"),
    [
        ("pressure", "t,pascal\n0,deep\n", "line 2: 'deep' is no number"),
        (
            "dvl",
            "t,vx,vy,vz,range_a\n0,1,1,1,1\n",
            "line 2: column range_a is none of range_1, range_2",
        ),
        ("sonar", "t,file\n0,gone.npz\n", "line 2: gone.npz: "),
    ],
)
def test_table_without_readable_row_is_refused_with_reason(tmp_path, sensor, text, reason):
    (tmp_path / f"{sensor}.csv").write_text(text)
    with pytest.raises(InputError, match=f"{sensor}.csv has no row that can be read: {reason}"):
        read(tmp_path)


@pytest.mark.parametrize("cell", ["a" * 5000, "", "  ", "x/" * 3000, ".", "pipe"])
def test_a_cell_that_names_no_file_costs_its_row_alone(tmp_path, cell):
    (tmp_path / "a.jpg").write_bytes(b"a")
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "camera_top.csv").write_text(f"t,file\n0,a.jpg\n1,{cell}\n2,a.jpg\n")
    samples, log = read(tmp_path)
    assert [s.t_ns for s in samples] == [0, 2_000_000_000]
    assert log.losses()[0].why.startswith("line 3 of camera_top.csv cannot be read: ")
    assert log.named_files() == [Path("a.jpg")]


@pytest.mark.parametrize(
    ("sensor", "rows"),
    [
        ("camera_top", "t,file\n0,a.jpg\n1,"),
        ("camera_top", "t,file\n0,a.jpg\n1"),
        ("dvl", "t,vx,vy,vz,range_1\n0,1,1,1,1\n1,1,1"),
        ("imu", "t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0"),
        ("joints", "t,name,rad\n0,tray,1\n1,tr"),
        ("pressure", "t,pascal\n0,1\n177"),
    ],
)
def test_a_last_row_that_is_cut_costs_itself_and_is_counted(tmp_path, sensor, rows):
    (tmp_path / "a.jpg").write_bytes(b"a")
    (tmp_path / f"{sensor}.csv").write_text(rows)
    samples, log = read(tmp_path)
    assert [s.t_ns for s in samples] == [0]
    assert [(loss.topic, loss.messages) for loss in log.losses()] == [(sensor, 1)]
    assert all(path.name == "a.jpg" for path in log.named_files())


@pytest.mark.parametrize("stamp", ["-1e300", "-9" * 2 + "9" * 30, "nan", "0" * 5000 + "x", "-1e11"])
def test_a_stamp_that_no_clock_shows_costs_its_row_alone(tmp_path, stamp):
    (tmp_path / "pressure.csv").write_text(f"t,pascal\n0,1\n{stamp},2\n2,3\n")
    samples, log = read(tmp_path)
    assert [s.pascal for s in samples] == [1.0, 3.0]
    assert log.losses()[0].messages == 1


def test_numbers_of_ten_thousand_digits_are_a_bad_cell(tmp_path):
    (tmp_path / "pressure.csv").write_text(f"t,pascal\n0,1\n1.{'9' * 10_000},{'9' * 10_000}\n2,3\n")
    samples, _ = read(tmp_path)
    assert samples[0].pascal == 1.0
    assert samples[-1].pascal == 3.0
    (tmp_path / "dvl.csv").write_text(f"t,vx,vy,vz,range_{'9' * 10_000}\n0,1,1,1,1\n")
    with pytest.raises(InputError, match=r"dvl\.csv has no row that can be read") as caught:
        read(tmp_path)
    assert len(caught.value.line()) < 600


def test_a_quote_that_is_not_closed_costs_its_line_alone(tmp_path):
    (tmp_path / "joints.csv").write_text('t,name,rad\n0,tray,0.1\n1,"tray,0.2\n2,tray,0.3\n')
    samples, log = read(tmp_path)
    assert [s.angle for s in samples] == [0.1, 0.3]
    assert log.losses()[0].messages == 1


def test_a_line_without_end_costs_itself_and_no_memory(tmp_path):
    """Read in one piece it would take as much memory as it has bytes, several times over."""
    with (tmp_path / "pressure.csv").open("w") as stream:
        stream.write("t,pascal\n0,1\n")
        for _ in range(64):
            stream.write("1" * (1 << 20))
        stream.write("\n2,3\n")
    tracemalloc.start()
    samples, log = read(tmp_path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert [s.pascal for s in samples] == [1.0, 3.0]
    assert log.losses()[0].why.startswith("line 3 of pressure.csv cannot be read: ")
    assert peak < 4 << 20


@pytest.mark.parametrize("kind", ["pipe", "folder"])
def test_a_table_that_is_no_file_is_refused(tmp_path, kind):
    os.mkfifo(tmp_path / "imu.csv") if kind == "pipe" else (tmp_path / "imu.csv").mkdir()
    with pytest.raises(InputError, match=rf"imu\.csv is a {kind}, not a file"):
        read(tmp_path)


def test_a_ping_that_stands_in_two_rows_is_read_once(tmp_path):
    """Some kilobytes of rows would else fill the memory with copies of one file."""
    np.savez(
        tmp_path / "p.npz", image=np.eye(2, dtype=np.uint8), azimuth=[0.0, 0.1], range=[1.0, 2.0]
    )
    (tmp_path / "sonar.csv").write_text("t,file\n0,p.npz\n1,p.npz\n")
    samples, log = read(tmp_path)
    assert len(samples) == 1
    assert log.losses()[0].messages == 1


def test_names_of_joints_are_escaped(tmp_path):
    (tmp_path / "joints.csv").write_text("t,name,rad\n0,tray\x1b[31m,0.1\n")
    assert read(tmp_path)[0][0].name == "tray\\x1b[31m"


def test_pings_unpack_to_a_bounded_multiple_of_their_files(tmp_path):
    """Hundreds of files of some kilobytes, or links to one, would fill the memory."""
    ping = {"azimuth": np.zeros(1000), "range": np.arange(4000.0)}
    np.savez_compressed(tmp_path / "p.npz", image=np.zeros((1000, 4000), np.uint8), **ping)
    content = (tmp_path / "p.npz").read_bytes()
    for n in range(60):
        (tmp_path / f"{n}.npz").write_bytes(content)
        (tmp_path / f"link{n}.npz").symlink_to("p.npz")
    rows = "".join(f"{n},{n}.npz\n{n}.5,link{n}.npz\n" for n in range(60))
    (tmp_path / "sonar.csv").write_text("t,file\n" + rows)
    samples, log = read(tmp_path)
    assert sum(s.image.nbytes for s in samples) < (1 << 26) + 64 * 61 * len(content)
    assert 10 < len(samples) < 61
    assert log.losses()[0].messages == 120 - len(samples)


def test_links_in_a_circle_cost_their_row_alone(tmp_path):
    np.savez(
        tmp_path / "p.npz", image=np.eye(2, dtype=np.uint8), azimuth=[0.0, 0.1], range=[1.0, 2.0]
    )
    (tmp_path / "a.npz").symlink_to("b.npz")
    (tmp_path / "b.npz").symlink_to("a.npz")
    for sensor in ("sonar", "camera_top"):
        (tmp_path / f"{sensor}.csv").write_text("t,file\n0,p.npz\n1,a.npz\n")
    samples, log = read(tmp_path)
    assert sum(isinstance(s, SonarSample) for s in samples) == 1
    assert [loss.topic for loss in log.losses()] == ["sonar"]
    assert log.named_files() == [Path("p.npz")]


def test_pings_that_an_oculus_sent_are_named_by_file_and_number(data, tmp_path):
    (tmp_path / "p.raw").write_bytes((data / "oculus-pings" / "three_pings_8bit.raw").read_bytes())
    (tmp_path / "sonar.csv").write_text(
        "t,file,ping\n1,p.raw,0\n2,p.raw,2\n3,p.raw,2\n4,p.raw,9\n5,p.raw,x\n"
    )
    log = PlainLog(tmp_path)
    samples = [m.data for m in log.messages()]
    assert [s.t_ns for s in samples] == [10**9, 2 * 10**9]
    assert samples[0].image.shape == (256, 703)
    assert samples[0].directions[0] == pytest.approx([0, -0.5, np.sqrt(0.75)])
    assert "lines 4, 5, 6 of sonar.csv cannot be read" in log.losses()[0].why


@pytest.mark.parametrize(
    ("table", "place", "sigma", "geographic"),
    [
        ("t,latitude,longitude\n1,54.3,10.1\n2,,\n", [54.3, 10.1, np.nan], np.nan, True),
        (
            "t,latitude,longitude,altitude,sigma_m\n1,54.3,10.1,2,0.5\n2,,,,\n",
            [54.3, 10.1, 2],
            0.5,
            True,
        ),
        ("t,x,y\n1,3,4\n2,,\n", [3, 4, np.nan], np.nan, False),
        ("t,x,y,z,sigma_m\n1,3,4,-5,0.2\n2,,4,,\n", [3, 4, -5], 0.2, False),
    ],
)
def test_positions_are_read_by_degrees_or_by_metres(table, place, sigma, geographic, tmp_path):
    (tmp_path / "position.csv").write_text(table)
    (first, second), log = read(tmp_path)
    np.testing.assert_array_equal(first.place, place)
    np.testing.assert_array_equal(first.sigma_m, sigma)
    assert (first.geographic, first.by_satellite) == (geographic, False)
    assert np.isnan(second.place[0])
    assert log.losses() == []


def test_a_position_without_a_place_is_refused(tmp_path):
    (tmp_path / "position.csv").write_text("t,north,east\n1,2,3\n")
    with pytest.raises(InputError, match="columns latitude and longitude, or x and y"):
        read(tmp_path)


def test_a_table_of_another_name_is_named_as_not_read(tmp_path):
    (tmp_path / "pressure.csv").write_text("t,pascal\n1777887000,101325\n")
    for name in ("usbl.csv", "dvl.csv.gz", "IMU.CSV", "sonar.oculus"):  # the last one is no table
        (tmp_path / name).write_text("t,x,y\n")
    log = PlainLog(tmp_path)
    assert len(list(log.messages())) == 1
    assert [note.partition(";")[0] for note in sentences(log.notes)] == [
        "not read: IMU.CSV, dvl.csv.gz, usbl.csv"
    ]


def test_a_date_and_time_with_its_zone_is_a_stamp(tmp_path):
    (tmp_path / "pressure.csv").write_text("t,pascal\n2026-05-04T11:30:00.25+02:00,5\n")
    samples, _ = read(tmp_path)
    (tmp_path / "pressure.csv").write_text("t,pascal\n2026-05-04 09:30:00.25 UTC,5\n")
    assert read(tmp_path)[0][0].t_ns == samples[0].t_ns == 1_777_887_000_250_000_000


@pytest.mark.parametrize("stamp", ["05/04/2026 09:30:00", "2026-05-04 09:30:00 AM", "25:00:00"])
def test_a_date_in_an_unclear_order_is_refused_by_name(tmp_path, stamp):
    (tmp_path / "pressure.csv").write_text(f"t,pascal\n{stamp},5\n")
    with pytest.raises(InputError, match=f"t = '{stamp}' is no number of seconds since 1970"):
        read(tmp_path)


ON_DECK = LoggerClock(zone=timezone(timedelta(hours=2)), day=date(2026, 5, 4))


@pytest.mark.parametrize(
    ("header", "cells"),
    [
        ("t", "2026-05-04 11:30:00.25"),
        ("t", "2026/05/04 11:30:00.25"),
        ("t", "04.05.2026 11:30:00.25"),
        ("Time", "11:30:00.25"),
        ("t", "9:30:00.25Z"),
        ("date,time", "2026-05-04,11:30:00.25"),
        ("date,t", "20260504,11:30:00.25"),
        ("date,time", "4.5.2026,09:30:00.25 UTC"),
        ("date,t", "2025-01-01,1777887000.25"),  # t alone tells it
    ],
)
def test_dates_and_times_are_read_by_the_clock_of_the_dive(tmp_path, header, cells):
    (tmp_path / "pressure.csv").write_text(f"{header},pascal\n{cells},5\n")
    log = PlainLog(tmp_path, clock=ON_DECK)
    assert [m.data.t_ns for m in log.messages()] == [1_777_887_000_250_000_000]


def test_times_of_day_go_on_past_midnight(tmp_path):
    rows = ("23:59:59.5", "00:00:00.5", "23:59:59.9", "00:00:01.5")
    (tmp_path / "pressure.csv").write_text("t,pascal\n" + "".join(f"{t},5\n" for t in rows))
    t_ns = [message.data.t_ns for message in PlainLog(tmp_path, clock=ON_DECK).messages()]
    assert [t - t_ns[0] for t in t_ns] == [0, 1_000_000_000, 400_000_000, 2_000_000_000]


@pytest.mark.parametrize(
    ("stamp", "clock", "remedy"),
    [
        ("2026-05-04 11:30:00", LoggerClock(), "logs.time_zone"),
        ("11:30:00", LoggerClock(day=date(2026, 5, 4)), "logs.time_zone"),
        ("11:30:00", LoggerClock(zone=UTC), "dive.date"),
    ],
)
def test_a_stamp_without_zone_or_day_is_refused_until_given(tmp_path, stamp, clock, remedy):
    (tmp_path / "pressure.csv").write_text(f"t,pascal\n{stamp},5\n")
    with pytest.raises(InputError) as refused:
        list(PlainLog(tmp_path, clock=clock).messages())
    assert remedy in refused.value.remedy
    assert len(list(PlainLog(tmp_path, clock=ON_DECK).messages())) == 1

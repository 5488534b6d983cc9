# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import json
from pathlib import Path

import pytest

from hullrecon.dive.logs.formats.foreign_forms import describe_file, describe_folder
from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.errors import InputError


@pytest.mark.parametrize(
    ("name", "start", "what", "remedy"),
    [
        ("x.raw", b"SO\xd4\x1e", "Oculus", "sonar.csv"),
        ("x.sonar", b"RIP2\xbf", "3-D sonar", "DVL and IMU"),
        ("x.ddf", b"DDF\x04", "DIDSON", "sonar.csv"),
        ("x.bin", b"\xa5\x0a\xa0\x20", "Nortek", "PD0"),
        ("x.csv.gz", b"\x1f\x8b\x08", "gzip", "unpack"),
        ("x.tlog", b"\0\0", "ArduPilot", "convert it to MCAP, or write tables dvl.csv, imu.csv"),
        ("x.nucleus", b"\xa5\x0a\xa0\x20", "Nortek", "or write tables dvl.csv"),
        ("x.svlog", b"\0\0", "SonarView", "MCAP"),
        ("00000012.BIN", b"\xa3\x95\x80\x80", "ArduPilot", "MCAP"),
        ("x.xtf", b"\x7b\0", "side-scan", "not read"),
        ("x.jsf", b"\x01\x16", "side-scan", "not read"),
        ("x.mat", b"MATLAB 5.0 MAT-file", "MATLAB", "dvl.csv"),
        ("x.zip", b"PK\3\4", "archive", "unpack"),
        ("x.tar.gz", b"\x1f\x8b\x08", "archive", "unpack"),
        ("x.ulg", b"ULog\x01", "PX4", "MCAP"),
        ("x.txt", b":SA,-1.20,+0.30", "PD6", "PD0"),
        ("x.log", b"wrz,0.120,", "serial protocol", "JSON that it sends"),
        ("x.nmea", b"$PNORBT1,", "NMEA", "dvl.csv"),
        ("x.nc", b"\x89HDF\r\n", "NetCDF", "dvl.csv"),
        ("x.npz", b"PK\3\4", "NumPy", "dvl.csv"),
        ("x.JPG", b"\xff\xd8", "a photo", "camera_top.csv"),
        ("x.mp4", b"\0\0\0\x18ftyp", "a video", "camera_top.csv"),
    ],
)
def test_a_known_form_is_named_with_what_to_do(tmp_path, name, start, what, remedy):
    found = describe_file(Path(name), start)
    assert what in found[0]
    assert remedy in found[1]
    (tmp_path / name).write_bytes(start + b"x" * 100)
    with pytest.raises(InputError, match="is no log that is read here: ") as caught:
        open_log(tmp_path / name)
    assert remedy in caught.value.remedy


def test_what_nobody_knows_is_told_what_is_read(tmp_path):
    assert describe_file(Path("x.txt"), b"hello") == ("", "")
    (tmp_path / "x.txt").write_text("hello")
    with pytest.raises(InputError, match=r"x\.txt is no log that is read here") as caught:
        open_log(tmp_path / "x.txt")
    assert caught.value.remedy.startswith("give an MCAP, ")


@pytest.mark.parametrize(
    ("names", "what"),
    [
        (["a.jpg", "b.JPG", "notes.md"], "2 photos without times"),
        (["a.pgm", "b.PPM"], "2 photos without times"),
        (["a.mp4", "b.jpg", "c.jpg"], "videos without times"),
        (["nav.csv", "depth.csv.gz", "x.txt"], r"tables of other names \(depth.csv.gz, nav.csv\)"),
        (["a.npz", "b.json.txt"], "archive of NumPy arrays"),
    ],
)
def test_a_folder_without_a_log_is_named_by_what_lies_in_it(tmp_path, names, what):
    for name in names:
        (tmp_path / name).write_bytes(b"x")
    for look in (find_logs, open_log):
        with pytest.raises(InputError, match=f"holds no log that is read here: .*{what}"):
            look(tmp_path)


def test_folder_of_unknown_names_is_described_by_first_bytes(tmp_path):
    (tmp_path / "README").write_text("hello")
    (tmp_path / "a.raw").write_bytes(b"SO\xd4\x1e" + bytes(100))
    with pytest.raises(InputError, match="holds no log that is read here: pings of an Oculus"):
        find_logs(tmp_path)


def test_an_empty_folder_is_none_of_them():
    assert describe_folder([]) == ("", "")


def test_folder_of_cad_models_alone_is_refused_as_no_dive(tmp_path):
    for name in ("a.stl", "b.obj.gz", "c.STL.gz", "notes.md"):
        (tmp_path / name).write_bytes(b"\x1f\x8b\x08" + bytes(20))
    with pytest.raises(
        InputError, match=r"CAD models alone \(a\.stl, b\.obj\.gz, c\.STL\.gz\)"
    ) as caught:
        find_logs(tmp_path)
    assert "its log" in caught.value.remedy
    assert "gunzip" not in caught.value.line()


def test_packed_file_among_others_is_named_as_possible_log(tmp_path):
    (tmp_path / "a.out.gz").write_bytes(b"\x1f\x8b\x08" + bytes(20))
    (tmp_path / "b.txt").write_text("hello")
    with pytest.raises(
        InputError,
        match=r"a\.out\.gz is packed by gzip .*where it is the log, unpack it .*else give an MCAP",
    ):
        find_logs(tmp_path)
    (tmp_path / "z.ping").write_bytes(b"SO\xd4\x1e")
    with pytest.raises(InputError, match="pings of an Oculus"):  # says more
        find_logs(tmp_path)


@pytest.mark.parametrize(
    ("content", "command"), [("[{0},\n{0}]", "jq -c '.[]' "), ("{0}\n{0}", "jq -c . ")]
)
def test_reformatted_dvl_reports_are_refused_with_a_command(tmp_path, content, command):
    report = json.dumps({"vx": 0.1, "transducers": []}, indent=4)
    (tmp_path / "dvl.json").write_text(content.replace("{0}", report))
    for look, path in ((open_log, tmp_path / "dvl.json"), (find_logs, tmp_path)):
        with pytest.raises(
            InputError, match="reports of a Water Linked DVL, but not one a line"
        ) as caught:
            look(path)
        assert command in caught.value.remedy
    (tmp_path / "dvl.json").write_text(json.dumps(json.loads(report)))
    assert find_logs(tmp_path) == [tmp_path / "dvl.json"]

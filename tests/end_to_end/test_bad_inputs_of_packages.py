# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Spoiled packages of a few readings: `check` and `run` end alike, with one line of plain English
and the right exit code.
"""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from hullrecon_cli.main import main

TOML = """[dive]
name = "small"
[logs]
files = ["logs"]
[dvl]
beam_angle_deg = 30.0
beam_azimuth_deg = [180, 0, 90, -90]
[camera.top]
calibration = "top.yaml"
[sonar]
joint = "fan"
[hull]
mesh = "hull.off"
"""
YAML = "image_width: 32\nimage_height: 24\ncamera_matrix: [30, 0, 16, 0, 30, 12, 0, 0, 1]\n"
OFF = "OFF\n4 4 0\n0 0 0\n20 0 0\n0 20 0\n0 0 20\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
TABLES = {
    "dvl": "t,vx,vy,vz,range_1,range_2,range_3,range_4\n0,1,0,0,1,1,1,\n1,1,0,0,2,2,2,2\n"
    "2,1,0,0,2,2,2,2\n",
    "imu": "t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0,1\n2,0,0,0,1\n",
    "pressure": "t,pascal\n0,111380\n1,111380\n2,121435\n",
    "joints": "t,name,rad\n0,tray,0.1\n1,tray,0.2\n0,fan,0.3\n",
    "camera_top": "t,file\n0,a.png\n1,b.png\n2,c.png\n",
    "sonar": "t,file\n0,p.npz\n1,q.npz\n",
}


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "package"
    logs = folder / "logs"
    logs.mkdir(parents=True)
    for name, text in {"dive.toml": TOML, "top.yaml": YAML, "hull.off": OFF}.items():
        (folder / name).write_text(text)
    for name, text in TABLES.items():
        (logs / f"{name}.csv").write_text(text)
    for name in "abc":
        cv2.imwrite(
            str(logs / f"{name}.png"),
            np.random.default_rng(ord(name)).integers(0, 255, (24, 32, 3), np.uint8),
        )
    for name in "pq":
        write_ping(logs / f"{name}.npz")
    return folder


def write_ping(path, **other):
    arrays = {
        "image": np.eye(3, 4, dtype=np.uint8),
        "azimuth": np.array([-0.1, 0, 0.1]),
        "range": np.arange(1.0, 5.0),
        **other,
    }
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})


def toml(old, new):
    return lambda package: (package / "dive.toml").write_text(replaced(TOML, old, new))


def replaced(text, old, new):
    assert old in text
    return text.replace(old, new)


def table(name, text):
    return lambda package: (package / "logs" / f"{name}.csv").write_text(text)


def file(name, data):
    return lambda package: (package / name).write_bytes(data)


def toml_as_folder(package):
    (package / "dive.toml").unlink()
    (package / "dive.toml").mkdir()


def single_log(name, data):
    """The package's log is one file with that content."""

    def spoil(package):
        (package / name).write_bytes(data)
        (package / "dive.toml").write_text(replaced(TOML, '"logs"', f'"{name}"'))

    return spoil


def ping(**other):
    def spoil(package):
        for ping in "pq":
            write_ping(package / "logs" / f"{ping}.npz", **other)

    return spoil


def calibration_as_folder(package):
    (package / "top.yaml").unlink()
    (package / "top.yaml").mkdir()


def all_images(data):
    def spoil(package):
        for name in "abc":
            (package / "logs" / f"{name}.png").write_bytes(data)

    return spoil


BEAMS = "beam_angle_deg = 30.0\nbeam_azimuth_deg = [180, 0, 90, -90]"
TOPICS = '[topics]\nimu = "/imu"\njoints = "/imu"\n'
ZEROS = "t,qx,qy,qz,qw\n0,0,0,0,0\n1,0,0,0,0\n"
REFUSED = {
    "pressure in hectopascal": (
        table("pressure", "t,pascal\n0,1113\n1,1213\n2,1313\n"),
        3,
        r'pressure\.unit = "hPa" \(1\.1 to 2\.9 m deep then\)',
    ),
    "velocities in mm/s": (
        table("dvl", "t,vx,vy,vz\n0,300,0,0\n1,300,0,0\n2,300,0,0\n"),
        3,
        r'"mm/s" \(0\.3 m/s\)',
    ),
    "dive.toml is a folder": (toml_as_folder, 3, r"dive\.toml cannot be read: Is a directory"),
    "dive.toml is not UTF-8": (
        file("dive.toml", TOML.replace("small", "sm\u00e5ll").encode("latin-1")),
        2,
        r"dive\.toml is not UTF-8",
    ),
    "dive.toml has a key twice": (
        toml('name = "small"', 'name = "a"\nname = "b"'),
        2,
        r"not valid TOML",
    ),
    "dive.toml is nested without end": (
        toml('name = "small"', "name = " + "[" * 2000),
        2,
        r"not valid TOML.*nested",
    ),
    "a number of ten thousand digits": (toml("30.0", "3" * 10_000), 2, r"not valid TOML.*digits"),
    "a section is a value": (toml('[sonar]\njoint = "fan"', "sonar = 3"), 2, r"sonar"),
    "one topic for two sensors": (
        toml("[dvl]", TOPICS + "[dvl]"),
        2,
        r"topics\.joints and topics\.imu",
    ),
    "no log is named": (toml('["logs"]', "[]"), 2, r"logs\.files"),
    "one log is named twice": (
        toml('["logs"]', '["logs", "./logs"]'),
        2,
        r"logs\.files names logs twice",
    ),
    "a name that climbs out": (toml('"small"', '".."'), 2, r"dive\.name"),
    "the log is empty": (single_log("x.mcap", b""), 3, r"the log x\.mcap is empty"),
    "the log is a picture": (
        single_log("x.jpg", b"\xff\xd8\xff\xe0 a picture"),
        3,
        r"x\.jpg is no log that is read here",
    ),
    "the log is text called MCAP": (
        single_log("x.mcap", b"this is no log at all\n" * 9),
        3,
        r"no sensor could be read",
    ),
    "a file name of 5,000 characters": (
        toml('["logs"]', f'["{"x" * 5000}"]'),
        2,
        r"expected text of length <= 1000",
    ),
    "a column is missing": (
        table("pressure", "t,bar\n0,1\n"),
        3,
        r"pressure\.csv has no column pascal",
    ),
    "a header that holds no names": (
        table("dvl", TABLES["dvl"].replace("range_4", "range_x")),
        3,
        r"dvl\.csv.*range_x",
    ),
    "text in every number cell": (
        table("pressure", "t,pascal\n0,deep\n1,deeper\n"),
        3,
        r"pressure\.csv has no row that",
    ),
    "quaternions of zeros": (table("imu", ZEROS), 3, r"no attitude"),
    "a quaternion column is missing": (
        table("imu", "t,qx,qy,qz\n0,0,0,0\n"),
        3,
        r"imu\.csv has no column qw",
    ),
    "the same stamp always": (
        table("imu", "t,qx,qy,qz,qw\n" + "5,0,0,0,1\n" * 30),
        3,
        r"imu: all 30 stamps are the same",
    ),
    "stamps in milliseconds": (
        table("imu", "t,qx,qy,qz,qw\n1777887000000,0,0,0,1\n"),
        3,
        r"look like milliseconds",
    ),
    "stamps in nanoseconds": (
        table("dvl", "t,vx,vy,vz\n1777887000000000000,0,0,0\n"),
        3,
        r"look like nanoseconds",
    ),
    "a misspelt joint": (toml('"fan"', '"fun"'), 3, r"did you mean \"fan\""),
    "beams that nothing describes": (toml(BEAMS, ""), 3, r"DVL's 4 beams"),
    "every image is empty": (all_images(b""), 3, r"none of the 3 images of camera_top can be read"),
    "a calibration of another size": (
        file("top.yaml", YAML.replace("32", "64").encode()),
        3,
        r"32 x 24 .* 64 x 24",
    ),
    "the calibration is missing": (
        lambda p: (p / "top.yaml").unlink(),
        3,
        r"top\.yaml is missing|missing: top\.yaml",
    ),
    "the calibration is a folder": (calibration_as_folder, 3, r"top\.yaml cannot be read"),
    "the calibration is nested without end": (
        file("top.yaml", b"[" * 2000),
        3,
        r"top\.yaml is not YAML",
    ),
    "a mesh with NaN": (
        file("hull.off", OFF.replace("20 0 0", "nan 0 0").encode()),
        3,
        r"not finite",
    ),
    "an empty mesh": (file("hull.off", b"OFF\n0 0 0\n"), 3, r"hull\.off"),
    "a mesh of no bytes": (file("hull.off", b""), 3, r"hull\.off"),
    "a mesh in millimetres": (
        file("hull.off", OFF.replace("20", "20000").encode()),
        3,
        r"looks like millimetres",
    ),
    "a mesh in metres declared as millimetres": (
        toml('"hull.off"', '"hull.off"\nunits = "mm"'),
        3,
        r"looks like metres",
    ),
    "every sonar file lacks a member": (ping(azimuth=None), 3, r"p\.npz: it has no azimuth"),
    "every sonar file has another shape": (
        ping(range=np.arange(9.0)),
        3,
        r"sonar\.csv.*\[beams, ranges\]",
    ),
}


@pytest.mark.parametrize(("spoil", "code", "pattern"), REFUSED.values(), ids=REFUSED)
@pytest.mark.parametrize("command", ["check", "run"])
def test_a_spoiled_package_is_refused_in_one_line(
    package, tmp_path, capfd, command, spoil, code, pattern
):
    spoil(package)
    more = ["--runs", str(tmp_path / "runs"), "--to", "ingest"] if command == "run" else []
    found = main([command, str(package), *more])
    out, err = capfd.readouterr()
    lines = [line for line in err.splitlines() if line.startswith("error:")]
    assert "Traceback" not in out + err
    assert len(lines) == 1
    assert re.search(pattern, lines[0]), lines[0]
    assert found == code


CUT = TABLES["imu"][:-6]
TOLD = {
    "text in one number cell": (
        table("pressure", "t,pascal\n0,111380\n1,deep\n2,121435\n"),
        r"line 3 of pressure\.csv",
    ),
    "a table that is cut in its last row": (table("imu", CUT), r"line 4 of imu\.csv"),
    "a stamp beyond all calendars": (
        table("pressure", "t,pascal\n0,111380\n1e30,1\n2,121435\n"),
        r"line 3 of pressure\.csv",
    ),
    "stamps that go backward": (
        table("imu", "t,qx,qy,qz,qw\n3,0,0,0,1\n1,0,0,0,1\n2,0,0,0,1\n"),
        r"the clock jumps by -2",
    ),
    "every range is lost": (
        table("dvl", "t,vx,vy,vz,range_1\n0,1,0,0,\n1,1,0,0,0\n2,1,0,0,\n"),
        r"dvl: every range is lost",
    ),
    "one beam": (
        table("dvl", "t,vx,vy,vz,range_1,range_2,range_3,range_4\n0,1,0,0,1,,,\n1,1,0,0,1,,,\n"),
        r"DVL ranges run from 1\.00 to 1\.00 m",
    ),
    "one quaternion of zeros": (
        table("imu", "t,qx,qy,qz,qw\n0,0,0,0.6,0.8\n1,0,0,0,0\n2,0,0,0.6,0.8\n"),
        r"imu: 1 of 3 readings have no attitude",
    ),
    "one image of no bytes": (
        file("logs/a.png", b""),
        r"camera_top: 1 of 3 images are missing or damaged",
    ),
    "an absurd velocity": (
        table("dvl", "t,vx,vy,vz\n0,1000,0,0\n1,1,0,0\n2,1,0,0\n"),
        r"1 velocities above 15 m/s",
    ),
    "a hull of two centimetres": (
        file("hull.off", OFF.replace("20", "0.02").encode()),
        r"is it a model\?",
    ),
}


@pytest.mark.parametrize(("spoil", "pattern"), TOLD.values(), ids=TOLD)
def test_doubtful_parts_of_a_package_are_named_and_left_out(package, capfd, spoil, pattern):
    spoil(package)
    code = main(["check", str(package)])
    out, err = capfd.readouterr()
    assert code == 0, err
    assert re.search(pattern, out), out

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Real logs of the evaluation data, opened as a user would: each ends in a report or in one line
that says what to do.
"""

import csv
import gzip
import json
import shutil

import cv2
import pytest


def verdict(shell, *arguments, code=3):
    """The last line of `check`, which the one line of the error repeats."""
    done = shell("check", *arguments, code=code)
    errors = [line for line in done.stderr.splitlines() if line.startswith("error:")]
    assert len(errors) == (code != 0)
    last = done.stdout.splitlines()[-1] if done.stdout else ""
    assert not last or last.startswith("verdict: ready" if code == 0 else "verdict: not ready: ")
    return errors[0] if errors else last


def test_a_bag_without_camera_or_dvl_is_described_in_words(evaluation_data, shell):
    words = shell(
        "check", evaluation_data / "ros1-micron-bag" / "static_sonar.bag", code=3
    ).stdout.lower()
    assert "/tritech_micron/scan" in words
    assert "553" in words
    for missing in ("dvl", "camera"):
        assert missing in words


def test_bag_without_camera_or_dvl_is_not_ready(evaluation_data, shell, tmp_path):
    shutil.copy(evaluation_data / "ros1-micron-bag" / "static_sonar.bag", tmp_path)
    shell("init", tmp_path)
    assert "missing: a DVL with an IMU, or two cameras" in verdict(shell, tmp_path)
    shell("run", tmp_path, "--runs", "out", code=3)


def test_a_glider_s_pd0_is_described_in_words(evaluation_data, shell):
    words = shell(
        "check", evaluation_data / "dvl-pd0-slocum" / "LA100204.PD0", code=3
    ).stdout.lower()
    assert "107" in words


def test_a_glider_s_pd0_alone_ends_in_a_report(evaluation_data, shell, tmp_path):
    """Bottom track, compass, tilts and depth are all in the file; what is not is how the instrument
    sits in the vehicle.
    """
    package = tmp_path / "glider"
    package.mkdir()
    shutil.copy(evaluation_data / "dvl-pd0-slocum" / "LA100204.PD0", package)
    assert "to fill in: imu.mount_deg" in shell("init", package).stdout
    assert "nothing says how the DVL sits in the vehicle (imu.mount_deg)" in verdict(shell, package)
    down = ["--set", "imu.mount_deg=[0, 0, 0]", "--set", "dvl.mount=[0, 0, 0, 0, 0, 0]"]
    assert verdict(shell, package, *down, code=0).startswith("verdict: ready, with warnings")
    shell("run", package, *down, "--runs", "out")
    found = json.loads((shell.folder / "out" / "glider" / "deliver" / "summary.json").read_text())
    assert any(
        "attitude comes from the DVL's own sensors" in warning for warning in found["warnings"]
    )
    assert (shell.folder / "out" / "glider" / "deliver" / "report" / "index.html").is_file()


def test_a_current_profiler_without_bottom_track_is_not_ready(evaluation_data, shell, tmp_path):
    shutil.copy(evaluation_data / "dvl-pd0-slocum" / "ADCP_CCE1T_20.000", tmp_path / "x.pd0")
    shell("init", tmp_path)
    assert "20 pings have no velocity over ground" in verdict(
        shell, tmp_path, "--set", "imu.mount_deg=[0, 0, 0]"
    )


def test_oculus_pings_are_read_once_their_times_are_given(evaluation_data, shell, tmp_path):
    line = verdict(shell, evaluation_data / "oculus-pings")
    assert "pings of an Oculus sonar without the time of day" in line
    assert "name file and ping in sonar.csv" in line
    shutil.copy(evaluation_data / "oculus-pings" / "three_pings_8bit.raw", tmp_path)
    rows = "".join(f"{1.7e9 + n},three_pings_8bit.raw,{n}\n" for n in range(3))
    (tmp_path / "sonar.csv").write_text(f"t,file,ping\n{rows}")
    assert "sonar: 3 messages" in shell("init", tmp_path).stdout
    assert "missing: a DVL with an IMU, or two cameras" in verdict(shell, tmp_path)


def test_arrays_of_a_simulator_are_named_with_what_to_do(evaluation_data, shell):
    line = verdict(shell, evaluation_data / "fls-simpleboat")
    assert "an archive of NumPy arrays" in line
    assert "write its sensors as tables dvl.csv" in line


def test_a_three_dimensional_sonar_is_named(evaluation_data, shell):
    assert "a recording of a 3-D sonar" in verdict(shell, evaluation_data / "sonar3d-ship")


def test_tables_of_unknown_names_are_read_once_rewritten(evaluation_data, shell, tmp_path):
    source = evaluation_data / "dvl-caves"
    assert (
        "tables of other names (asekf_slam.csv, camera_times.csv.gz, depth_sensor.csv.gz, ...)"
        in verdict(shell, source)
    )
    with (
        gzip.open(source / "depth_sensor.csv.gz", "rt") as stream,
        (tmp_path / "pressure.csv").open("w") as out,
    ):
        out.write("t,pascal\n")
        reader = csv.reader(stream)
        head = next(reader)
        stamp, depth = (
            next(n for n, name in enumerate(head) if part in name) for part in ("time", "depth")
        )
        out.writelines(
            f"{int(row[stamp]) / 1e9:.9f},{101325 + 1025 * 9.81 * float(row[depth])}\n"
            for row in reader
        )
    shell("init", tmp_path)
    assert "depth runs from 1.2 to 18." in shell("check", tmp_path, code=3).stdout


@pytest.fixture
def photos(evaluation_data, tmp_path):
    """The photos of a stereo rig, with what their owner does not give: times and a calibration."""
    for side, camera, focal in (("Left", "camera_top", 1594), ("Right", "camera_bottom", 1565)):
        names = sorted(
            p.name for p in (evaluation_data / "stereo-haltbrekken").glob(f"{side}*.jpg")
        )
        for name in names:
            shutil.copy(evaluation_data / "stereo-haltbrekken" / name, tmp_path)
        (tmp_path / f"{camera}.csv").write_text(
            "t,file\n" + "".join(f"{1.4e9 + n},{name}\n" for n, name in enumerate(names))
        )
        height, width = cv2.imread(str(tmp_path / names[0])).shape[:2]
        matrix = f"[{focal}, 0, {width / 2}, 0, {focal}, {height / 2}, 0, 0, 1]"
        size = f"image_width: {width}\nimage_height: {height}\n"
        text = f"{size}camera_matrix: {matrix}\ndistortion_coefficients: [0.12, 0, 0, 0, 0]\n"
        (tmp_path / f"{camera}.yaml").write_text(text)
    return tmp_path


def test_photos_ask_for_their_times_and_are_then_ready(evaluation_data, shell, photos):
    line = verdict(shell, evaluation_data / "stereo-haltbrekken")
    assert "44 photos without times" in line
    assert "camera_top.csv with columns t (s since 1970) and file" in line
    asked = shell("init", photos).stdout
    assert "to fill in: camera.bottom.pose_in_top" in asked
    pose = "camera.bottom.pose_in_top=[0.3035, 0.0182, 0.0256, -1.597, 2.637, -4.618]"
    assert verdict(shell, photos, "--set", pose, code=0).startswith("verdict: ready")


def test_what_is_no_dive_is_named_for_what_it_is(evaluation_data, shell):
    assert "CAD models alone (DTC-scaled_decimated30k.stl, " in verdict(
        shell, evaluation_data / "hulls"
    )
    line = verdict(shell, evaluation_data / "ba-small")
    assert "Balbianello.out.gz is packed by gzip" in line
    assert "where it is the log, unpack it first (gunzip); else give an MCAP" in line


def test_several_glider_dives_in_one_folder_are_to_be_parted(evaluation_data, shell, tmp_path):
    package = tmp_path / "glider"
    # not copied as a tree: the data's folder may be read-only, and its copy would be
    package.mkdir()
    for file in (evaluation_data / "dvl-pd0-slocum").iterdir():
        shutil.copy(file, package)
    said = shell("init", package).stdout
    # found by its first bytes, and named
    assert "ADCP_CCE1T_20.000: no ensemble has a bottom track" in said
    down = ["--set", "imu.mount_deg=[0, 0, 0]", "--set", "dvl.mount=[0, 0, 0, 0, 0, 0]"]
    line = verdict(shell, package, *down)
    assert (
        "these are several dives (logs.files): give one at a time, by other files or by "
        "dive.from and dive.to" in line
    )
    assert (
        line.removeprefix("error: no run is possible: ")
        in shell("run", package, *down, "--runs", "out", code=3).stderr
    )

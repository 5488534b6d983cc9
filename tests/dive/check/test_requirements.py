# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

import pytest

from hullrecon.dive.check.requirements import configured_sensors, to_fill_in
from hullrecon.dive.config.load import LoadedConfig, load_config
from hullrecon.findings.finding import sentences
from hullrecon.findings.package import MEANING

EVERYTHING = {"dvl", "imu", "pressure", "camera_top", "camera_bottom", "sonar", "position"}
MOUNT = "[1, 2, 3, 4, 5, 6]"


def load(folder: Path, text: str = "") -> LoadedConfig:
    (folder / "dive.toml").write_text(f'[dive]\nname = "x"\n[logs]\nfiles = ["logs"]\n{text}')
    return load_config(folder)


def keys(lines: list[str]) -> set[str]:
    return {line.split(": ")[1] for line in lines}


def test_each_needed_key_is_asked_for_with_meaning_and_default(tmp_path):
    cameras = '[camera.top]\ncalibration = "a"\n[camera.bottom]\ncalibration = "b"\n'
    text = cameras + '[sonar]\n[hull]\nmesh = "h.stl"\n'
    lines = sentences(to_fill_in(load(tmp_path, text), EVERYTHING))
    assert keys(lines) == set(MEANING)
    (line,) = [line for line in lines if "pressure.origin" in line]
    assert line.endswith("until then what the log's tf_static says, else [0, 0, 0] is used")
    assert "x forward, y starboard, z down" in line


def test_a_key_that_is_given_is_not_asked_for(tmp_path):
    lines = sentences(to_fill_in(load(tmp_path, f"[dvl]\nmount = {MOUNT}\n"), {"dvl"}))
    assert keys(lines) == {"tray.origin"}


def test_a_key_of_a_sensor_that_was_not_logged_is_not_asked_for(tmp_path):
    assert sentences(to_fill_in(load(tmp_path), {"imu"})) == []


@pytest.mark.parametrize("camera", ["camera_top", "camera_bottom"])
def test_a_camera_without_a_section_needs_a_calibration(tmp_path, camera):
    lines = sentences(to_fill_in(load(tmp_path), {camera}))
    section = camera.replace("_", ".")
    (line,) = [
        line
        for line in lines
        if line.startswith(f"to fill in: {section}.calibration: the camera_info YAML of {camera}")
    ]
    assert (
        f"[{section}] alone where the log has its CameraInfo; until then its images are not used"
        in line
    )
    sections = dict.fromkeys(("camera.top", section))
    text = "".join(f'[{name}]\ncalibration = "a"\n' for name in sections)
    given = load(tmp_path, text)
    assert f"{section}.calibration" not in keys(sentences(to_fill_in(given, {camera})))


def test_sensors_are_those_of_the_topics(tmp_path):
    loaded = load(tmp_path, '[topics]\ndvl = "/dvl"\ncamera_top = "/camera"\n')
    assert configured_sensors(loaded) == {"dvl", "camera_top"}


def test_sensors_of_plain_files_are_those_of_the_tables(tmp_path):
    (tmp_path / "logs").mkdir()
    for name in ("imu.csv", "pressure.csv", "notes.csv", "sonar.txt"):
        (tmp_path / "logs" / name).touch()
    assert configured_sensors(load(tmp_path)) == {"imu", "pressure"}


def test_logs_that_are_not_there_name_no_sensor(tmp_path):
    assert configured_sensors(load(tmp_path)) == set()

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""check and init as a user calls them: what is said, where, and the exit code."""

import json
import os
import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from datasets import dataset
from hullrecon_cli.main import main

from hullrecon.api.dive_run import run
from hullrecon.errors import InputError

TOML = """[dive]
name = "small"
vessel = "MV Small"
[logs]
files = ["logs"]
[dvl]
beam_angle_deg = 30.0
beam_azimuth_deg = [180, 0, 90, -90]
[camera.top]
calibration = "top.yaml"
[hull]
mesh = "hull.off"
"""
YAML = "image_width: 32\nimage_height: 24\ncamera_matrix: [30, 0, 16, 0, 30, 12, 0, 0, 1]\n"
TETRAHEDRON = "OFF\n4 4 0\n0 0 0\n{0} 0 0\n0 {0} 0\n0 0 {0}\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "package"
    logs = folder / "logs"
    logs.mkdir(parents=True)
    (folder / "dive.toml").write_text(TOML)
    (folder / "top.yaml").write_text(YAML)
    (folder / "hull.off").write_text(TETRAHEDRON.format(20))
    (logs / "pressure.csv").write_text("t,pascal\n0,113391\n1,135512\n")
    (logs / "imu.csv").write_text("t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0,1\n")
    (logs / "dvl.csv").write_text(
        "t,vx,vy,vz,range_1,range_2,range_3,range_4\n0,1,0,0,1,1,1,\n1,1,0,0,2,2,2,2\n"
    )
    for name in "abc":
        cv2.imwrite(
            str(logs / f"{name}.jpg"),
            np.random.default_rng(ord(name)).integers(0, 255, (24, 32, 3), np.uint8),
        )
    (logs / "camera_top.csv").write_text("t,file\n0.4,a.jpg\n0.8,b.jpg\n1.2,c.jpg\n")
    return folder


def call(capsys, *arguments) -> tuple[int, str, str]:
    code = main([str(a) for a in arguments])
    out, err = capsys.readouterr()
    return code, out, err


def complaint(capsys, *arguments) -> tuple[int, str]:
    """Exit code and the one line of the error."""
    code, out, err = call(capsys, *arguments)
    lines = [line for line in err.splitlines() if line.startswith("error:")]
    assert len(lines) == 1
    assert "Traceback" not in out + err
    return code, lines[0]


def test_check_says_in_words_what_a_package_holds(capsys, package):
    code, out, _ = call(capsys, "check", package)
    assert code == 0
    lines = out.splitlines()
    assert lines[0] == "small: MV Small"
    assert "depth runs from 1.2 to 3.4 m" in lines
    assert "the first camera image is 0.4 s after the first DVL ping" in lines
    assert any(line.startswith("no sonar") for line in lines)
    assert any(
        line.startswith("defaults used: ") and "dvl.mount_sigma = [0.01, " in line for line in lines
    )


def test_check_ends_with_3_where_no_run_is_possible(capsys, package):
    (package / "logs" / "imu.csv").unlink()
    code, out, err = call(capsys, "check", package)
    assert code == 3
    assert any(
        line.startswith("no imu: ") and "no run is possible" in line for line in out.splitlines()
    )
    assert err.splitlines()[-1].startswith(
        "error: no run is possible: missing: an IMU with attitude"
    )
    code, out, err = call(capsys, "check", package, "--json")
    assert (code, json.loads(out)["run_is_possible"]) == (3, False)
    assert "error" not in err


def test_check_lists_missing_files_and_reads_the_rest(capsys, package):
    (package / "top.yaml").unlink()
    (package / "hull.off").unlink()
    code, out, err = call(capsys, "check", package)
    assert code == 3
    lines = out.splitlines()
    assert "missing: top.yaml (camera.top.calibration)" in lines
    assert "missing: hull.off (hull.mesh)" in lines
    assert "depth runs from 1.2 to 3.4 m" in lines
    assert (
        "missing: top.yaml (camera.top.calibration); missing: hull.off (hull.mesh)"
        in err.splitlines()[-1]
    )


def _without(*names):
    return lambda package: [(package / name).unlink() for name in names]


def _rewrite(old, new, name="dive.toml"):
    return lambda package: (package / name).write_text(
        (package / name).read_text().replace(old, new)
    )


SPOILED = {
    "no dive.toml": _without("dive.toml"),
    "an unknown key": _rewrite("[hull]", "[hull]\nmash = 1"),
    "no log": _rewrite('["logs"]', '["gone"]'),
    "no IMU": _without("logs/imu.csv"),
    "files are missing": _without("top.yaml", "hull.off"),
    "no beams": _rewrite("beam_angle_deg = 30.0\nbeam_azimuth_deg = [180, 0, 90, -90]", ""),
    "a misspelt joint": _rewrite("[hull]", '[tray]\njoint = "tary"\n[hull]'),
    "a hull in millimetres": lambda package: (package / "hull.off").write_text(
        TETRAHEDRON.format(20000)
    ),
    "a calibration of another size": _rewrite("32", "64", "top.yaml"),
    "stamps in ms": lambda package: (package / "logs" / "imu.csv").write_text(
        "t,qx,qy,qz,qw\n1777887000000,0,0,0,1\n"
    ),
    "a cut table": lambda package: (package / "logs" / "dvl.csv").write_text("t,vx\n"),
    "nothing wrong": lambda package: None,
}


@pytest.mark.parametrize("what", SPOILED)
def test_check_never_tells_one_to_see_check(capsys, package, what):
    SPOILED[what](package)
    for more in ([], ["--json"]):
        _, out, err = call(capsys, "check", package, *more)
        assert not re.search(
            r"(?i)\bhullrecon check\b|\b(see|run|try|call|with|by) `?check\b", out + err
        ), out + err


def test_wrong_set_option_of_check_does_not_blame_the_file(capsys, package):
    code, line = complaint(capsys, "check", package, "--set", "tray.sigma_deg=wide")
    assert code == 2
    assert line.startswith("error: tray.sigma_deg = 'wide': expected a number")
    assert line.endswith("(from --set)")


def test_run_warns_of_what_is_left_to_defaults(capsys, package):
    code, _, err = call(capsys, "run", package, "--runs", package.parent / "runs", "--to", "ingest")
    assert code == 0
    warnings = [line for line in err.splitlines() if line.startswith("warning: to fill in: ")]
    keys = {line.split(": ")[2] for line in warnings}
    assert {"tray.origin", "pressure.origin", "dvl.mount", "camera.top.mount", "hull.pose"} <= keys
    assert "sonar.mount" not in keys


def test_check_asks_where_the_beams_point(capsys, package):
    (package / "dive.toml").write_text(
        TOML.replace("beam_angle_deg = 30.0\nbeam_azimuth_deg = [180, 0, 90, -90]", "")
    )
    code, line = complaint(capsys, "check", package)
    assert code == 3
    assert "nothing says where the DVL's 4 beams point" in line
    assert "beam_azimuth_deg" in line


def test_check_as_json_is_one_document(capsys, package):
    code, out, _ = call(capsys, "check", package, "--json")
    document = json.loads(out)
    assert code == 0
    assert document["streams"]["pressure"]["count"] == 2
    assert document["defaults"]["dvl.scale_sigma"] == 0.005


def test_check_takes_options_in_place_of_the_files(capsys, package):
    _, out, _ = call(capsys, "check", package, "--set", "pressure.atmosphere=113391")
    assert "depth runs from 0.0 to 2.2 m" in out


def test_check_of_bare_log_says_what_is_missing(capsys, package):
    code, out, err = call(capsys, "check", package / "logs")
    assert code == 3
    assert out.splitlines()[-1].startswith("verdict: not ready: no dive.toml yet")
    assert err.splitlines()[-1].startswith("error: no run is possible: no dive.toml yet")
    assert "pressure: 2 messages in 1.0 s, 1.0 Hz" in out
    assert "no sonar" in out
    assert "`hullrecon init " in out


def test_check_of_a_real_bag_ends_well(capsys):
    code, out, _ = call(capsys, "check", dataset("ros1-micron-bag") / "static_sonar.bag")
    assert code == 3
    assert out.splitlines()[-1].endswith("; missing: a DVL with an IMU, or two cameras")
    assert "2784 messages on 7 topics" in out


def test_init_writes_a_configuration_that_check_accepts(capsys, package):
    (package / "dive.toml").unlink()
    code, out, _ = call(capsys, "init", package / "logs", "--out", package)
    assert code == 0
    assert "wrote" in out
    asked = [line for line in out.splitlines() if line.startswith("to fill in: ")]
    assert any("dvl.mount" in line for line in asked)
    beams = ["--set", "dvl.beam_angle_deg=30", "--set", "dvl.beam_azimuth_deg=[180, 0, 90, -90]"]
    code, out, _ = call(capsys, "check", package, *beams)
    assert code == 0
    told = [line for line in out.splitlines() if line.startswith("to fill in: ")]
    assert told == [line for line in asked if "beams" not in line]


def test_init_and_check_ask_for_the_beams_in_the_same_words(capsys, package):
    (package / "dive.toml").unlink()
    _, out, _ = call(capsys, "init", package)
    asked = next(line for line in out.splitlines() if "beams point" in line)
    code, line = complaint(capsys, "check", package)
    assert code == 3
    assert line.removeprefix("error: no run is possible: ") == asked.removeprefix("to fill in: ")


def test_init_of_a_folder_writes_into_it(capsys, package, monkeypatch, tmp_path):
    (package / "dive.toml").unlink()
    monkeypatch.chdir(tmp_path)
    assert call(capsys, "init", "package")[0] == 0
    assert not (tmp_path / "dive.toml").exists()
    assert 'files = ["logs"]' in (package / "dive.toml").read_text()
    assert call(capsys, "init", "package/logs")[0] == 0
    assert 'files = ["."]' in (package / "logs" / "dive.toml").read_text()


def test_init_of_a_file_writes_into_the_current_folder(capsys, monkeypatch, tmp_path):
    log = dataset("ros1-micron-bag") / "static_sonar.bag"
    (tmp_path / "here").mkdir()
    (tmp_path / "logs").mkdir()
    shutil.copy(log, tmp_path / "logs" / "x.bag")
    monkeypatch.chdir(tmp_path / "here")
    assert call(capsys, "init", "../logs/x.bag")[0] == 0
    assert 'files = ["../logs/x.bag"]' in (tmp_path / "here" / "dive.toml").read_text()
    assert not (tmp_path / "dive.toml").exists()


def test_init_of_a_folder_without_a_log_is_an_input_error(capsys, tmp_path):
    (tmp_path / "photos").mkdir()
    code, line = complaint(capsys, "init", tmp_path / "photos")
    assert code == 3
    assert "photos holds no log" in line


def test_init_does_not_replace_a_configuration_unasked(capsys, package):
    before = (package / "dive.toml").read_text()
    code, line = complaint(capsys, "init", package / "logs", "--out", package)
    assert code == 2
    assert "--force" in line
    assert (package / "dive.toml").read_text() == before
    assert call(capsys, "init", package / "logs", "--out", package, "--force")[0] == 0
    assert (package / "dive.toml").read_text() != before


def test_init_of_a_log_whose_name_is_not_utf8_is_an_input_error(capsys, package, tmp_path):
    named = tmp_path / os.fsdecode(b"Log \xe9")
    shutil.copytree(package / "logs", named)
    code, line = complaint(capsys, "init", named, "--out", tmp_path / "new")
    assert code == 3
    assert "the name is not UTF-8" in line
    assert not (tmp_path / "new").exists()
    named.rename(tmp_path / "renamed")
    (tmp_path / "new").mkdir()
    assert call(capsys, "init", tmp_path / "renamed", "--out", tmp_path / "new")[0] == 0


def test_init_of_what_is_no_log_is_an_input_error(capsys, tmp_path):
    (tmp_path / "x.txt").write_text("hello")
    assert complaint(capsys, "init", tmp_path / "x.txt")[0] == 3


def test_no_configuration_is_one_line_and_code_three(capsys, tmp_path):
    code, line = complaint(capsys, "check", tmp_path)
    assert code == 3
    assert "no dive.toml" in line


def test_an_unknown_key_is_one_line_and_code_two(capsys, package):
    (package / "dive.toml").write_text(TOML.replace("vessel", "vesel"))
    code, line = complaint(capsys, "check", package)
    assert code == 2
    assert "unknown key dive.vesel" in line
    assert "dive.vessel" in line


def test_a_missing_log_is_one_line_and_code_three(capsys, package):
    shutil.move(package / "logs", package / "elsewhere")
    code, line = complaint(capsys, "check", package)
    assert code == 3
    assert "the log logs is missing" in line
    assert "elsewhere" in line


def test_a_corrupt_jpeg_among_good_ones_survives_and_is_counted(capsys, package):
    path = package / "logs" / "b.jpg"
    path.write_bytes(path.read_bytes()[:200])
    code, out, _ = call(capsys, "check", package)
    assert code == 0
    assert "1 of 3 images are missing or damaged" in out


def test_a_hull_in_millimetres_is_one_line_and_code_three(capsys, package):
    (package / "hull.off").write_text(TETRAHEDRON.format(20_000))
    code, line = complaint(capsys, "check", package)
    assert code == 3
    assert "looks like millimetres" in line


def test_a_bow_across_the_ship_is_one_line_and_code_three(capsys, package):
    (package / "hull.off").write_text(TETRAHEDRON.format(20).replace("0 20 0", "0 5 0"))
    _, out, _ = call(capsys, "check", package)
    assert "bow: at x = +20.0 m of the CAD model" in out
    (package / "dive.toml").write_text(TOML.replace("[hull]", '[hull]\nbow = "+y"'))
    code, line = complaint(capsys, "check", package)
    assert code == 3
    assert (
        "the bow cannot lie at +y: the CAD model is 20.0 m along x, 5.0 m along y (hull.bow):"
        ' give "+x" or "-x"' in line
    )
    (package / "dive.toml").write_text(TOML.replace("[hull]", '[hull]\nbow = "-x"'))
    assert "the bow cannot lie" not in call(capsys, "check", package)[1]
    (package / "dive.toml").write_text(TOML.replace("[hull]", '[hull]\nbow = "x"'))
    assert complaint(capsys, "check", package)[0] == 2


def test_run_refuses_bow_across_the_ship_before_reading(capsys, package, tmp_path):
    (package / "hull.off").write_text(TETRAHEDRON.format(20).replace("0 20 0", "0 5 0"))
    (package / "dive.toml").write_text(TOML.replace("[hull]", '[hull]\nbow = "+y"'))
    code, line = complaint(capsys, "run", package, "--runs", tmp_path / "runs")
    assert code == 3
    assert "the bow cannot lie at +y" in line
    assert not list((tmp_path / "runs").glob("*/ingest"))
    with pytest.raises(InputError, match="the bow cannot lie at"):
        run(package, tmp_path / "runs")
    assert not list((tmp_path / "runs").glob("*/ingest"))
    # which does not ask for it
    code, out, _ = call(capsys, "run", package, "--runs", tmp_path / "runs", "--to", "ingest")
    assert (code, out.split()[:2]) == (0, ["ingest", "ran"])


def test_calibration_of_another_size_ends_with_code_3(capsys, package):
    larger = "image_width: 640\nimage_height: 480\n"
    matrix = "camera_matrix: [600, 0, 320, 0, 600, 240, 0, 0, 1]\n"
    (package / "top.yaml").write_text(larger + matrix)
    code, line = complaint(capsys, "check", package)
    assert code == 3
    assert "32 x 24" in line
    assert "640 x 480" in line


def test_check_ends_with_a_verdict_whatever_stands_against_a_run(capsys, package, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "table").mkdir()
    (tmp_path / "table" / "dvl.csv").write_text("time;speed\n0;1\n")
    (package / "dive.toml").write_text(TOML.replace("vessel", "vesel"))
    wanted = {
        "empty": "no dive.toml",
        "table": "no column vx",
        "nowhere": "no dive.toml",
        "package": "unknown key dive.vesel",
    }
    for name, reason in wanted.items():
        code, out, err = call(capsys, "check", tmp_path / name)
        assert code in (2, 3)
        verdicts = [line for line in out.splitlines() if line.startswith("verdict: ")]
        assert verdicts == [
            line.replace("error: ", "verdict: not ready: ") for line in err.splitlines()
        ]
        assert reason in verdicts[0]
    code, out, _ = call(capsys, "check", tmp_path / "empty", "--json")
    assert json.loads(out)["error"]["exit_code"] == code == 3


def test_init_and_check_explain_a_log_without_messages(capsys, tmp_path):
    from benchmarks.fuzz.seed_ad2cp import TEXT, block

    (tmp_path / "profiles.ad2cp").write_bytes(block(0x16, bytes(100)) + block(TEXT, b"x" * 20))
    for command in ("init", "check"):
        code, line = complaint(capsys, command, tmp_path)
        assert code == 3
        assert "no bottom-track record was read from it" in line
        assert "a run needs a DVL with an IMU, or two cameras" in line
        assert "`hullrecon init" not in line
    assert not (tmp_path / "dive.toml").exists()

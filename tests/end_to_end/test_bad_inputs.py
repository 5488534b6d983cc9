# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Ten bad inputs: each ends with one clear line and the right exit code, and nothing is lost."""

import json
import os
import re
import shutil

import pytest
from end_to_end.shell import SAMPLE, TINY, edit

from hullrecon.artifacts.workspace import Workspace


def assert_one_line(done, *words):
    """The single line of error, which holds these words."""
    lines = [line for line in done.stderr.splitlines() if line.startswith("error:")]
    assert len(lines) == 1, done.stderr
    assert "Traceback" not in done.stderr
    for word in words:
        assert word.lower() in lines[0].lower(), lines[0]
    return lines[0]


def test_no_dive_toml(shell, tmp_path):
    (tmp_path / "empty").mkdir()
    assert_one_line(shell("run", "empty", "--runs", "out", code=3), "dive.toml")


def test_an_unknown_key_names_the_nearest_known_one(shell, package):
    edit(package, "sigma_velocity", "sigma_velocty")
    assert_one_line(
        shell("run", package, "--runs", "out", code=2), "sigma_velocty", "sigma_velocity"
    )


def test_a_missing_log(shell, package):
    for log in (package / "logs").iterdir():
        log.unlink()
    assert_one_line(shell("run", package, "--runs", "out", code=3), "logs/")


def test_a_truncated_mcap_is_salvaged_and_the_lost_span_named(shell, tmp_path):
    package = shutil.copytree(SAMPLE, tmp_path / "cut")
    log = next((package / "logs").glob("*.mcap"))
    os.truncate(log, int(0.8 * log.stat().st_size))
    shell("run", package, "--runs", "out", "--to", "ingest")
    findings = json.loads(
        (shell.folder / "out" / package_name(package) / "ingest" / "findings.json").read_text()
    )
    assert findings["lost"]
    assert "dvl" in json.dumps(findings["lost"]).lower()


def package_name(package):
    return re.search(r'name = "(.+)"', (package / "dive.toml").read_text()).group(1)


def test_a_corrupt_jpeg_among_good_ones_survives_and_is_counted(shell, tmp_path):
    plain = tmp_path / "plain"
    shell(
        "simulate",
        plain,
        *TINY,
        "--form",
        "plain",
        "--leg-length-m",
        1.2,
        "--structures",
        0,
        "--seed",
        6,
    )
    image = sorted(plain.rglob("*.jpg"))[2]
    image.write_bytes(b"\xff\xd8 this is no picture")
    shell("run", plain, "--runs", "out", "--to", "features")
    findings = (shell.folder / "out" / package_name(plain) / "ingest" / "findings.json").read_text()
    assert re.search(r"\b1\b[^\"]*image", findings)


def test_an_absent_topic_is_named_with_those_that_are_there(shell, package):
    edit(package, 'dvl = "/dvl"', 'dvl = "/dvll"')
    assert_one_line(shell("run", package, "--runs", "out", code=3), "/dvll", "/dvl")


def test_a_hull_in_millimetres_declared_as_metres(shell, package):
    import trimesh

    mesh = trimesh.load_mesh(package / "hull.stl")
    mesh.apply_scale(1000.0)
    mesh.export(package / "hull.stl")
    assert_one_line(shell("run", package, "--runs", "out", code=3), "millimetres")


def test_a_camera_yaml_of_another_size(shell, package):
    yaml = package / "calibration" / "camera_top.yaml"
    yaml.write_text(yaml.read_text().replace("image_width: 320", "image_width: 640"))
    assert_one_line(shell("run", package, "--runs", "out", code=3), "640", "320")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere: see the next test")
def test_a_read_only_output_folder(shell, package):
    (shell.folder / "out").mkdir(mode=0o555)
    assert_one_line(shell("run", package, "--runs", "out", code=6), "out")


def test_an_output_folder_that_cannot_be_made(shell, package):
    (shell.folder / "out").write_text("a file stands where the folder should be")
    assert_one_line(shell("run", package, "--runs", "out", code=6), "out")


def test_a_run_on_a_dive_that_another_process_works_on(shell, package):
    """That process is this one: it holds the dive's lock until the run is refused, however busy the
    machine.
    """
    with Workspace(shell.folder / "out" / package_name(package)).lock():
        assert_one_line(
            shell("run", package, "--runs", "out", code=5), f"locked by process {os.getpid()}"
        )

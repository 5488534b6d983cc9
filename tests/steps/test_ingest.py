# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from hullrecon.artifacts.manifest import HashCache
from hullrecon.artifacts.recipe import make_job
from hullrecon.artifacts.runner import run_stage
from hullrecon.artifacts.stage import StageSettings, load_arrays
from hullrecon.dive.config.load import load_config
from hullrecon.dive.config.schema import FROM_LOG, Dvl
from hullrecon.dive.images.store import ImageStore
from hullrecon.errors import InputError
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PressureSamples,
)
from hullrecon.records.serialisation import from_arrays
from hullrecon.steps.artifacts import IngestArtifact, InputArtifacts
from hullrecon.steps.chain import stage
from hullrecon.steps.conditions import files_to_ingest
from hullrecon.steps.ingest import ingest_settings, request_of

STAGE = stage("ingest")

TOML = """
[dive]
name = "plain"
[logs]
files = ["logs"]
[tray]
joint = "tray"
[dvl]
beam_angle_deg = 30.0
beam_azimuth_deg = [180, 0, 90, -90]
[sonar]
joint = "fan"
[camera.top]
calibration = "top.yaml"
time_offset = 0.5
[hull]
mesh = "hull.off"
"""
YAML = "image_width: 32\nimage_height: 24\ncamera_matrix: [30, 0, 16, 0, 30, 12, 0, 0, 1]\n"
TETRAHEDRON = "OFF\n4 4 0\n0 0 0\n20 0 0\n0 20 0\n0 0 20\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Three seconds of plain files."""
    folder = tmp_path / "package"
    logs = folder / "logs"
    logs.mkdir(parents=True)
    (folder / "dive.toml").write_text(TOML)
    (folder / "top.yaml").write_text(YAML)
    (folder / "hull.off").write_text(TETRAHEDRON)
    (logs / "dvl.csv").write_text(
        "t,vx,vy,vz,range_1,range_2,range_3,range_4\n0,1,0,0,1,1,1,\n1,1,0,0,2,2,2,2\n"
    )
    (logs / "imu.csv").write_text("t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0,1\n")
    (logs / "pressure.csv").write_text("t,pascal\n0,101325\n2,111380.25\n")
    (logs / "joints.csv").write_text("t,name,rad\n0,tray,0.1\n1,tray,0.2\n0,fan,0.3\n")
    pixels = np.random.default_rng(1).integers(0, 255, (24, 32, 3), np.uint8)
    cv2.imwrite(str(logs / "a.png"), pixels)
    (logs / "b.png").write_bytes(b"broken")
    (logs / "camera_top.csv").write_text("t,file\n0,a.png\n1,b.png\n")
    np.savez(
        logs / "p.npz",
        image=np.eye(3, 4, dtype=np.uint8),
        azimuth=[-0.1, 0, 0.1],
        range=[1.0, 2, 3, 4],
    )
    (logs / "sonar.csv").write_text("t,file\n0,p.npz\n")
    return folder


def run(package: Path, out: Path, *overrides: str) -> Path:
    loaded = load_config(package, {"ingest": STAGE.parameters}, overrides)
    return run_stage(STAGE, loaded.sections, {}, out, source=package)


def test_the_artifact_holds_a_record_of_every_sensor(package, tmp_path):
    out = run(package, tmp_path / "ingest")
    kinds = {
        "dvl": DvlPings,
        "imu": ImuSamples,
        "pressure": PressureSamples,
        "tray": JointSamples,
        "sonar_tray": JointSamples,
        "images_camera_top": ImageIndex,
    }
    found = {
        name: from_arrays(kind, load_arrays(out / f"{name}.npz")) for name, kind in kinds.items()
    }
    assert np.isnan(found["dvl"].ranges[0, 3])
    assert found["pressure"].depth == pytest.approx([0, 1.0])
    assert found["tray"].angle.tolist() == [0.1, 0.2]
    assert found["sonar_tray"].angle.tolist() == [0.3]
    pings = IngestArtifact(out).sonar
    assert isinstance(pings.image, np.memmap)
    assert pings.image.shape == (1, len(pings.directions), len(pings.range_m)) == (1, 3, 4)
    assert pings.image.any()
    assert found["images_camera_top"].t_ns.tolist() == [500_000_000, 1_500_000_000]
    assert found["images_camera_top"].usable.tolist() == [True, False]
    assert not (out / "images_camera_top.bin").exists()


def test_cameras_hull_and_findings_lie_beside_them(package, tmp_path):
    out = run(package, tmp_path / "ingest")
    cameras = json.loads((out / "cameras.json").read_text())
    assert cameras["top"]["fx"] == 30.0
    assert "bottom" not in cameras
    hull = load_arrays(out / "hull.npz")
    assert hull["faces"].shape == (4, 3)
    assert hull["faces"].dtype == np.int32
    findings = json.loads((out / "findings.json").read_text())
    assert set(findings) == {"spans", "lost", "hull", "notes"}
    assert "camera_top: 1 of 2 images are missing or damaged and are left out" in findings["notes"]
    warnings = json.loads((out / "manifest.json").read_text())["warnings"]
    assert warnings == [*findings["lost"], *findings["notes"]]


def test_images_that_are_files_are_read_from_the_package(package, tmp_path):
    store = ImageStore(run(package, tmp_path / "ingest"), package, "camera_top")
    assert store.read(0).shape == (24, 32, 3)
    assert store.read(1) is None


def test_two_runs_give_the_same_bytes(package, tmp_path):
    first, second = run(package, tmp_path / "one"), run(package, tmp_path / "two")
    names = sorted(p.name for p in first.iterdir() if p.name != "manifest.json")
    assert [(first / name).read_bytes() for name in names] == [
        (second / name).read_bytes() for name in names
    ]


def test_without_a_cad_model_there_is_no_hull(package, tmp_path):
    text = (package / "dive.toml").read_text()
    (package / "dive.toml").write_text(text.split("[hull]")[0])
    assert not (run(package, tmp_path / "ingest") / "hull.npz").exists()


def key(package: Path, *overrides: str) -> str:
    loaded = load_config(package, {"ingest": STAGE.parameters}, overrides)
    return str(make_job(STAGE, loaded.sections, {}, package, HashCache()).recipe.key)


@pytest.mark.parametrize(
    "override",
    [
        "pressure.density=1000",
        "imu.frame=enu",
        "tray.joint=other",
        "camera.top.time_offset=0",
        "dvl.sigma_velocity=0.1",
        "dvl.beam_angle_deg=25",
        "dvl.beam_azimuth_deg=[0, 90, 180, 270]",
        "topics.dvl='/x'",
    ],
)
def test_an_option_that_ingest_reads_makes_it_stale(package, override):
    assert key(package, override) != key(package)


@pytest.mark.parametrize(
    "override",
    [
        "dvl.mount=[1,2,3,4,5,6]",
        "dvl.sigma_range=0.5",
        "camera.top.mount=[1,2,3,4,5,6]",
        "camera.top.sigma_px=3",
        "pressure.sigma_m=0.5",
        "tray.sigma_deg=3",
        "hull.pose=[1,2,3,4,5,6]",
        "imu.bias_sigma_deg=1",
        "sonar.elevation_deg=20",
    ],
)
def test_an_option_that_ingest_does_not_read_leaves_it_fresh(package, override):
    assert key(package, override) == key(package)


@pytest.mark.parametrize(
    "name", ["logs/dvl.csv", "logs/a.png", "top.yaml", "hull.off", "logs/p.npz"]
)
def test_a_changed_file_of_the_package_makes_it_stale(package, name):
    before = key(package)
    (package / name).write_bytes((package / name).read_bytes() + b"\n")
    assert key(package) != before


def test_an_image_outside_the_logs_folder_counts_as_read(package):
    (package / "far.png").write_bytes((package / "logs" / "a.png").read_bytes())
    (package / "logs" / "camera_top.csv").write_text("t,file\n0,far.png\n")
    before = key(package)
    (package / "far.png").write_bytes(b"changed")
    assert key(package) != before


def test_every_dotted_name_that_ingest_uses_exists(package):
    loaded = load_config(package)
    request = request_of(ingest_settings(loaded))
    assert request.joints == {"tray": "tray", "sonar_tray": "fan"}
    assert request.calibration == {"camera_top": "top.yaml"}
    assert request.added_ns["camera_top"] == 500_000_000


def test_a_failure_leaves_nothing_behind(package, tmp_path):
    (package / "hull.off").unlink()
    with pytest.raises(InputError, match=r"hull\.off is missing"):
        run(package, tmp_path / "ingest")
    assert not (tmp_path / "ingest").exists()


def test_a_relative_path_of_the_package_reads_the_same_files(package, tmp_path, monkeypatch):
    absolute = key(package)
    monkeypatch.chdir(package.parent)
    assert key(Path(package.name)) == absolute
    assert (run(Path(package.name), tmp_path / "ingest") / "images_camera_top.npz").exists()


def test_output_of_a_run_beside_logs_does_not_make_it_stale(package):
    before = key(package)
    (package / "logs" / "runs").mkdir()
    (package / "logs" / "runs" / "ortho.png").write_bytes(b"made by a run")
    assert key(package) == before


def test_a_fixed_tray_has_no_joint(package):
    loaded = load_config(package, {}, ["tray.joint=''"])
    assert request_of(ingest_settings(loaded)).joints == {"sonar_tray": "fan"}


def test_the_files_of_a_ros2_folder_are_its_own(package):
    folder = package / "bag"
    (folder / "runs").mkdir(parents=True)
    for name in ("metadata.yaml", "a.mcap", "notes.txt", "runs/b.mcap"):
        (folder / name).write_bytes(b"x")
    loaded = load_config(package, {}, ["logs.files=['bag']"])
    found = files_to_ingest(ingest_settings(loaded), package)
    assert [f.as_posix() for f in found[:2]] == ["bag/a.mcap", "bag/metadata.yaml"]
    assert len([f for f in found if f.parts[0] == "bag"]) == 2


def files_of(package: Path) -> list[Path]:
    loaded = load_config(package)
    return files_to_ingest(ingest_settings(loaded), package)


def test_write_ahead_log_is_an_input_of_ingest(tmp_path: Path) -> None:
    """Else a run would not notice that it came, went or changed."""
    (tmp_path / "bag").mkdir()
    for name in (
        "dive.db3",
        "dive.db3-wal",
        "bag/a.db3",
        "bag/a.db3-wal",
        "bag/metadata.yaml",
        "bag/notes.txt",
    ):
        (tmp_path / name).write_bytes(b"x")
    os.mkfifo(tmp_path / "bag" / "b.mcap")
    (tmp_path / "dive.toml").write_text('[dive]\nname = "x"\n[logs]\nfiles = ["dive.db3", "bag"]\n')
    names = ["dive.db3", "dive.db3-wal", "bag/a.db3", "bag/a.db3-wal", "bag/metadata.yaml"]
    assert [path.as_posix() for path in files_of(tmp_path)] == names


def test_pipe_as_log_is_refused_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "dive.mcap")
    (tmp_path / "dive.toml").write_text('[dive]\nname = "x"\n[logs]\nfiles = ["dive.mcap"]\n')
    with pytest.raises(InputError, match=r"dive\.mcap is a pipe"):
        files_of(tmp_path)


def test_mounts_left_out_are_taken_from_the_logs_frames(tmp_path):
    """Where a step declares the key alone, and where it declares its whole section."""
    folder = tmp_path / "ingest"
    folder.mkdir()
    inputs = InputArtifacts({"ingest": folder})
    settings = StageSettings(
        "x", {"dvl": Dvl(), "tray.origin": FROM_LOG, "pressure.origin": (1.0, 2.0, 3.0)}
    )
    assert inputs.mounted(settings).read("dvl", Dvl).mount == (0.0, 0.0, 0.0, 0.0, 90.0, 0.0)
    sensor = {
        "frame": "d",
        "pose": [0.5, 0, 0.2, 0, 80, 0],
        "on_servo": False,
        "servo_origin": [0.4, 0, 0.1],
    }
    (folder / "mounts.json").write_text(json.dumps({"dvl": sensor}))
    found = inputs.mounted(settings)
    assert found.read("dvl", Dvl).mount == pytest.approx((0.1, 0.0, 0.1, 0.0, 80.0, 0.0))
    assert (found["tray.origin"], found["pressure.origin"]) == ((0.4, 0.0, 0.1), (1.0, 2.0, 3.0))
    assert set(found) == set(settings)


def test_fixed_dvl_beside_camera_on_turning_servo_is_refused(tmp_path):
    folder = tmp_path / "ingest"
    folder.mkdir()
    fixed = {"frame": "d", "pose": [0.5, 0, 0.2, 0, 0, 0], "on_servo": False, "servo_origin": None}
    turning = {"frame": "c", "pose": [0.1, 0, 0, 90, 0, 90], "on_servo": True, "servo_origin": None}
    (folder / "mounts.json").write_text(json.dumps({"dvl": fixed, "camera_top": turning}))
    inputs, settings = (
        InputArtifacts({"ingest": folder}),
        StageSettings("x", {"dvl.mount": FROM_LOG, "tray.origin": FROM_LOG}),
    )
    assert inputs.mounted(settings)["dvl.mount"] == (0.5, 0.0, 0.2, 0.0, 0.0, 0.0)
    np.savez(folder / "tray.npz", t_ns=np.arange(3), angle=np.array([0.0, 0.1, 0.2]))
    with pytest.raises(InputError, match="one tray carries DVL and cameras"):
        inputs.mounted(settings)

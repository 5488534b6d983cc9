# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
import zipfile
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from navigation.instruments import RIG
from navigation.wall_dive import AlongWall, late, logs_along_wall
from scipy.spatial.transform import Rotation

from hullrecon.artifacts.runner import run_stage
from hullrecon.artifacts.stage import load_arrays, settings_for
from hullrecon.dive.config import schema
from hullrecon.errors import StageError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.navigation.clocks.comparisons.comparison import ClockedSensor
from hullrecon.navigation.sigmas import sigmas_from_settings
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PositionFixes,
    PressureSamples,
)
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.trajectory import (
    Attitude,
    Odometry,
    PositionTies,
    Returns,
    Trajectory,
    TrajectoryErrorModel,
)
from hullrecon.rig import rig_from_settings
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.steps.chain import stage

STAGE = stage("navigate")

SECOND = 10**9
JANUS = np.array(
    [[-0.5, 0, 0.75**0.5], [0.5, 0, 0.75**0.5], [0, 0.5, 0.75**0.5], [0, -0.5, 0.75**0.5]]
)


def sections() -> dict[str, object]:
    camera = schema.Cameras(
        top=schema.CameraTop(calibration="top.yaml"),
        bottom=schema.CameraBottom(calibration="bottom.yaml"),
    )
    return {
        "logs": schema.Logs(files=()),
        "tray": schema.Tray(origin=(0.4, 0.0, 0.1)),
        "imu": schema.Imu(),
        "pressure": schema.Pressure(),
        "dvl": schema.Dvl(mount_sigma=(0.01, 0.01, 0.01, 0.9, 0.9, 0.9)),
        "camera": camera,
        "sonar": None,
        "position": schema.Position(origin=(0.5, 0.0, 0.0)),
    }


@pytest.fixture
def ingest(tmp_path: Path) -> Path:
    """A dive straight ahead at 0.2 m/s, level, two metres down: the DVL looks forward at a wall
    that it nears.
    """
    folder = tmp_path / "ingest"
    folder.mkdir()
    t = np.arange(0, 20 * SECOND, SECOND // 5, dtype=np.int64)
    n = len(t)
    keep(
        folder,
        "dvl",
        DvlPings(
            t_ns=t,
            velocity=np.tile([0.0, 0, 0.2], (n, 1)),
            velocity_sigma=np.full(n, 0.003),
            ranges=np.full((n, 4), 1.5),
            beams=JANUS,
        ),
    )
    fast = np.arange(-SECOND, 21 * SECOND, SECOND // 25, dtype=np.int64)
    level = np.tile(Rotation.identity().as_quat(), (len(fast), 1))
    keep(
        folder,
        "imu",
        ImuSamples(
            t_ns=fast,
            quaternion=level,
            angular_velocity=np.zeros((len(fast), 3)),
            acceleration=np.zeros((len(fast), 3)),
        ),
    )
    keep(folder, "pressure", PressureSamples(t_ns=fast, depth=np.full(len(fast), 2.0)))
    return folder


def keep(folder: Path, name: str, record: object) -> None:
    # np.savez cannot hold a member called `file`
    with zipfile.ZipFile(folder / f"{name}.npz", "w") as file:
        for member, value in to_arrays(record).items():
            with file.open(f"{member}.npy", "w") as stream:
                np.save(stream, value)


def run(ingest: Path, out: Path) -> Path:
    return run_stage(STAGE, sections(), {"ingest": ingest}, out, source=ingest.parent)


def test_step_writes_records_and_source_of_path(ingest: Path, tmp_path: Path) -> None:
    out = run(ingest, tmp_path / "navigate")
    path = from_arrays(Trajectory, load_arrays(out / "trajectory.npz"))
    assert np.allclose(
        path.translation[-1] - path.translation[0],
        [0.2 * (path.t_ns[-1] - path.t_ns[0]) / SECOND, 0, 0],
        atol=1e-6,
    )
    assert np.allclose(path.translation[:, 2], 2.0)
    assert len(from_arrays(Odometry, load_arrays(out / "odometry.npz")).first) == len(path.t_ns) - 1
    assert len(from_arrays(Returns, load_arrays(out / "returns.npz")).t_ns) == 400
    assert np.allclose(from_arrays(Attitude, load_arrays(out / "attitude.npz")).depth, 2.0)
    report = json.loads((out / "navigation.json").read_text())
    assert report["source"] == "dvl"
    assert report["nodes"] == len(path.t_ns)
    assert report["path_length_m"] == pytest.approx(3.96, abs=0.05)
    assert any("tray" in sentence for sentence in report["remarks"])


def test_a_tray_of_zeros_alone_is_known_to_ten_degrees(ingest: Path, tmp_path: Path) -> None:
    t_ns = np.arange(0, 20 * SECOND, SECOND // 5, dtype=np.int64)
    keep(ingest, "tray", JointSamples(t_ns=t_ns, angle=np.zeros(len(t_ns))))
    out = run(ingest, tmp_path / "navigate")
    attitude = from_arrays(Attitude, load_arrays(out / "attitude.npz"))
    np.testing.assert_allclose(np.degrees(attitude.tray_sigma), 10.0)


def test_depths_that_step_are_put_on_one_level_that_is_less_known(
    ingest: Path, tmp_path: Path
) -> None:
    logged = from_arrays(PressureSamples, load_arrays(ingest / "pressure.npz"))
    noise = 0.02 * np.random.default_rng(1).standard_normal(len(logged.t_ns))
    stepped = logged.depth + noise + 0.5 * (logged.t_ns > 13 * SECOND)
    keep(ingest, "pressure", PressureSamples(t_ns=logged.t_ns, depth=stepped))
    out = run(ingest, tmp_path / "navigate")
    attitude = from_arrays(Attitude, load_arrays(out / "attitude.npz"))
    np.testing.assert_allclose(attitude.depth, 2.0, atol=0.05)
    remarks = json.loads((out / "navigation.json").read_text())["remarks"]
    assert any("the depth steps by +0.5" in remark for remark in remarks)
    (ingest / "cameras.json").write_text("{}")
    inputs = InputArtifacts({"ingest": ingest, "navigate": out})
    rig = inputs.rig(inputs.mounted(settings_for(stage("adjust"), sections())))
    sigma_m = np.hypot(schema.Pressure().bias_sigma_m, 0.5)
    assert rig.priors.navigation_sigma[4] == pytest.approx(sigma_m, abs=0.02)


def test_the_step_leaves_what_makes_its_poses_wrong(ingest: Path, tmp_path: Path) -> None:
    out = run(ingest, tmp_path / "navigate")
    path = from_arrays(Trajectory, load_arrays(out / "trajectory.npz"))
    errors = from_arrays(TrajectoryErrorModel, load_arrays(out / "error_model.npz"))
    assert errors.by_error.shape == (len(path.t_ns), 6, 12)
    # by the DVL's scale: the way it has come
    assert np.allclose(errors.by_error[:, 0, 0], path.translation[:, 0])
    assert errors.error_covariance[0, 0] == pytest.approx(schema.Dvl().scale_sigma ** 2)


def test_twice_the_same_input_gives_the_same_bytes(ingest: Path, tmp_path: Path) -> None:
    a, b = run(ingest, tmp_path / "a"), run(ingest, tmp_path / "b")
    for name in (
        "trajectory.npz",
        "error_model.npz",
        "odometry.npz",
        "returns.npz",
        "attitude.npz",
        "navigation.json",
    ):
        assert (a / name).read_bytes() == (b / name).read_bytes()


def test_a_dvl_whose_clock_is_late_is_put_right_and_said(ingest: Path, tmp_path: Path) -> None:
    logs = logs_along_wall(AlongWall(RIG, duration_s=60.0))
    for name, record in (
        ("dvl", late(logs, ClockedSensor.DVL, 0.8).dvl),
        ("imu", logs.imu),
        ("pressure", logs.pressure),
    ):
        keep(ingest, name, record)
    keep(ingest, "tray", logs.tray)
    mounted = {
        "tray": schema.Tray(origin=(0.45, 0.0, 0.1)),
        "pressure": schema.Pressure(origin=(-0.3, 0.1, 0.05)),
        "dvl": schema.Dvl(mount=(0.02, -0.01, 0.08, 0.5, 89.0, 1.0)),
    }
    out = run_stage(
        STAGE, sections() | mounted, {"ingest": ingest}, tmp_path / "navigate", source=tmp_path
    )
    report = json.loads((out / "navigation.json").read_text())
    (clock,) = report["clocks"]
    assert clock["sensor"] == "DVL"
    assert clock["seconds"] == pytest.approx(0.8, abs=4 * clock["sigma_s"])
    assert report["remarks"][0].startswith(f"DVL: the clock is {clock['seconds']:.2f} s late")
    path = from_arrays(Trajectory, load_arrays(out / "trajectory.npz"))
    assert path.t_ns[0] == pytest.approx(logs.dvl.t_ns[0], abs=0.1 * SECOND)


def test_a_dvl_without_an_imu_is_an_error_in_words(ingest: Path, tmp_path: Path) -> None:
    (ingest / "imu.npz").unlink()
    with pytest.raises(StageError, match="no IMU was logged"):
        run(ingest, tmp_path / "navigate")


def test_neither_dvl_nor_stereo_is_an_error_in_words(ingest: Path, tmp_path: Path) -> None:
    (ingest / "dvl.npz").rename(tmp_path / "dvl.npz")
    with pytest.raises(StageError, match="nothing measures how the vehicle moved"):
        run(ingest, tmp_path / "navigate")
    (tmp_path / "dvl.npz").rename(ingest / "dvl.npz")  # as a topic that is named
    assert (run(ingest, tmp_path / "with_dvl") / "trajectory.npz").exists()


def slide_over_seabed(ingest: Path, contrast: float = 1.0) -> None:
    """Add the images of a rig that slides 8 cm a frame over a flat seabed 1 m below, 4 mm a pixel,
    a frame a second.
    """
    import cv2

    noise = (
        127 + contrast * (np.random.default_rng(4).integers(0, 255, (100, 200)) - 127.0)
    ).astype(np.uint8)
    seabed = cv2.resize(noise, (800, 400), interpolation=cv2.INTER_CUBIC)
    camera = CameraModel(320, 256, 250.0, 250.0, 159.5, 127.5)
    (ingest / "cameras.json").write_text(
        json.dumps({"top": asdict(camera), "bottom": asdict(camera)})
    )
    count = 4
    # the lower camera is 0.1 m down the image
    for name, shift in (("camera_top", 0), ("camera_bottom", 25)):
        encoded = []
        for k in range(count):
            picture = seabed[50 + shift : 306 + shift, 20 + 20 * k : 340 + 20 * k]
            encoded.append(cv2.imencode(".png", picture)[1].tobytes())
        sizes = np.array([len(e) for e in encoded])
        (ingest / f"images_{name}.bin").write_bytes(b"".join(encoded))
        start = np.concatenate([[0], np.cumsum(sizes)[:-1]])
        index = ImageIndex(
            t_ns=SECOND * np.arange(count),
            file=np.full(count, ""),
            offset=start,
            size=sizes,
            usable=np.ones(count, bool),
        )
        keep(ingest, f"images_{name}", index)


def lose_velocities(ingest: Path, before_s: float) -> None:
    """Take the DVL's velocities before a time, and bring it as near to the wall as the images are
    to the seabed.
    """
    dvl = from_arrays(DvlPings, load_arrays(ingest / "dvl.npz"))
    dvl.ranges[:] = 1 / JANUS[0, 2]
    dvl.velocity[dvl.t_ns < before_s * SECOND] = np.nan
    keep(ingest, "dvl", dvl)


def source_and_steps(out: Path) -> tuple[str, np.ndarray]:
    path = from_arrays(Trajectory, load_arrays(out / "trajectory.npz"))
    source = json.loads((out / "navigation.json").read_text())["source"]
    return source, np.linalg.norm(np.diff(path.translation, axis=0), axis=1)


def test_path_is_reckoned_without_any_range(ingest: Path, tmp_path: Path) -> None:
    dvl = from_arrays(DvlPings, load_arrays(ingest / "dvl.npz"))
    dvl.ranges[:] = np.nan
    keep(ingest, "dvl", dvl)
    source, step = source_and_steps(run(ingest, tmp_path / "navigate"))
    assert source == "dvl"
    assert step.sum() > 1.0


def test_without_a_dvl_the_stereo_cameras_give_the_path(ingest: Path, tmp_path: Path) -> None:
    (ingest / "dvl.npz").unlink()
    slide_over_seabed(ingest)
    out = run(ingest, tmp_path / "navigate")
    source, step = source_and_steps(out)
    assert source == "stereo"
    assert np.allclose(step, 0.08, atol=2e-3)
    path = from_arrays(Trajectory, load_arrays(out / "trajectory.npz"))
    assert path.translation[0].tolist() == [0.0, 0.0, 2.0]


@pytest.mark.parametrize(
    ("before_s", "source"), [(0.0, "dvl"), (2.0, "dvl"), (3.6, "stereo"), (30.0, "stereo")]
)
def test_stereo_gives_the_path_where_dvl_was_hardly_heard(
    ingest: Path, tmp_path: Path, before_s: float, source: str
) -> None:
    slide_over_seabed(ingest)
    lose_velocities(ingest, before_s)
    out = run(ingest, tmp_path / "navigate")
    found, step = source_and_steps(out)
    assert found == source
    assert source == "dvl" or np.allclose(step, 0.08, atol=2e-3)
    images = from_arrays(Trajectory, load_arrays(out / "trajectory.npz")).image
    assert sorted(set(images[:, 0]) - {-1}) == [0, 1, 2, 3]
    (first, *others) = json.loads((out / "navigation.json").read_text())["remarks"]
    assert first.startswith("DVL and IMU were heard together for") == (source == "stereo")
    assert not any("no DVL" in remark for remark in (first, *others))


def test_dvl_gives_the_path_where_images_give_none(ingest: Path, tmp_path: Path) -> None:
    slide_over_seabed(ingest, contrast=0.0)
    lose_velocities(ingest, 3.6)
    out = run(ingest, tmp_path / "navigate")
    assert source_and_steps(out)[0] == "dvl"


def test_mounts_and_sigmas_reach_navigation_in_radians(tmp_path: Path) -> None:
    settings = InputArtifacts({"ingest": tmp_path}).mounted(settings_for(STAGE, sections()))
    rig, sigmas = rig_from_settings(settings), sigmas_from_settings(settings)
    assert rig.tray_origin.tolist() == [0.4, 0.0, 0.1]
    assert sigmas.mount[3] == pytest.approx(np.radians(0.9))
    assert sigmas.mount[0] == 0.01
    assert sigmas.heading_drift_rad_s == pytest.approx(np.radians(1.0) / 3600)
    assert np.allclose(rig.tray_from_dvl.apply([[0, 0, 1.0]]), [[1, 0, 0]])


def fixes(count: int) -> PositionFixes:
    """Of an antenna half a metre ahead of a vehicle that goes north-east at 0.2 m/s."""
    t = np.arange(1, count + 1, dtype=np.int64) * 3 * SECOND
    way = 0.2 * np.asarray(t / SECOND) / np.sqrt(2)
    at = np.column_stack([way, way])
    return PositionFixes(t_ns=t, north_east=at, exchanged=at, sigma=np.full(count, 0.05))


def test_positions_from_outside_are_left_at_the_nodes(ingest: Path, tmp_path: Path) -> None:
    keep(ingest, "position", fixes(6))
    run_stage(STAGE, sections(), {"ingest": ingest}, tmp_path / "out")
    ties = from_arrays(PositionTies, load_arrays(tmp_path / "out" / "positions.npz"))
    # within half a node's spacing of the vehicle's way
    np.testing.assert_allclose(ties.antenna[:, 0], 0.5, atol=0.05)
    facts = json.loads((tmp_path / "out" / "navigation.json").read_text())
    assert facts["positions"] == {"used": 6, "outside": 0, "refusal": None}


def test_a_lone_position_is_said_to_tell_nothing(ingest: Path, tmp_path: Path) -> None:
    keep(ingest, "position", fixes(1))
    run_stage(STAGE, sections(), {"ingest": ingest}, tmp_path / "out")
    assert not (tmp_path / "out" / "positions.npz").exists()
    facts = json.loads((tmp_path / "out" / "navigation.json").read_text())
    assert facts["positions"]["used"] == 0
    assert (
        "Positions from outside tell nothing of this dive: there is one alone"
        in facts["remarks"][-1]
    )

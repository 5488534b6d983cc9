# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The mosaic steps on a wall that a small dive passes: images and pings are drawn here, the files
are read back.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import rasterio
import tifffile
from numpy.typing import NDArray

from hullrecon.artifacts.runner import run_stage
from hullrecon.dive.config.schema import Cameras, CameraTop, Dive, DiveConfig, Logs, Sonar, Topics
from hullrecon.dive.logs.readers.sound_metrics import aris_frames
from hullrecon.errors import StageError
from hullrecon.geometry.charts.chart import chart_for_points
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import from_rpy, identity
from hullrecon.records.sensors import ImageIndex, JointSamples
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Trajectory, VehicleTrack
from hullrecon.rig import rig_from_settings
from hullrecon.steps import mosaics
from hullrecon.steps.chain import stage
from hullrecon.steps.sonar import sonar_poses

OPTICAL, SONAR = stage("mosaic-optical"), stage("mosaic-sonar")
NODES = 9
CAMERA = {"width": 160, "height": 120, "fx": 160.0, "fy": 160.0, "cx": 79.5, "cy": 59.5}
BAG = Logs(files=("dive.mcap",))
TIMES = np.arange(NODES) * 500_000_000


def save(folder: Path, name: str, arrays: dict[str, Any]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / name).open("wb") as file:
        stored = {key: np.asarray(value) for key, value in arrays.items() if key != "file"}
        np.savez(file, **stored)
    if "file" in arrays:  # numpy's savez has an argument of that name
        import io
        import zipfile

        buffer = io.BytesIO()
        np.lib.format.write_array(buffer, np.asarray(arrays["file"]))
        with zipfile.ZipFile(folder / name, "a") as archive:
            archive.writestr("file.npy", buffer.getvalue())


def wall() -> Surface:
    """The plane y = 1 of g, from x = -1 to 3 and z = 1 to 3, in squares of 10 cm."""
    x, z = np.meshgrid(np.linspace(-1, 3, 41), np.linspace(1, 3, 21))
    index = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        index[:-1, :-1].ravel(),
        index[:-1, 1:].ravel(),
        index[1:, :-1].ravel(),
        index[1:, 1:].ravel(),
    )
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32)
    vertices = np.column_stack([x.ravel(), np.ones(x.size), z.ravel()])
    return Surface(
        vertices=vertices,
        faces=faces,
        deviation=np.full(x.size, np.nan),
        sigma=np.full(x.size, 0.01),
        support=np.ones(x.size, np.int64),
    )


def spot_image(x_m: float) -> NDArray[np.uint8]:
    """What the camera at (x, 0, 2) sees of the wall: a bright disc of 15 cm about x = 1 on gray."""
    v, u = np.mgrid[0:120, 0:160]
    seen_x, seen_z = x_m + (u - 79.5) / 160, 2 + (v - 59.5) / 160
    gray = np.where(np.hypot(seen_x - 1, seen_z - 2) < 0.15, 220, 90)
    return np.repeat(gray[..., None], 3, axis=2).astype(np.uint8)


@pytest.fixture
def passed(tmp_path: Path) -> dict[str, Path]:
    """Artifacts of ingest, navigate and surface: the vehicle goes along x at 2 m depth, the wall 1
    m to starboard.
    """
    x = np.linspace(0, 2, NODES)
    trajectory = Trajectory(
        t_ns=TIMES,
        quaternion=np.tile([0.0, 0, 0, 1], (NODES, 1)),
        translation=np.column_stack([x, np.zeros(NODES), np.full(NODES, 2.0)]),
        covariance=np.tile(np.eye(6) * 1e-4, (NODES, 1, 1)),
        tray=np.zeros(NODES),
        image=np.column_stack([np.arange(NODES), np.full(NODES, -1)]),
    )
    save(tmp_path / "navigate", "trajectory.npz", to_arrays(trajectory))
    surface = wall()
    save(tmp_path / "surface", "surface.npz", to_arrays(surface))
    save(
        tmp_path / "surface",
        "chart.npz",
        dict(chart_for_points(surface.vertices, toward=[1.0, 0.0, 2.0]).to_arrays()),
    )
    ingest = tmp_path / "ingest"
    encoded = [cv2.imencode(".png", spot_image(v)[..., ::-1])[1].tobytes() for v in x]
    size = np.array([len(e) for e in encoded])
    index = ImageIndex(
        t_ns=TIMES,
        file=np.full(NODES, ""),
        offset=np.cumsum(size) - size,
        size=size,
        usable=np.arange(NODES) != 3,
    )
    save(ingest, "images_camera_top.npz", to_arrays(index))
    (ingest / "images_camera_top.bin").write_bytes(b"".join(encoded))
    (ingest / "cameras.json").write_text(json.dumps({"top": CAMERA}))
    return {"ingest": ingest, "navigate": tmp_path / "navigate", "surface": tmp_path / "surface"}


def settings(sonar: Sonar | None = None) -> dict[str, Any]:
    # T_s_c: the camera's z to starboard (y of the vehicle), its x ahead, its y down
    top = CameraTop(calibration="top.yaml", mount=(0.0, 0.0, 0.0, -90.0, 0.0, 0.0))
    config = DiveConfig(
        dive=Dive(name="wall"),
        logs=Logs(files=()),
        camera=Cameras(top=top),
        sonar=sonar,
        topics=Topics(sonar="/s"),
    )
    return {
        name: getattr(config, name)
        for name in ("dive", "logs", "topics", "tray", "camera", "sonar", "hull")
    }


def test_optical_mosaic_of_reckoned_dive_shows_disc_in_place(
    passed: dict[str, Path], tmp_path: Path
) -> None:
    out = run_stage(OPTICAL, settings(), passed, tmp_path / "out", source=tmp_path)
    document = json.loads((out / "mosaic.json").read_text())
    picture = tifffile.imread(out / "ortho.tif")
    assert {p.name for p in out.iterdir()} == {
        "ortho.tif",
        "variance.tif",
        "views.tif",
        "ortho.png",
        "mosaic.glb",
        "mosaic.json",
        "tiles",
        "manifest.json",
    }
    assert (out / "tiles" / "tileset.json").is_file()
    assert document["frame"] == "g"
    assert document["images"] == NODES - 1  # one was unusable
    bright = (picture[..., 0] > 1.4 * np.median(picture[..., 0][picture[..., 3] > 0])) & (
        picture[..., 3] > 0
    )
    assert bright.sum() * document["resolution_m"] ** 2 == pytest.approx(np.pi * 0.15**2, rel=0.05)
    rows, columns = np.nonzero(bright)
    with rasterio.open(out / "ortho.tif") as file:
        x, y = file.transform @ (columns.mean() + 0.5, rows.mean() + 0.5)
    along, girth = document["along_from_x"] * x, document["girth_from_y"] * y
    chart = chart_for_points(wall().vertices, toward=[1.0, 0.0, 2.0])
    point, _ = chart.from_chart(np.array([[along, girth]]))
    np.testing.assert_allclose(point[0], [1.0, 1.0, 2.0], atol=0.01)


def test_a_mosaic_run_twice_gives_the_same_bytes(passed: dict[str, Path], tmp_path: Path) -> None:
    one, two = (
        run_stage(OPTICAL, settings(), passed, tmp_path / n, source=tmp_path)
        for n in ("one", "two")
    )
    for name in (
        "ortho.tif",
        "variance.tif",
        "views.tif",
        "ortho.png",
        "mosaic.glb",
        "mosaic.json",
        "tiles/tileset.json",
        "tiles/0/0-0.glb",
    ):
        assert (one / name).read_bytes() == (two / name).read_bytes(), name


def test_a_fault_of_the_3d_tiles_costs_them_alone(
    passed: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def torn(*_: object) -> None:
        raise ZeroDivisionError("torn")

    monkeypatch.setattr(mosaics, "write_tileset", torn)
    out = run_stage(OPTICAL, settings(), passed, tmp_path / "out", source=tmp_path)
    assert (out / "mosaic.glb").is_file()
    assert not (out / "tiles" / "tileset.json").exists()
    warnings = json.loads((out / "manifest.json").read_text())["warnings"]
    assert "the 3D Tiles could not be written: ZeroDivisionError: torn" in warnings


@pytest.mark.parametrize(
    ("facts", "title"),
    [
        ({}, "images that saw the surface where landmarks measured it"),
        ({"as_found": "from the DVL's surface"}, "DVL returns within reach of the surface"),
    ],
)
def test_the_raster_of_the_support_says_what_it_counts(
    passed: dict[str, Path], facts: dict[str, str], title: str, tmp_path: Path
) -> None:
    save(tmp_path / "detect", "as_found.npz", to_arrays(wall()))
    (tmp_path / "detect" / "detect.json").write_text(json.dumps(facts))
    out = run_stage(
        OPTICAL,
        settings(),
        {**passed, "detect": tmp_path / "detect"},
        tmp_path / "out",
        source=tmp_path,
    )
    with tifffile.TiffFile(out / "support.tif") as file:
        assert title in file.pages[0].tags["ImageDescription"].value


def test_the_sonar_mosaic_needs_no_camera(passed: dict[str, Path], tmp_path: Path) -> None:
    bearing = np.radians(np.linspace(-40, 40, 33))
    ranges = np.linspace(0.5, 2.5, 101)
    slant = 1 / np.cos(bearing)
    image = np.where(ranges >= slant[:, None], 100, 0) + np.zeros((NODES, 1, 1))
    directions = np.stack([0 * bearing, np.sin(bearing), np.cos(bearing)], axis=1)
    save(
        passed["ingest"], "sonar.npz", {"t_ns": TIMES, "directions": directions, "range_m": ranges}
    )
    np.save(passed["ingest"] / "sonar_image.npy", image.astype(np.uint8))
    # z of the sonar to starboard, its fan along x: x of the sonar is up
    sonar = Sonar(mount=(0.0, 0.0, 0.0, -90.0, 90.0, 0.0), elevation_deg=20.0)
    loose = Sonar(mount=sonar.mount, elevation_deg=20.0, mount_sigma=(0.0, 0.0, 0.0, 2.0, 2.0, 2.0))
    blind = {**settings(sonar), "camera": Cameras()}
    out = run_stage(SONAR, blind, passed, tmp_path / "out")
    document = json.loads((out / "mosaic.json").read_text())
    assert document["poses"] == "dead reckoned"
    assert document["pings"] == NODES
    assert document["area_m2"] > 0.2
    # the mount is known to 1 cm and half a degree, the vehicle to 1 cm and 0.01 rad, the wall some
    # 1.07 m away
    assert document["position_sigma_of_mount_m"] == pytest.approx(
        np.hypot(0.01, 1.07 * np.radians(0.5)), abs=5e-4
    )
    assert document["position_sigma_m"] == pytest.approx(0.0200, abs=1e-3)
    assert "known to 20 mm (one sigma)" in document["caption"]
    out = run_stage(SONAR, {**blind, "sonar": loose}, passed, tmp_path / "loose")
    worse = json.loads((out / "mosaic.json").read_text())
    assert worse["position_sigma_of_mount_m"] == pytest.approx(
        np.hypot(0.01, 1.05 * np.radians(2.0)), abs=2e-3
    )


def test_sonar_that_misses_surface_is_refused_with_its_reach(
    passed: dict[str, Path], tmp_path: Path
) -> None:
    rays = np.array([[0.0, 0.1, 1.0], [0.0, -0.1, 1.0]]) / np.sqrt(1.01)
    save(
        passed["ingest"],
        "sonar.npz",
        {"t_ns": TIMES, "directions": rays, "range_m": np.linspace(0.1, 0.4, 4)},
    )
    np.save(passed["ingest"] / "sonar_image.npy", np.full((NODES, 2, 4), 9, np.uint8))
    # to port, away from the wall
    sonar = Sonar(mount=(0.0, 0.0, 0.0, 90.0, 90.0, 0.0), elevation_deg=20.0)
    with pytest.raises(StageError, match=r"no sonar mosaic.*pings to 0\.4 m"):
        run_stage(
            SONAR,
            {**settings(sonar), "camera": Cameras()},
            passed,
            tmp_path / "out",
        )


def test_steps_apply_only_where_their_sensor_was_carried(tmp_path: Path) -> None:
    carried = {
        "camera.top.time_offset": 0.0,
        "sonar.mount": Sonar().mount,
        "topics": Topics(sonar="/s"),
        "logs": BAG,
    }
    assert OPTICAL.applies(carried, tmp_path) is None
    assert SONAR.applies(carried, tmp_path) is None
    assert OPTICAL.applies({"camera.top.time_offset": None}, tmp_path) == "no camera was carried"
    assert (
        SONAR.applies({**carried, "sonar.mount": None}, tmp_path) == "no imaging sonar was carried"
    )


@pytest.mark.parametrize("topics", [Topics(), Topics(dvl="/dvl")])
def test_sonar_in_log_without_topics_gets_its_mosaic(topics: Topics, tmp_path: Path) -> None:
    for folder, table in (("tables", "sonar.csv"), ("others", "dvl.csv")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / table).touch()
    carried = {"sonar.mount": Sonar().mount, "topics": topics}
    for beside in ("s.aris", "s.OCULUS", "tables"):
        assert (
            SONAR.applies({**carried, "logs": Logs(files=("dive.mcap", beside))}, tmp_path) is None
        )
    for beside in ("absent", "dvl.pd0", "others"):
        logs = Logs(files=("dive.mcap", beside))
        assert SONAR.applies({**carried, "logs": logs}, tmp_path) == "no imaging sonar was carried"


def test_the_file_of_a_sonar_is_known_by_its_first_bytes(tmp_path: Path) -> None:
    (tmp_path / "pings.dat").write_bytes(aris_frames.MAGIC + bytes(8))
    carried = {
        "sonar.mount": Sonar().mount,
        "topics": Topics(dvl="/dvl"),
        "logs": Logs(files=("dive.mcap", "pings.dat")),
    }
    assert SONAR.applies(carried, tmp_path) is None


def _still_track(nodes: int) -> VehicleTrack:
    return VehicleTrack(
        t_ns=TIMES[:nodes],
        poses=identity(nodes),
        tray=np.zeros(nodes),
        covariance=np.zeros((nodes, 6, 6)),
        image=np.full((nodes, 2), -1),
        frame=Frame.GLOBAL,
    )


def test_the_sonars_servo_is_read_at_the_pings() -> None:
    angles = JointSamples(t_ns=TIMES, angle=np.linspace(0, 0.8, NODES))
    rig = rig_from_settings(
        {"sonar.origin": (0.4, 0.0, 0.2), "sonar.mount": (0.0, 0.0, 0.0, 0.0, 90.0, 0.0)}
    )
    at = np.array([TIMES[4], (TIMES[4] + TIMES[5]) // 2])
    poses = sonar_poses(rig, _still_track(NODES), at, "sonar_tray", angles)
    want = from_rpy(
        np.tile([0.4, 0, 0.2], (2, 1)), [[0, np.pi / 2 + 0.4, 0], [0, np.pi / 2 + 0.45, 0]]
    )
    np.testing.assert_allclose((poses.inverse() @ want).log(), 0, atol=1e-9)


def test_a_sonar_without_a_servo_stands_as_mounted() -> None:
    rig = rig_from_settings(
        {"sonar.origin": (0.4, 0.0, 0.2), "sonar.mount": (0.0, 0.0, 0.1, 0.0, 0.0, 0.0)}
    )
    poses = sonar_poses(rig, _still_track(NODES), TIMES[:2], None, None)
    np.testing.assert_allclose(poses.translation, np.tile([0.4, 0.0, 0.3], (2, 1)))


def test_a_servo_that_was_not_logged_is_named() -> None:
    rig = rig_from_settings({"sonar.origin": (0.0, 0.0, 0.0), "sonar.mount": (0.0,) * 6})
    with pytest.raises(StageError, match="sonar_tray is not in the log"):
        sonar_poses(rig, _still_track(1), TIMES[:1], "sonar_tray", None)

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from mcap.reader import make_reader

from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, tray_poses
from hullrecon.synthetic.dive import Dive, simulate_dive
from hullrecon.synthetic.options import with_options
from hullrecon.synthetic.recorder import START_NS
from hullrecon.synthetic.truth import write_ply, write_truth
from hullrecon.synthetic.vehicle import TRAY_ORIGIN


def load(package: Path, name: str) -> dict:
    return json.loads((package / "truth" / name).read_text())


def table(package: Path, name: str) -> np.ndarray:
    return np.loadtxt(package / "truth" / name, delimiter=",", skiprows=1)


def place(entry: dict) -> Poses:
    return Poses(np.array([entry["quaternion"]]), np.array([entry["translation"]]))


@pytest.fixture(scope="module")
def as_built(package: Path) -> Scene:
    import trimesh

    mesh = trimesh.load(package / "truth" / "as_built.ply", process=False)
    return Scene(Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces, np.int32)))


def test_poses_are_those_of_vehicle_in_hull_at_every_frame(package: Path, dive: Dive) -> None:
    rows = table(package, "poses.csv")
    at = dive.motion.in_hull(dive.motion.vehicle(dive.frame_s))
    np.testing.assert_allclose(rows[:, 1:4], at.translation, atol=1e-8)
    np.testing.assert_allclose(rows[:, 4:], at.quaternion, atol=1e-8)
    np.testing.assert_allclose(rows[:, 0] - START_NS * 1e-9, dive.frame_s, atol=1e-6)


def test_alignment_takes_hull_into_g(package: Path, dive: Dive) -> None:
    np.testing.assert_allclose(
        place(load(package, "alignment.json")["T_g_M"]).matrix(),
        dive.motion.global_from_hull.matrix(),
    )


def test_servo_is_true_one_with_its_play(package: Path, dive: Dive) -> None:
    rows = table(package, "servo.csv")
    np.testing.assert_allclose(
        rows[:, 1],
        np.interp(rows[:, 0] - START_NS * 1e-9, dive.motion.t_s, dive.motion.tray),
        atol=1e-6,
    )


def test_true_mounts_are_off_nominal_ones_by_millimetres(package: Path) -> None:
    from hullrecon.geometry.poses import from_mount
    from hullrecon.synthetic.vehicle import CAMERA_MOUNT

    off = (
        from_mount(CAMERA_MOUNT).inverse() @ place(load(package, "extrinsics.json")["T_s_ct"])
    ).log()[0]
    assert 1e-4 < np.linalg.norm(off[:3]) < 0.02
    assert 0.01 < np.degrees(np.linalg.norm(off[3:])) < 1.5


def test_objects_stand_on_surface_that_is_written(package: Path, as_built: Scene) -> None:
    found = load(package, "objects.json")["objects"]
    assert len(found) == 3
    for o in found:
        center, normal = np.array(o["center"]), np.array(o["normal"])
        way = as_built.cast((center + 0.4 * normal)[None], -normal[None])
        assert way[0] == pytest.approx(0.4, abs=1e-3)
        assert o["painted"] == (o["height"] == 0)
        assert o["views"] >= 1


@pytest.mark.parametrize("standoff_m", [2.4, 3.0])
def test_objects_are_seen_from_farther_off_too(
    dive: Dive, standoff_m: float, tmp_path: Path
) -> None:
    """In 3 images a leg, as `views` asks for, and in some of the other leg's."""
    write_truth(tmp_path, simulate_dive(with_options(dive.spec, standoff_m=standoff_m)))
    objects = json.loads((tmp_path / "objects.json").read_text())["objects"]
    assert min(o["views"] for o in objects) >= 3


def test_surface_covers_what_cameras_see(package: Path, as_built: Scene) -> None:
    poses, servo = table(package, "poses.csv"), table(package, "servo.csv")
    angle = np.interp(poses[:, 0], servo[:, 0], servo[:, 1])
    vehicle = Poses(poses[:, 4:8], poses[:, 1:4])
    camera = (
        vehicle @ tray_poses(TRAY_ORIGIN, angle) @ place(load(package, "extrinsics.json")["T_s_ct"])
    )
    for corner in ([-0.5, -0.4, 1], [0.5, 0.4, 1], [0, 0, 1]):
        way = as_built.cast(
            camera.translation, camera.rotation.apply(np.array(corner) / np.linalg.norm(corner))
        )
        assert np.isfinite(way).all()


def test_stereo_points_of_true_poses_lie_on_true_surface(
    package: Path, dive: Dive, as_built: Scene
) -> None:
    """Images, calibration, mounts, tray and poses agree, whatever simulated them."""
    poses, servo = table(package, "poses.csv"), table(package, "servo.csv")
    k = len(poses) // 2
    angle = np.interp(poses[k, 0], servo[:, 0], servo[:, 1])
    mounts = load(package, "extrinsics.json")
    vehicle = Poses(poses[k : k + 1, 4:8], poses[k : k + 1, 1:4])
    top = vehicle @ tray_poses(TRAY_ORIGIN, [angle]) @ place(mounts["T_s_ct"])
    bottom = top @ place(mounts["T_ct_cb"])
    first, second = (_features(_image(package, name, k)) for name in ("top", "bottom"))
    pairs = [
        m
        for m, n in cv2.BFMatcher().knnMatch(first[1], second[1], k=2)
        if m.distance < 0.75 * n.distance
    ]
    assert dive.rig.camera_bottom is not None
    a = top.rotation.apply(dive.rig.camera_top.rays([first[0][m.queryIdx].pt for m in pairs]))
    b = bottom.rotation.apply(
        dive.rig.camera_bottom.rays([second[0][m.trainIdx].pt for m in pairs])
    )
    points, gap = _meet(top.translation[0], a, bottom.translation[0], b)
    good = gap < 0.003
    assert good.sum() > 60
    assert np.median(np.abs(as_built.closest(points[good]).distance)) < 0.01


def _image(package: Path, camera: str, k: int) -> np.ndarray:
    with (package / "logs" / "dive.mcap").open("rb") as file:
        rows = [
            m.data
            for _, _, m in make_reader(file).iter_messages(
                topics=[f"/camera/{camera}/image_raw/compressed"]
            )
        ]
    return cv2.imdecode(
        np.frombuffer(rows[k][rows[k].index(b"\xff\xd8") :], np.uint8), cv2.IMREAD_GRAYSCALE
    )


def _features(image: np.ndarray) -> tuple:
    return cv2.SIFT_create().detectAndCompute(cv2.createCLAHE(3, (8, 8)).apply(image), None)


def _meet(
    p: np.ndarray, a: np.ndarray, q: np.ndarray, b: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Midpoints of the shortest lines between rays, and their lengths."""
    w, ab = p - q, (a * b).sum(1)
    s = (ab * (b @ w) - a @ w) / (1 - ab**2)
    u = (b @ w - ab * (a @ w)) / (1 - ab**2)
    first, second = p + s[:, None] * a, q + u[:, None] * b
    return 0.5 * (first + second), np.linalg.norm(first - second, axis=1)


def test_mesh_in_pieces_is_one_file(tmp_path: Path) -> None:
    import trimesh

    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    triangle = np.array([[0, 1, 2]], np.int32)
    write_ply(tmp_path / "mesh.ply", iter([Mesh(corners, triangle), Mesh(corners + 5, triangle)]))
    mesh = trimesh.load(tmp_path / "mesh.ply", process=False)
    np.testing.assert_array_equal(mesh.vertices, np.vstack([corners, corners + 5]))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [3, 4, 5]])
    assert [p.name for p in tmp_path.iterdir()] == ["mesh.ply"]

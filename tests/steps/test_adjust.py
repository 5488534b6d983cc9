# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The step on artifacts made from the simulated dive: what it reads, and what it leaves."""

import json
import zipfile
from dataclasses import asdict, replace

import numpy as np
import pycolmap
import pytest
from adjustment.simulated_dive import (
    CAMERA,
    GLOBAL_FROM_HULL,
    GUESS_SIGMA,
    MOUNT_SIGMA,
    PRESSURE_ORIGIN_M,
    TOP_FROM_BOTTOM,
    TRAY_ORIGIN_M,
    aligning,
    cad_hull,
    hull_chart,
    moved,
    simulate,
)
from scipy.spatial.transform import Rotation

from hullrecon.adjustment.options import AdjustOptions
from hullrecon.artifacts.runner import run_stage
from hullrecon.artifacts.stage import load_arrays
from hullrecon.dive.config import schema
from hullrecon.geometry.charts.chart import chart_from_arrays
from hullrecon.records.sensors import ImageIndex
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Attitude
from hullrecon.steps.adjust import _cad_model, guess_without_depth
from hullrecon.steps.chain import stage

STAGE = stage("adjust")

TO_DEGREES = np.r_[np.ones(3), np.full(3, 180 / np.pi)]


def six(pose):
    """A mount as dive.toml has it, of a matrix (4, 4) or a batch of one."""
    matrix = pose if isinstance(pose, np.ndarray) else pose.matrix()[0]
    return tuple(
        np.r_[
            matrix[:3, 3], Rotation.from_matrix(matrix[:3, :3]).as_euler("xyz", degrees=True)
        ].tolist()
    )


def sections(dive, **options):
    """dive.toml of the simulated dive."""
    m = dive.measured
    sigma = tuple((MOUNT_SIGMA * TO_DEGREES).tolist())
    top = (
        schema.CameraTop(calibration="top.yaml", mount=six(m.rig.tray_from_top), mount_sigma=sigma)
        if m.rig.tray_from_top
        else None
    )
    bottom = (
        schema.CameraBottom(calibration="bottom.yaml", pose_in_top=six(TOP_FROM_BOTTOM))
        if m.rig.top_from_bottom
        else None
    )
    hull = (
        schema.Hull(
            mesh="hull.stl",
            pose=six(m.cad_model.guess),
            pose_sigma=tuple((GUESS_SIGMA * TO_DEGREES).tolist()),
        )
        if m.cad_model
        else None
    )
    return {
        "tray": schema.Tray(origin=tuple(TRAY_ORIGIN_M.tolist())),
        "imu": schema.Imu(heading_drift_deg_per_hour=200.0),
        "pressure": schema.Pressure(origin=tuple(PRESSURE_ORIGIN_M.tolist())),
        "dvl": schema.Dvl(mount=six(m.rig.tray_from_dvl), mount_sigma=sigma, scale_sigma=0.01),
        "camera": schema.Cameras(top=top, bottom=bottom),
        "hull": hull,
        "adjust": AdjustOptions(**options),
    }


def keep(folder, name, record):
    folder.mkdir(exist_ok=True)
    # np.savez cannot hold a member called `file`
    with zipfile.ZipFile(folder / f"{name}.npz", "w") as file:
        for member, value in to_arrays(record).items():
            with file.open(f"{member}.npy", "w") as stream:
                np.save(stream, value)


def ingested(folder, m):
    """Calibrations, stamps of the images and the hull."""
    folder.mkdir()
    n = len(m.trajectory.t_ns)
    if m.rig.top is not None:
        cameras = {"top": asdict(CAMERA)} | (
            {"bottom": asdict(CAMERA)} if m.rig.bottom is not None else {}
        )
        (folder / "cameras.json").write_text(json.dumps(cameras))
        zero = np.zeros(n, np.int64)
        index = ImageIndex(
            t_ns=m.trajectory.t_ns,
            file=np.full(n, ""),
            offset=zero,
            size=zero,
            usable=np.ones(n, bool),
        )
        for name in cameras:
            keep(folder, f"images_camera_{name}", index)
    if m.cad_model is not None:
        np.savez(
            folder / "hull.npz", vertices=m.cad_model.mesh.vertices, faces=m.cad_model.mesh.faces
        )


def run(root, dive, **options):
    """The folder that the step leaves."""
    m, inputs = dive.measured, {name: root / name for name in ("ingest", "navigate")}
    ingested(inputs["ingest"], m)
    for name in ("trajectory", "odometry", "attitude", "returns"):
        if getattr(m, name) is not None:
            keep(inputs["navigate"], name, getattr(m, name))
    if m.tracks is not None:
        inputs["matches"] = root / "matches"
        keep(inputs["matches"], "tracks", m.tracks)
    return run_stage(STAGE, sections(dive, **options), inputs, root / "adjust")


def solution_in(folder):
    return from_arrays(Solution, load_arrays(folder / "solution.npz"))


# without a CAD model, of which the pose takes most of the time
SHORT = {"per_leg": 8, "landmarks": 150, "cad": False}


@pytest.fixture(scope="module")
def stereo(tmp_path_factory):
    """The dive, and what the step left of it."""
    dive = simulate()
    return dive, run(tmp_path_factory.mktemp("stereo"), dive)


def test_the_solution_is_the_dive_to_millimetres(stereo):
    dive, out = stereo
    found = solution_in(out)
    truth = dive.global_from_vehicle[:, :3, 3]
    error = np.linalg.norm(
        moved(
            aligning(found.global_from_vehicle.translation, truth),
            found.global_from_vehicle.translation,
        )
        - truth,
        axis=1,
    )
    assert np.sqrt(np.mean(error**2)) < 2e-3
    assert np.median(found.landmarks.label) == 1


def test_the_files_are_those_that_later_steps_read(stereo):
    _, out = stereo
    names = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    colmap = {f"colmap/{name}.bin" for name in ("cameras", "rigs", "frames", "images", "points3D")}
    assert {
        "solution.npz",
        "iterations.npz",
        "adjust.json",
        "chart.npz",
        "manifest.json",
    } | colmap <= names
    assert "cameras.json" not in names


def test_the_summary_agrees_with_the_solution(stereo):
    _, out = stereo
    summary, found = json.loads((out / "adjust.json").read_text()), solution_in(out)
    assert summary["converged"] is True
    assert summary["landmarks"] == len(found.landmarks)
    assert sorted(summary["navigation"].values()) == sorted(found.navigation_errors.tolist())
    assert summary["navigation"]["dvl_scale"] == found.navigation_errors[0]
    assert np.array_equal(
        summary["mounts"]["T_g_M"],
        np.r_[found_hull(found)[:3, 3], found.hull_pose.global_from_hull.quaternion[0]],
    )


def test_warnings_and_times_are_in_manifest_not_in_result(stereo):
    _, out = stereo
    manifest = json.loads((out / "manifest.json").read_text())
    assert "along the hull" in json.dumps(manifest)
    assert "seconds" not in load_arrays(out / "iterations.npz")


def test_without_a_depth_the_hulls_height_is_uncertain_by_the_keels():
    hull = schema.Hull(mesh="hull.stl", pose=(0, 0, 6, 180, 0, 0))
    cad_model, known = (_cad_model(cad_hull(), hull, has_depth=has) for has in (False, True))
    keel_m = 6.0 - float(cad_hull().vertices[:, 2].min())
    assert cad_model.guess_sigma[2] == pytest.approx(np.hypot(0.3, keel_m / np.sqrt(3)))
    np.testing.assert_array_equal(
        np.delete(cad_model.guess_sigma, 2), np.delete(known.guess_sigma, 2)
    )


def test_a_guess_of_the_hulls_pose_without_a_depth_is_spoken_of():
    sigma = np.full((3, 3), 1e3)
    attitude = Attitude(
        node=np.arange(3), depth=np.zeros(3), roll=np.zeros(3), pitch=np.zeros(3), sigma=sigma,
        nodes_per_reading=np.zeros(3), tray_direction=np.ones(3), tray_sigma=np.zeros(3),
    )  # fmt: skip
    measured = replace(
        attitude,
        nodes_per_reading=np.array([25.0, 0, 0]),
        sigma=np.vstack([[2.0, 0.002, 0.002], sigma[1:]]),
    )
    cad_model = _cad_model(cad_hull(), schema.Hull(mesh="hull.stl"))
    assert (
        "hull.pose tells the height of the hull to 0.3 m"
        in guess_without_depth(cad_model, attitude)[0]
    )
    assert guess_without_depth(cad_model, measured) == guess_without_depth(None, attitude) == []


def test_the_chart_is_the_hulls(stereo):
    _, out = stereo
    at = cad_hull().vertices[5000:5200]
    np.testing.assert_allclose(
        chart_from_arrays(load_arrays(out / "chart.npz")).to_chart(at), hull_chart().to_chart(at)
    )


def test_the_chart_has_the_bow_and_the_stations_of_dive_toml():
    mesh, turned = cad_hull(), schema.Hull(mesh="h.stl", bow="-x", aft_perpendicular=50.0)
    chart, plain = _cad_model(mesh, turned).chart, hull_chart()
    at = mesh.vertices[5000:5200]
    found, along = chart.to_chart(at), plain.to_chart(at)[:, 0]
    known = np.isfinite(found[:, 0]) & np.isfinite(along)
    assert known.any()
    np.testing.assert_allclose(found[known, 0], 50.0 - along[known], atol=1e-6)


def test_the_height_of_a_model_with_y_up_is_known_best():
    mesh = cad_hull()
    turned = replace(mesh, vertices=mesh.vertices @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]).T)
    found = _cad_model(turned, schema.Hull(mesh="hull.stl", pose=(0, 0, 0, -90, 0, 0)))
    forward, port, up = np.abs(found.chart.ship_axes)
    shift, turn = found.guess_sigma[:3], np.degrees(found.guess_sigma[3:])
    assert [float(axis @ shift) for axis in (forward, port, up)] == pytest.approx([1, 1, 0.3])
    assert [float(axis @ turn) for axis in (forward, port, up)] == pytest.approx([1, 1, 5])


def test_pycolmap_reads_images_and_points_in_hull_frame(stereo):
    dive, out = stereo
    found, model = solution_in(out), pycolmap.Reconstruction(str(out / "colmap"))
    n = len(dive.tray)
    assert len(model.images) == 2 * n
    assert len(model.points3D) == len(found.landmarks)
    assert model.compute_mean_reprojection_error() < 0.6  # px; the noise is 0.3 in each coordinate
    hull_from_global = np.linalg.inv(found_hull(found))
    expected = moved(hull_from_global, found.landmarks.position)
    points = np.array([model.points3D[k].xyz for k in sorted(model.points3D)])
    np.testing.assert_allclose(points, expected, atol=1e-9)
    stamps = {int(image.name.split("/")[1].removesuffix(".jpg")) for image in model.images.values()}
    assert stamps == set(dive.measured.trajectory.t_ns.tolist())


def found_hull(solution):
    return solution.hull_pose.global_from_hull.matrix()[0]


def test_two_runs_leave_the_same_bytes(stereo, tmp_path):
    dive, out = stereo
    again = run(tmp_path, dive)
    for path in sorted(p for p in out.rglob("*") if p.is_file() and p.name != "manifest.json"):
        assert (again / path.relative_to(out)).read_bytes() == path.read_bytes(), path.name


def test_without_cad_model_no_chart_and_points_in_g(tmp_path):
    out = run(tmp_path, simulate(**SHORT))
    assert not (out / "chart.npz").exists()
    found, model = solution_in(out), pycolmap.Reconstruction(str(out / "colmap"))
    assert found.hull_pose is None
    points = np.array([model.points3D[k].xyz for k in sorted(model.points3D)])
    np.testing.assert_allclose(points, found.landmarks.position, atol=1e-9)


def test_without_cameras_there_is_no_model(tmp_path):
    out = run(tmp_path, simulate(camera=False, per_leg=8))
    assert not (out / "colmap").exists()
    assert len(solution_in(out).landmarks) == 0
    assert solution_in(out).hull_pose is not None


def test_a_single_camera_makes_a_model_of_one(tmp_path):
    dive = simulate(stereo=False, **SHORT)
    model = pycolmap.Reconstruction(str(run(tmp_path, dive) / "colmap"))
    assert len(model.cameras) == 1
    assert len(model.images) == len(dive.tray)


def test_refined_intrinsics_are_written_for_later_steps(tmp_path):
    out = run(tmp_path, simulate(**SHORT), refine_intrinsics=True)
    cameras = json.loads((out / "cameras.json").read_text())
    assert set(cameras) == {"top", "bottom"}
    assert cameras["top"]["fx"] == pytest.approx(CAMERA.fx, rel=0.01)
    assert cameras["top"]["fx"] != CAMERA.fx
    assert "intrinsics" in json.loads((out / "adjust.json").read_text())


def test_hull_pose_is_found_from_a_guess_centimetres_off(stereo):
    dive, out = stereo
    found = solution_in(out)
    guess = dive.measured.cad_model.guess.matrix()[0]
    middle = found.hull_pose.survey_center

    def off(pose):
        return np.abs(
            (GLOBAL_FROM_HULL[:3, :3].T @ (moved(pose, middle) - moved(GLOBAL_FROM_HULL, middle)))[
                1
            ]
        )

    assert off(found_hull(found)) < 0.03 < off(guess)

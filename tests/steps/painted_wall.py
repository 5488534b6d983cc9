# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two legs of five nodes along a flat painted wall with truth; what navigation and the features of
the images left.
"""

import dataclasses
import json
from types import SimpleNamespace

import cv2
import numpy as np

from hullrecon.artifacts.runner import run_stage
from hullrecon.dive.config.schema import CameraBottom, Cameras, CameraTop, Dvl, Imu, Pressure, Tray
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import exp, from_mount
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.trajectory import Attitude, Odometry, Trajectory, TrajectoryErrorModel
from hullrecon.steps.chain import stage
from hullrecon.vision.features.extraction import extract
from hullrecon.vision.features.store import GrowingArray
from hullrecon.vision.options import FeatureOptions, LinkOptions, MatchOptions

LINKS = stage("links")
MATCHES = stage("matches")

CAMERA = CameraModel(320, 256, 330.0, 330.0, 160.0, 128.0)
BELOW = (0.0, 0.1, 0.0, 0.0, 0.0, 0.0)
WALL_M, PIXELS_PER_M = 1.3, 400.0  # a flat painted wall ahead of the camera


STEP_SIGMA = np.r_[np.full(3, 0.005), np.full(3, 0.002)]  # m, rad of odometry a step


def build_dive(folder, along=0.12, per_leg=5, apart=0.35, find=extract):
    """The features of all images and the navigation, off by 3 mm."""
    x = along * np.arange(per_leg)
    place = np.concatenate([np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + apart])])
    global_from_top = exp(np.column_stack([place, np.zeros((2 * per_leg, 4))]))
    paint = cv2.GaussianBlur(
        np.random.default_rng(0).integers(0, 255, (1000, 1200)).astype(np.uint8), (0, 0), 2.0
    )
    paint = cv2.normalize(paint, None, 0, 255, cv2.NORM_MINMAX)
    write_features(folder / "features", global_from_top, paint, find)
    (folder / "ingest").mkdir()
    (folder / "ingest" / "cameras.json").write_text(
        json.dumps({k: dataclasses.asdict(CAMERA) for k in ("top", "bottom")})
    )
    write_navigation(folder / "navigate", global_from_top)
    return SimpleNamespace(folder=folder, global_from_top=global_from_top)


def write_features(folder, global_from_top, paint, find=extract):
    folder.mkdir()
    options, index = FeatureOptions(reduction=1.0, max_features=600), {}
    for camera, offset in zip(
        ("camera_top", "camera_bottom"), (from_mount((0,) * 6), from_mount(BELOW)), strict=True
    ):
        found = [
            find(see(pose.matrix()[0], paint), options)
            for pose in ((global_from_top @ offset)[k] for k in range(len(global_from_top)))
        ]
        index[f"{camera}_start"] = np.concatenate([[0], np.cumsum([len(f) for f in found])])
        index[f"{camera}_saliency"] = np.ones(len(global_from_top))
        for kind, width, dtype in (
            ("keypoints", 4, np.float32),
            ("descriptors", 128, np.uint8),
            ("color", 3, np.uint8),
        ):
            with GrowingArray(folder / f"{kind}_{camera}.npy", width, dtype) as file:
                for features in found:
                    file.append(getattr(features, kind))
    np.savez(folder / "index.npz", **index)


def see(global_from_camera, paint):
    """The wall z = 1.3 m as that camera sees it; the paint's pixel (500, 500) is at x = y = 0."""
    wall_from_paint = np.array([[1, 0, -500], [0, 1, -500], [0, 0, PIXELS_PER_M]]) / PIXELS_PER_M
    x, y, z, origin = np.linalg.inv(global_from_camera)[:3].T
    plane = np.column_stack([x, y, z * WALL_M + origin])
    return cv2.warpPerspective(
        paint, CAMERA.matrix() @ plane @ wall_from_paint, (CAMERA.width, CAMERA.height)
    )


def write_navigation(folder, global_from_top, image=None, sigma_m=0.01):
    """The camera sits in the vehicle's origin and looks along its z (mount and tray are the
    identity). The path may be another one than the images' (drift); odometry and attitude are those
    of the path that is written.
    """
    folder.mkdir()
    n = len(global_from_top)
    covariance = (
        np.tile(np.diag([sigma_m**2] * 3 + [1e-5] * 3), (n, 1, 1))
        * (1 + np.arange(n))[:, None, None]
    )
    off = 0.003 * np.random.default_rng(2).standard_normal((n, 3))
    rows = np.column_stack([np.arange(n)] * 2) if image is None else image
    record = Trajectory(
        t_ns=np.arange(n) * 10**9,
        quaternion=global_from_top.quaternion,
        translation=global_from_top.translation + off,
        covariance=covariance,
        tray=np.zeros(n),
        image=rows,
    )
    errors = TrajectoryErrorModel(
        by_error=np.zeros((n, 6, 0)),
        error_covariance=np.zeros((0, 0)),
        walk=covariance,
        white=np.zeros((n, 6, 6)),
    )
    kept = {
        "trajectory": record,
        "error_model": errors,
        "odometry": steps_of(record, sigma_m),
        "attitude": level(record),
    }
    for name, kept_record in kept.items():
        np.savez(folder / f"{name}.npz", **to_arrays(kept_record))


def steps_of(record, sigma_m):
    """The path's own steps, each known to sigma_m; the drift of the heading turns them, one second
    a step.
    """
    at, m = record.poses(), len(record.t_ns) - 1
    step = at[np.arange(m)].inverse() @ at[np.arange(1, m + 1)]
    by_navigation = np.zeros((m, 6, 2))
    by_navigation[:, :3, 0], by_navigation[:, 5, 1] = step.translation, 1.0
    by_navigation[:, :3, 1] = 0.5 * np.cross([0, 0, 1.0], step.translation)
    return Odometry(
        first=np.arange(m),
        second=np.arange(1, m + 1),
        quaternion=step.quaternion,
        translation=step.translation,
        covariance=np.tile(np.diag([sigma_m**2] * 3 + [1e-5] * 3), (m, 1, 1)),
        by_navigation=by_navigation,
        by_mount=np.zeros((m, 6, 3)),
        by_tray=np.zeros((m, 6)),
        from_images=np.zeros(m, bool),
    )


def level(record):
    """Depth (z of g, to 5 mm), roll and pitch (none, to 2 mrad) of every node."""
    n = len(record.t_ns)
    sigma = np.tile([0.005, 0.002, 0.002], (n, 1))
    depth = record.translation[:, 2]
    return Attitude(
        node=np.arange(n),
        depth=depth,
        roll=np.zeros(n),
        pitch=np.zeros(n),
        sigma=sigma,
        nodes_per_reading=np.ones(n),
        tray_direction=np.ones(n),
        tray_sigma=np.zeros(n),
    )


def with_navigation(dive, folder, global_from_top, image=None, sigma_m=0.01):
    """The same images with another navigation."""
    for name in ("ingest", "features"):
        (folder / name).symlink_to(dive.folder / name)
    write_navigation(folder / "navigate", global_from_top, image, sigma_m)
    return SimpleNamespace(folder=folder, global_from_top=dive.global_from_top)


def sections(stereo=True, links=LinkOptions(), **options):  # noqa: B008
    """What dive.toml says; options are those of [matches]."""
    top, bottom = (
        CameraTop(calibration="t", mount=(0,) * 6),
        CameraBottom(calibration="b", pose_in_top=BELOW),
    )
    return {
        "camera": Cameras(top=top, bottom=bottom if stereo else None),
        "tray": Tray(),
        "imu": Imu(heading_drift_deg_per_hour=3600.0),
        "dvl": Dvl(),
        "pressure": Pressure(),
        "sonar": None,
        "links": links,
        "matches": MatchOptions(**options),
    }


def run_links(dive, out, jobs=1, links_of=LINKS.run, **options):
    """Run the step links of a dive into out/links; links_of: the function that the step runs."""
    inputs = {name: dive.folder / name for name in ("ingest", "navigate", "features")}
    stage = dataclasses.replace(LINKS, run=links_of)
    run_stage(stage, sections(**options), inputs, out / "links", jobs=jobs)


def run_matches(dive, out, **options):
    """Run the step matches after it into out/matches."""
    inputs = {name: dive.folder / name for name in ("ingest", "navigate", "features")} | {
        "links": out / "links"
    }
    run_stage(MATCHES, sections(**options), inputs, out / "matches")

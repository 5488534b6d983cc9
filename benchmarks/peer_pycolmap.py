# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""pycolmap's bundle adjustment on a bundle. A pair is a rig of two cameras whose baseline and
intrinsics are held.

COLMAP itself would solve more than 1,000 images with ITERATIVE_SCHUR; SPARSE_SCHUR is several times
faster here, so that is what it is measured by (`--default` as the last argument leaves the choice
to COLMAP).
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pycolmap

from benchmarks import bundle as bundles
from benchmarks.bundle import Array, Bundle


def _rigid(seven: Array) -> Any:
    return pycolmap.Rigid3d(pycolmap.Rotation3d(seven[3:]), seven[:3])


def reconstruction_of(bundle: Bundle) -> Any:
    """Build the reconstruction of a bundle.

    Ids of frames and images are pose + 1. The bottom images come after all top images.
    """
    cameras = 2 if bundle.stereo else 1
    model = pycolmap.Reconstruction()
    rig = pycolmap.Rig(rig_id=1)
    for number in range(1, cameras + 1):
        camera = pycolmap.Camera(camera_id=number, width=1, height=1, **_model(bundle.camera))
        model.add_camera(camera)
        if number == 1:
            rig.add_ref_sensor(camera.sensor_id)
        else:
            rig.add_sensor(camera.sensor_id, _rigid(bundle.top_from_bottom).inverse())
    model.add_rig(rig)
    _add_frames(model, bundle, cameras)
    _add_points(model, bundle, cameras)
    return model


def _model(camera: Array) -> dict[str, Any]:
    if not camera[4:].any():
        return {"model": "PINHOLE", "params": camera[:4]}
    return {"model": "FULL_OPENCV", "params": np.r_[camera, np.zeros(3)]}


def _add_frames(model: Any, bundle: Bundle, cameras: int) -> None:
    order = np.argsort(bundle.seen_from, kind="stable")
    bounds = np.searchsorted(bundle.seen_from[order], np.arange(len(bundle.pose) + 1))
    for pose in range(len(bundle.pose)):
        frame = pycolmap.Frame(
            frame_id=pose + 1, rig_id=1, rig_from_world=_rigid(bundle.pose[pose]).inverse()
        )
        images = []
        for camera in range(cameras):
            number = pose + 1 + camera * len(bundle.pose)
            pixels = bundle.pixel[
                order[bounds[pose] : bounds[pose + 1]], 2 * camera : 2 * camera + 2
            ]
            images.append(
                pycolmap.Image(
                    name=f"{number}", keypoints=pixels, camera_id=camera + 1, image_id=number
                )
            )
            images[-1].frame_id = pose + 1
            frame.add_data_id(images[-1].data_id)
        model.add_frame(frame)
        for image in images:
            model.add_image(image)
        model.register_frame(pose + 1)


def _add_points(model: Any, bundle: Bundle, cameras: int) -> None:
    """Add the points in order, with their tracks.

    The number of a pixel in its image follows from a stable sort by image.
    """
    order = np.argsort(bundle.seen_from, kind="stable")
    place = np.empty(len(order), int)
    starts = np.searchsorted(bundle.seen_from[order], np.arange(len(bundle.pose)))
    place[order] = np.arange(len(order)) - starts[bundle.seen_from[order]]
    rows = np.split(
        np.argsort(bundle.seen, kind="stable"), np.cumsum(np.bincount(bundle.seen))[:-1]
    )
    for point, mine in zip(bundle.point, rows, strict=True):
        track = pycolmap.Track()
        for row in mine:
            for camera in range(cameras):
                track.add_element(
                    int(bundle.seen_from[row]) + 1 + camera * len(bundle.pose), int(place[row])
                )
        model.add_point3D(point, track)


def _options(threads: int, iterations: int, tolerance: float, choose: bool) -> Any:
    options = pycolmap.BundleAdjustmentOptions()
    options.refine_focal_length = options.refine_extra_params = options.refine_sensor_from_rig = (
        False
    )
    options.print_summary = False
    options.ceres.auto_select_solver_type = choose
    options.ceres.min_num_residuals_for_cpu_multi_threading = 0
    solver = options.ceres.solver_options
    solver.linear_solver_type = type(solver.linear_solver_type).SPARSE_SCHUR
    solver.num_threads, solver.max_num_iterations = threads, iterations
    solver.function_tolerance, solver.gradient_tolerance, solver.parameter_tolerance = (
        tolerance,
        1e-10,
        1e-8,
    )
    options.ceres.solver_options = solver
    return options


def main(
    path: Path, threads: int, iterations: int, tolerance: float, out: Path, choose: bool
) -> None:
    bundles.keep_to(threads)
    bundle = bundles.load(path)
    model = reconstruction_of(bundle)
    built = bundles.peak_mb()
    config = pycolmap.BundleAdjustmentConfig()
    for image in model.images:
        config.add_image(image)
    for camera in model.cameras:
        config.set_constant_cam_intrinsics(camera)
    if bundle.stereo:
        config.set_constant_rig_from_world_pose(1)
    else:
        config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    adjuster = pycolmap.create_default_ceres_bundle_adjuster(
        _options(threads, iterations, tolerance, choose), config, model
    )
    before = time.process_time()
    summary = adjuster.solve().ceres_summary
    cpu, peak = time.process_time() - before, bundles.peak_mb()
    # Ceres counts the start as a step
    count = summary.num_successful_steps + summary.num_unsuccessful_steps - 1
    back = [model.frame(k + 1).rig_from_world.inverse() for k in range(len(bundle.pose))]
    pose = np.array([np.r_[t.translation, t.rotation.quat] for t in back])
    point = np.array([model.points3D[k].xyz for k in sorted(model.points3D)])
    bundles.answer(
        out,
        iterations=count,
        solve_s=summary.total_time_in_seconds,
        iteration_s=(summary.total_time_in_seconds - summary.preprocessor_time_in_seconds)
        / max(1, count),
        cpu_s=cpu,
        peak_rss_mb=peak,
        peak_before_solve_mb=built,
        rms_px=bundles.rms_px(bundle, pose, point),
        linear_solver=str(summary.linear_solver_type_used).rsplit(".", maxsplit=1)[-1],
        message=str(summary.message),
    )


if __name__ == "__main__":
    main(
        Path(sys.argv[1]),
        int(sys.argv[2]),
        int(sys.argv[3]),
        float(sys.argv[4]),
        Path(sys.argv[-1]),
        "--default" in sys.argv,
    )

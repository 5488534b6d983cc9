# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of one solve, as [Ozog2016 Figs 4.10, 4.11] compares them.

They show whether a method flattens structures, whether it leaves landmarks off the surface that the
DVL measured, and how that changes trajectory and cameras.
"""

from __future__ import annotations

import numpy as np

from hullrecon.evaluation.deliverables import PointCloud, TimedPoses
from hullrecon.evaluation.surfaces import score_landmarks
from hullrecon.evaluation.trajectory import Figures, centre_figures, score_trajectory
from hullrecon.evaluation.truth import TrueStructure, Truth
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, VehiclePath
from hullrecon.rig import Rig
from hullrecon.studies.methods.sections import adjusted_beams
from hullrecon.typing import Array, Mask

MethodFigures = dict[str, Figures]
METHODS = ("naive", "geva", "maxmix")
NEIGHBOURS, REACH_M = 12, 0.4  # returns around a landmark, half of them within reach of it
WEIGHTINGS = {"as published": True, "as weighted by us": False}  # name -> adjust.as_published
TABLE = {
    "trajectory.normal_rmse_m": "off the hull",
    "trajectory.rigid_rmse_m": "path, rigid",
    "cameras.similarity_rmse_m": "cameras",
    "cameras.scale_error_percent": "scale",
    "landmarks.aligned_median_m": "landmarks",
    "landmarks.off_recall": "label 0 found",
    "heights.ratio_median": "height kept",
    "heights.ratio_worst": "worst",
    "gap.median_m": "to DVL",
}


def method_figures(
    solution: Solution, returns: Returns | None, rig: Rig, truth: Truth
) -> MethodFigures:
    """Score one solution by part and name, without parts that it cannot give."""
    global_from_hull = hull_frame(solution, truth)
    hull_poses = global_from_hull.inverse() @ solution.global_from_vehicle
    sigma = np.sqrt(np.einsum("nii->ni", solution.pose_covariance)[:, :3])
    trajectory, motion = score_trajectory(
        TimedPoses(t_s=stamps(solution), poses=hull_poses, sigma=sigma), truth
    )
    figures: MethodFigures = {"trajectory": trajectory}
    if len(solution.landmarks) == 0:
        return figures
    landmarks = landmarks_in_hull(solution, global_from_hull)
    if solution.mounts.tray_from_top is not None:
        figures["cameras"] = _score_cameras(solution, hull_poses, rig, truth)
    figures["landmarks"] = score_landmarks(
        PointCloud(points=landmarks, fields={"label": solution.landmarks.label}), truth, motion
    )
    figures["heights"] = height_figures(landmarks, truth, motion)
    if returns is not None and truth.cad_model is not None:
        dvl = adjusted_beams(solution, global_from_hull, returns, rig).points
        figures["gap"] = gap_figures(
            landmarks[_on_steel(landmarks, truth, motion)], dvl, truth.cad_model
        )
    return figures


def hull_frame(solution: Solution, truth: Truth) -> Poses:
    """Choose global_from_hull of the solution, or the true pose without a CAD model."""
    return (
        truth.global_from_hull
        if solution.hull_pose is None
        else solution.hull_pose.global_from_hull
    )


def stamps(solution: Solution) -> Array:
    """Convert the stamps of the nodes to seconds (n,)."""
    return np.asarray(solution.t_ns * 1e-9, float)


def landmarks_in_hull(solution: Solution, global_from_hull: Poses) -> Array:
    """Transform the landmarks (L, 3) to M."""
    return global_from_hull.inverse().apply(solution.landmarks.position)


def height_figures(landmarks: Array, truth: Truth, motion: Poses) -> Figures:
    """Score how much of each structure's height its landmarks keep.

    1 is all of the height, 0 is flat on the hull. Structures of at least 0.08 m with three
    landmarks or more on top count.
    """
    rows = {
        o.id: height_over_steel(landmarks, o, truth, motion)
        for o in truth.structures()
        if abs(o.height) >= 0.08
    }
    ratios = {
        str(key): float(np.median(ours) / np.median(true))
        for key, (ours, true) in rows.items()
        if len(ours) >= 3
    }
    if not ratios:
        return {"structures": 0}
    values = np.array(list(ratios.values()))
    worst = values[np.argmax(np.abs(values - 1))]
    return {
        "structures": len(ratios),
        "ratio_median": float(np.median(values)),
        "ratio_worst": float(worst),
        "ratios": ratios,
    }


def height_over_steel(
    landmarks: Array, structure: TrueStructure, truth: Truth, motion: Poses
) -> tuple[Array, Array]:
    """Measure heights (n,) m over the steel of landmarks on a structure's top, and the true ones.

    landmarks: (m, 3) m in M. motion: lays them onto the true hull. What the surroundings are off (a
    method may move the hull as a whole) is subtracted from ours.
    """
    center, normal = np.array(structure.center), np.array(structure.normal)
    away = motion.apply(landmarks) - center
    offset = away @ normal
    tangential = np.linalg.norm(away - offset[:, None] * normal, axis=1)
    size = min(structure.extent)
    close = np.abs(offset) < 0.35  # m: on this side of the hull
    on_top = close & (tangential < 0.35 * size)
    around = (
        close
        & (tangential > 0.6 * max(structure.extent) + 0.02)
        & (tangential < max(structure.extent) + 0.15)
    )
    # Cast from half a metre above the top at the steel below each landmark
    above = away[on_top] + center + (0.5 - offset[on_top, None]) * normal
    true = structure.height + 0.5 - truth.built.cast(above, np.tile(-normal, (len(above), 1)))
    ours = structure.height + offset[on_top]
    if around.sum() >= 3:
        ours = ours - np.median(truth.built.closest(motion.apply(landmarks[around])).distance)
    return ours, true


def gap_figures(landmarks: Array, dvl: Array, cad_model: Scene) -> Figures:
    """Score how far landmarks on bare steel lie off the surface that the DVL measured.

    landmarks, dvl: (n, 3) and (k, 3) m in M, the latter ends of beams. It is the difference of
    their distances to the CAD model, each landmark against the median of its nearest returns.
    """
    from scipy.spatial import cKDTree

    if len(dvl) < NEIGHBOURS or len(landmarks) == 0:
        return {"landmarks": 0}
    distance, index = (np.asarray(a) for a in cKDTree(dvl).query(landmarks, k=NEIGHBOURS))
    near = distance[:, NEIGHBOURS // 2] < REACH_M
    surface = np.median(cad_model.closest(dvl).distance[index[near]], axis=1)
    gap = cad_model.closest(landmarks[near]).distance - surface
    if len(gap) == 0:
        return {"landmarks": 0}
    return {
        "landmarks": len(gap),
        "median_m": float(np.median(np.abs(gap))),
        "mean_m": float(np.mean(gap)),
    }


def _score_cameras(solution: Solution, hull_from_vehicle: Poses, rig: Rig, truth: Truth) -> Figures:
    """Score the centres of the top camera at the nodes that have an image."""
    has = solution.image[:, Camera.TOP.column] >= 0
    path = VehiclePath(poses=hull_from_vehicle[has], tray=solution.tray[has])
    cameras = rig.with_mounts(solution.mounts).poses_along(path, Camera.TOP)
    return centre_figures(stamps(solution)[has], cameras.translation, truth)


def _on_steel(landmarks: Array, truth: Truth, motion: Poses) -> Mask:
    """Mark landmarks (n,) away from everything that stands out."""
    moved, clear = motion.apply(landmarks), np.ones(len(landmarks), bool)
    for o in truth.structures():
        clear &= np.linalg.norm(moved - np.array(o.center), axis=1) > 0.5 * max(o.extent) + 0.15
    return clear

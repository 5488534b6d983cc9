# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Score the path and the camera poses of a run against the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hullrecon.evaluation.deliverables import TimedPoses
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.poses import Poses, from_rpy, identity
from hullrecon.geometry.rigid_fit import fit_rigid, fit_scale
from hullrecon.geometry.rotations import roll_pitch_yaw
from hullrecon.typing import Array


def rms(values: Array) -> float:
    """Compute the root mean square of values. NaN for no values."""
    return float(np.sqrt(np.mean(np.square(values)))) if np.size(values) else float("nan")


def rms_length(vectors: Array) -> float:
    """Compute the root mean square length of vectors (n, 3)."""
    return rms(np.linalg.norm(vectors, axis=1))


def score_cameras(model: Path, truth: Truth) -> Figures:
    """Score the positions of the top camera in a COLMAP model, whose images are named by stamps."""
    import pycolmap

    stamps, centres = list[int](), list[Array]()
    for image in pycolmap.Reconstruction(str(model)).images.values():
        name = Path(image.name)
        if name.parts[0] == Camera.TOP.key and image.has_pose:
            stamps.append(int(name.stem))
            centres.append(np.asarray(image.projection_center(), float))
    return centre_figures(np.array(stamps, float) * 1e-9, np.array(centres).reshape(-1, 3), truth)


def centre_figures(t_s: Array, centres: Array, truth: Truth) -> Figures:
    """Score camera centres (n, 3) in M at times t_s (n,), as delivered and after two alignments.

    Times without a true frame within a millisecond are left out.
    """
    row = np.array([int(np.argmin(np.abs(truth.t_s - t))) for t in t_s], np.int64)
    known = np.abs(truth.t_s[row] - t_s) <= 1e-3
    if known.sum() < 3:
        return {"images": int(known.sum())}
    ours, true = centres[known], truth.cameras_at(row[known]).translation
    motion = fit_rigid(ours, true)
    scale = fit_scale(ours, true, motion)
    middle = ours.mean(axis=0)
    similar = scale * motion.rotation.apply(ours - middle) + true.mean(axis=0)
    return {
        "images": int(known.sum()),
        "rmse_m": rms_length(ours - true),
        "rigid_rmse_m": rms_length(motion.apply(ours) - true),
        "similarity_rmse_m": rms_length(similar - true),
        "scale_error_percent": 100 * abs(1 - scale),
    }


Figures = dict[str, float | int | list[int] | dict[str, float]]  # by name, its unit at the end


def score_trajectory(track: TimedPoses, truth: Truth) -> tuple[Figures, Poses]:
    """Score a trajectory, and fit the rigid motion that aligns it with the true one.

    A CAD model that is off by a centimetre over the whole surveyed patch cannot be distinguished
    from a shift of the dive. So surfaces, landmarks and objects are scored both as delivered and
    after this motion.
    """
    ours = track.rows((track.t_s >= truth.t_s.min() - 1e-6) & (track.t_s <= truth.t_s.max() + 1e-6))
    if len(ours.t_s) < 3:
        return {"poses": len(ours.t_s), "share_of_true_frames_with_a_pose": 0.0}, identity()
    want = truth.vehicle_at(ours.t_s)
    error = ours.poses.translation - want.translation
    motion = fit_rigid(ours.poses.translation, want.translation)
    turn = ours.poses.rotation * want.rotation.inv()
    turn_after = motion.rotation * turn
    figures: Figures = {
        "poses": len(ours.t_s),
        "share_of_true_frames_with_a_pose": _covered_share(ours.t_s, truth.t_s),
    }
    if truth.cad_model is not None:
        figures |= _by_direction(error, want.translation, truth.cad_model)
    figures |= {
        "rigid_rmse_m": rms_length(motion.apply(ours.poses.translation) - want.translation),
        "rotation_rmse_deg": float(np.degrees(rms(np.asarray(turn.magnitude())))),
        "rotation_rigid_rmse_deg": float(np.degrees(rms(np.asarray(turn_after.magnitude())))),
    }
    in_delivered = ours.hull_from_delivered.rotation.inv().apply(error)
    return figures | _consistency(in_delivered, ours.sigma), motion


def hull_from_start(track: TimedPoses, truth: Truth) -> Poses:
    """Compute the pose of g in M with which a track in g begins at the true pose.

    g is level, and its z is the true depth where depth was measured. Its other coordinates and
    heading follow from the first pose that has a truth, to which the sigmas are relative.
    """
    inside = np.flatnonzero(
        (track.t_s >= truth.t_s.min() - 1e-6) & (track.t_s <= truth.t_s.max() + 1e-6)
    )[:1]
    true = truth.global_from_hull @ truth.vehicle_at(track.t_s[inside])
    if not len(inside):
        return truth.global_from_hull.inverse()
    ours = track.poses[inside]
    turn = roll_pitch_yaw(true.rotation)[0, 2] - roll_pitch_yaw(ours.rotation)[0, 2]
    turned = from_rpy(np.zeros(3), np.array([0.0, 0.0, turn]))
    shift = true.translation - turned.apply(ours.translation)
    shift[:, 2] *= not track.has_depth
    return truth.global_from_hull.inverse() @ Poses(turned.quaternion, shift)


def _by_direction(error: Array, positions: Array, cad_model: Scene) -> Figures:
    """Compute the RMSE of errors (n, 3) in three directions of the hull nearest to each pose.

    They are along the hull, in girth and along the normal. positions (n, 3) m in M: of the true
    poses.
    """
    normal = positions - cad_model.closest(positions).foot
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    along = np.array([1.0, 0.0, 0.0]) - normal * normal[:, :1]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    parts = {"along": along, "girth": np.cross(normal, along), "normal": normal}
    return {f"{name}_rmse_m": rms((error * axis).sum(axis=1)) for name, axis in parts.items()}


def _consistency(error: Array, sigma: Array | None) -> Figures:
    """Compare errors (n, 3) with their sigmas (n, 3), by axis of the delivered frame.

    With right sigmas, 68 % of the errors are within one sigma.
    """
    if sigma is None:
        return {}
    figures: Figures = {}
    for k, axis in enumerate("xyz"):
        figures[f"error_over_sigma_{axis}"] = rms(error[:, k] / sigma[:, k])
        figures[f"median_sigma_{axis}_m"] = float(np.median(sigma[:, k]))
    for k, axis in enumerate("xyz"):
        figures[f"share_within_1_sigma_{axis}"] = float(np.mean(np.abs(error[:, k]) <= sigma[:, k]))
    return figures


def _covered_share(ours_s: Array, true_s: Array) -> float:
    """Compute the share of true frames that have a delivered pose near in time.

    Near is within three quarters of the frames' median period.
    """
    step = np.median(np.diff(true_s))
    ordered = np.sort(ours_s)
    right = np.clip(np.searchsorted(ordered, true_s), 1, len(ordered) - 1)
    apart_s = np.minimum(np.abs(ordered[right] - true_s), np.abs(ordered[right - 1] - true_s))
    return float(np.mean(apart_s < 0.75 * step))

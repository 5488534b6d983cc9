# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Errors of the cameras of the sparse model: as delivered, aligned rigidly and by similarity."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hullrecon.evaluation.scoring.statistics import rms_length
from hullrecon.evaluation.scoring.trajectory import Figures
from hullrecon.evaluation.scoring.truth import Truth
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.rigid_fit import fit_rigid, fit_scale
from hullrecon.typing import Array


def score_cameras(model: Path, truth: Truth) -> Figures:
    """Score the top camera of a COLMAP model whose images are named by their stamp."""
    import pycolmap

    stamps, centres = list[int](), list[Array]()
    for image in pycolmap.Reconstruction(str(model)).images.values():
        name = Path(image.name)
        if name.parts[0] == Camera.TOP.key and image.has_pose:
            stamps.append(int(name.stem))
            centres.append(np.asarray(image.projection_center(), float))
    return centre_figures(np.array(stamps, float) * 1e-9, np.array(centres).reshape(-1, 3), truth)


def centre_figures(t_s: Array, centres: Array, truth: Truth) -> Figures:
    """Score camera centres (n, 3) in M at times t_s (n,) that have a true frame."""
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

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the cameras of the sparse model stand, as delivered, after a rigid motion and after a similarity."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hullrecon.evaluation.scoring.alignment import rigid, rms_length, scale_after
from hullrecon.evaluation.scoring.trajectory import Figures
from hullrecon.evaluation.scoring.truth import Truth
from hullrecon.typing import Array


def judge_cameras(model: Path, truth: Truth) -> Figures:
    """Of camera_top in a COLMAP model whose images are named by their stamp."""
    import pycolmap

    stamps, centres = list[int](), list[Array]()
    for image in pycolmap.Reconstruction(str(model)).images.values():
        name = Path(image.name)
        if name.parts[0] == "camera_top" and image.has_pose:
            stamps.append(int(name.stem))
            centres.append(np.asarray(image.projection_center(), float))
    return centre_figures(np.array(stamps, float) * 1e-9, np.array(centres).reshape(-1, 3), truth)


def centre_figures(t_s: Array, centres: Array, truth: Truth) -> Figures:
    """Of camera centres (n, 3) in M at the times of true frames; others are left out."""
    row = np.array([int(np.argmin(np.abs(truth.t_s - t))) for t in t_s], np.int64)
    known = np.abs(truth.t_s[row] - t_s) <= 1e-3
    if known.sum() < 3:
        return {"images": int(known.sum())}
    ours, true = centres[known], truth.cameras_at(row[known]).translation
    motion = rigid(ours, true)
    scale = scale_after(ours, true, motion)
    middle = ours.mean(axis=0)
    similar = scale * (ours - middle) @ motion.rotation.T + true.mean(axis=0)
    return {
        "images": int(known.sum()),
        "rmse_m": rms_length(ours - true),
        "rigid_rmse_m": rms_length(motion.apply(ours) - true),
        "similarity_rmse_m": rms_length(similar - true),
        "scale_error_percent": 100 * abs(1 - scale),
    }

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A camera calibrated by images of a board [Aulinas2011 4.4.3, Fig. 4.23]."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.cameras import CameraModel
from hullrecon.studies.figure_style import COLOURS, PublishedFigure, finish_figure, new_canvas
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array

CAMERA = CameraModel(320, 240, 300.0, 300.0, 163.0, 118.0, k1=-0.22, k2=0.08)
COLUMNS, ROWS, SQUARE_M = 8, 6, 0.04
VIEWS, DRAWS = 8, 40
NOISE_PX = {"sharp images": 0.1, "noisy images": 1.0}
MARGIN_PX = 4.0
NUMBERS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Intrinsics (9,) by the board, and their sigmas."""

    intrinsics: Array
    sigma: Array
    rms_px: float


def board() -> Array:
    """Compute the corners of the board (n, 3) m in its plane."""
    x, y = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS))
    middle = [(COLUMNS - 1) / 2, (ROWS - 1) / 2]
    flat = np.column_stack([x.ravel(), y.ravel()]) - middle
    return np.column_stack([SQUARE_M * flat, np.zeros(len(flat))])


def views(rng: np.random.Generator, count: int = VIEWS) -> list[Array]:
    """Hold the board before the camera at random: its exact corners (n, 2) px in each image.

    All corners of a view lie in the image.
    """
    found: list[Array] = []
    while len(found) < count:
        turn = Rotation.from_rotvec(rng.normal(0, [0.35, 0.35, 0.15]))
        place = np.r_[rng.normal(0, 0.06, 2), rng.uniform(0.4, 0.7)]
        seen = CAMERA.project(turn.apply(board()) + place)
        size = np.array([CAMERA.width, CAMERA.height])
        if (seen > MARGIN_PX).all() and (seen < size - MARGIN_PX).all():
            found.append(seen)
    return found


def calibrate(seen: list[Array]) -> Calibration:
    """Calibrate a camera by the board as [Zhang2000]. seen: corners (n, 2) px of each view."""
    there = [board().astype(np.float32)] * len(seen)
    corners = [view.astype(np.float32)[:, None] for view in seen]
    rms, matrix, lens, *_, sigma, _, _ = cv2.calibrateCameraExtended(
        there, corners, (CAMERA.width, CAMERA.height), np.eye(3), np.zeros(5),
        flags=cv2.CALIB_FIX_K3,
    )  # fmt: skip
    fx, fy, cx, cy = matrix[[0, 1, 0, 1], [0, 1, 2, 2]]
    return Calibration(
        intrinsics=np.r_[fx, fy, cx, cy, lens.ravel()[:5]],
        sigma=sigma.ravel()[:9],
        rms_px=float(rms),
    )


def study() -> StudyResult:
    """Calibrate by sharp and by noisy images, many times."""
    exact = views(np.random.default_rng(0))
    rows, compared = [], []
    for name, noise in NOISE_PX.items():
        rng = np.random.default_rng(1)
        draws = [
            calibrate([view + noise * rng.standard_normal(view.shape) for view in exact])
            for _ in range(DRAWS)
        ]
        scatter = np.std([d.intrinsics for d in draws], axis=0)
        claimed = np.median([d.sigma for d in draws], axis=0)
        rows += [
            (name, number, f"{c:.3g}", f"{s:.3g}")
            for number, c, s in zip(NUMBERS[:6], claimed, scatter, strict=False)
        ]
        compared.append(
            ComparedValue(
                what=f"sigma of the principal point, {name}, {noise:g} px",
                unit="px",
                printed=10.0 if name == "noisy images" else None,
                ours=float(np.linalg.norm(claimed[2:4]) / np.sqrt(2)),
                note="about ten pixels by considerably noisy images of 320 x 240; how many images "
                "and how noisy is not printed",
            )
        )
        compared.append(
            ComparedValue(
                what=f"scatter of the principal point over its sigma, {name}",
                ours=float(np.mean(scatter[2:4] / claimed[2:4])),
                note=f"{DRAWS} calibrations of {VIEWS} views",
            )
        )
    return StudyResult(
        figures=(draw(exact),),
        heads=("images", "number", "sigma", "scatter"),
        rows=tuple(rows),
        compared=tuple(compared),
    )


def draw(exact: list[Array]) -> PublishedFigure:
    """Draw the views of the board, by their exact corners (n, 2) px [Aulinas2011 Fig. 4.23]."""
    figure, axes = new_canvas(9.6, 4.0, 2, 4, sharex="all", sharey="all")
    table = ["view,u_px,v_px"]
    for k, (axis, seen) in enumerate(zip([*axes[0], *axes[1]], exact, strict=True)):
        lattice = seen.reshape(ROWS, COLUMNS, 2)
        axis.plot(lattice[:, :, 0], lattice[:, :, 1], color=COLOURS["maxmix"], lw=0.8)
        axis.plot(lattice[:, :, 0].T, lattice[:, :, 1].T, color=COLOURS["maxmix"], lw=0.8)
        axis.set(xlim=(0, CAMERA.width), ylim=(CAMERA.height, 0), aspect="equal")
        table += [f"{k},{u:.3f},{v:.3f}" for u, v in seen]
    return finish_figure(
        "board_views", figure, table, "The corners of a board in the images of a calibration."
    )

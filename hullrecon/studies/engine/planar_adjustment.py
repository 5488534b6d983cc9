# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two views adjusted by the homography of a plane, 2N + 8 unknowns [KimEustice2009 III-C-2].

The N points of the first image are eliminated to first order, as Sampson's distance does, so that
eight unknowns are left: rotation, translation over the plane's distance, and normal. It is exact on
a plane. A hull that bends turns it, which is why the product refines on epipolar lines.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from hullrecon.studies.figure_style import (
    COLOURS,
    PublishedFigure,
    finish_figure,
    label_log_axis,
    new_canvas,
)
from hullrecon.studies.scenes import scene_figures as scenes
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array
from hullrecon.vision.pairs import mono_motion

MATCHES, TRIALS = 100, 25
SIGMA_PX = 0.3  # of a match, as SIFT has it
RADII_M = (np.inf, 16.0, 8.0, 4.0, 2.0)  # of a hull that bends across the motion
PLANAR, EPIPOLAR = "homography, 2N + 8", "epipolar lines, 3N + 5"


def homography_of(second_from_first: Array, normal: Array, distance: float) -> Array:
    """Compute the homography (3, 3) R - t n'/d of the plane n'X + d = 0 of the first camera.

    second_from_first: (4, 4). normal: unit (3,). distance: in the unit of the translation.
    """
    rotation, translation = second_from_first[:3, :3], second_from_first[:3, 3]
    return np.asarray(rotation - np.outer(translation, normal) / distance)


def adjust_plane(start: Array, normal: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """Adjust a motion and a plane to matches (n, 2) in ideal coordinates.

    Parameters
    ----------
    start
        (4, 4) second_from_first, the length of its translation in units of the plane's distance.
    normal
        (3,) of the plane, towards the first camera: n'X + 1 = 0.
    first, second
        The matches.

    Returns
    -------
    motion
        (4, 4) as `start`.
    normal
        (3,) of unit length.
    """
    across = mono_motion.tangent_basis(normal)

    def unpacked(x: Array) -> tuple[Array, Array]:
        """Apply a step (8,), of rotation, translation and tilt, to motion and normal."""
        motion = start.copy()
        motion[:3, :3] = start[:3, :3] @ Rotation.from_rotvec(x[:3]).as_matrix()
        motion[:3, 3] = start[:3, 3] + x[3:6]
        tilted = normal + across @ x[6:]
        return motion, tilted / np.linalg.norm(tilted)

    def residual(x: Array) -> Array:
        """Compute the whitened transfer errors (2n,) after a step (8,)."""
        motion, plane = unpacked(x)
        return whitened_transfer(homography_of(motion, plane, 1.0), first, second).ravel()

    return unpacked(least_squares(residual, np.zeros(8), method="lm", x_scale=0.01).x)


def whitened_transfer(homography: Array, first: Array, second: Array) -> Array:
    """Compute transfer errors (n, 2) of matches, whitened for equal noise in both images.

    Parameters
    ----------
    homography
        (3, 3) from the first image to the second.
    first, second
        (n, 2) ideal coordinates.
    """
    here = np.hstack([first, np.ones((len(first), 1))])
    there = here @ homography.T
    moved = there[:, :2] / there[:, 2:]
    by = (homography[None, :2, :2] - moved[:, :, None] * homography[2:, :2]) / there[:, 2:, None]
    covariance = np.eye(2) + by @ by.swapaxes(1, 2)
    root = np.linalg.cholesky(covariance)
    return np.asarray(np.linalg.solve(root, (second - moved)[:, :, None])[:, :, 0])


def study() -> StudyResult:
    """Adjust views of a plane and of hulls that bend, by either form, and compare with truth."""
    rng = np.random.default_rng(0)
    turns = {
        radius: np.array([turned_by(*_views(rng, radius)) for _ in range(TRIALS)])
        for radius in RADII_M
    }
    plane, bilge = (1e3 * np.sqrt((turns[r] ** 2).mean(axis=0)) for r in (np.inf, RADII_M[-1]))
    compared = []
    for where, found in (("a plane", plane), (f"a bilge of {RADII_M[-1]:g} m", bilge)):
        for name, turn in zip((PLANAR, EPIPOLAR), found, strict=True):
            compared.append(
                ComparedValue(
                    what=f"rotation off on {where}, {name}",
                    unit="mrad",
                    ours=float(turn),
                    note="the paper prefers the homography on planes",
                )
            )
    return StudyResult(figures=(planar_adjustment(turns),), compared=tuple(compared))


def turned_by(first: Array, second: Array) -> tuple[float, float]:
    """Measure the error of the rotation, rad, by the planar and by the epipolar form.

    first, second: matches (n, 2) in ideal coordinates of the scene's two views.
    """
    true = scenes.SECOND_FROM_FIRST.matrix()[0]
    start = true.copy()
    start[:3, 3] /= scenes.DISTANCE_M
    planar, _ = adjust_plane(start, np.array([0.0, 0.0, -1.0]), first, second)
    unit = true.copy()
    unit[:3, 3] /= np.linalg.norm(unit[:3, 3])
    lines, _ = mono_motion.refine(unit, first, second)
    off = [Rotation.from_matrix(true[:3, :3].T @ m[:3, :3]).magnitude() for m in (planar, lines)]
    return float(off[0]), float(off[1])


def _views(rng: np.random.Generator, radius_m: float) -> tuple[Array, Array]:
    """Project points of a hull, bent about the axis along the motion, into both views (n, 2)."""
    across = scenes.PEAKS_SIZE_M * rng.uniform(-0.5, 0.5, (MATCHES, 2))
    bent = np.zeros(MATCHES) if np.isinf(radius_m) else bend(across[:, 1], radius_m)
    points = np.column_stack(
        [across + np.array([0.5 * scenes.BASELINE_M, 0.0]), scenes.DISTANCE_M + bent]
    )
    return scenes.seen_twice(rng, points, SIGMA_PX * scenes.PIXEL_IDEAL)


def bend(across: Array, radius_m: float) -> Array:
    """Compute the depth (n,) m of a cylinder behind its tangent plane.

    across: (n,) m from the line where it touches the plane.
    """
    return np.asarray(radius_m - np.sqrt(radius_m**2 - across**2))


def planar_adjustment(turns: dict[float, Array]) -> PublishedFigure:
    """Draw the error of the rotation against how a hull bends, for both forms.

    turns: errors (TRIALS, 2) rad of the planar and the epipolar form, by the hull's radius, m.
    """
    figure, axes = new_canvas(6.4, 3.6)
    curvature = np.array([0.0 if np.isinf(r) else 1 / r for r in turns])
    table = ["curvature_per_m,trials,planar_rms_mrad,epipolar_rms_mrad"]
    rms = np.array([1e3 * np.sqrt((t**2).mean(axis=0)) for t in turns.values()])
    for k, (name, method) in enumerate(((PLANAR, "geva"), (EPIPOLAR, "maxmix"))):
        axes[0][0].plot(
            curvature, rms[:, k], color=COLOURS[method], marker="o", markersize=4.5, label=name
        )
    axes[0][0].set(
        xlabel="curvature of the hull (1/m)",
        ylabel="error of the rotation, rms (mrad)",
        yscale="log",
    )
    label_log_axis(axes[0][0].yaxis)
    axes[0][0].legend(fontsize=8, frameon=False)
    table += [f"{c:.4f},{TRIALS},{p:.4f},{e:.4f}" for c, (p, e) in zip(curvature, rms, strict=True)]
    caption = (
        "Error of the rotation of two views by the plane-induced homography and by epipolar lines, "
        f"{TRIALS} trials of {MATCHES} matches with a sigma of {SIGMA_PX:g} px each: on a plane "
        f"{rms[0, 0]:.2g} and {rms[0, 1]:.2g} mrad, on a hull of {RADII_M[-1]:g} m radius "
        f"{rms[-1, 0]:.2g} and {rms[-1, 1]:.2g} mrad."
    )
    return finish_figure("planar_adjustment", figure, table, caption)

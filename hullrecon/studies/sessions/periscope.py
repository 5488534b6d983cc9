# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where a point of one periscope image lies in another [Ozog2016 2.4.3.3, D.3, eq. D.12].

Above water the scene is taken for a plane, and of two poses at one place all but the sideways move
is well known: ellipses that are wide and low.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from hullrecon.studies.figure_style import (
    COLOURS,
    RED,
    PublishedFigure,
    draw_ellipse,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array

WIDTH, HEIGHT, FOCAL_PX = 1024, 768, 1000.0
CALIBRATION = np.array([[FOCAL_PX, 0, WIDTH / 2], [0, FOCAL_PX, HEIGHT / 2], [0, 0, 1.0]])
WALL_M = 15.0  # from the ship's side above water to the vehicle
# second camera in the first: to the side, down, ahead m; about these axes rad
SIDE_SIGMA = np.array([1.5, 0.05, 0.3, 0.005, 0.02, 0.005])
PLANE_SIGMA_M, PIXEL_SIGMA_PX = np.array([0.4, 0.2, 0.8]), 1.0  # plane: x, y, z of the camera
DRAWS, SHARE = 4000, 0.99
SCALES = (0.25, 0.5, 1.0, 2.0)  # of the way to the side


@dataclass(frozen=True, kw_only=True)
class Transfer:
    """The uncertain inputs of a transfer, as of `transferred`."""

    mean: Array  # (11,)
    covariance: Array  # (11, 11)


def transferred(inputs: Array) -> Array:
    """Transfer pixels of a first image over a plane into a second image: (n, 2) px (D.12).

    inputs: (n, 11), the pose first_from_second (translation m, rotation vector rad), the plane in
    the first camera's frame (m: unit normal towards the camera times distance), and the pixel.
    """
    shift, turn = inputs[:, :3], Rotation.from_rotvec(inputs[:, 3:6]).inv()
    plane, pixel = inputs[:, 6:9], np.column_stack([inputs[:, 9:], np.ones(len(inputs))])
    ray = pixel @ np.linalg.inv(CALIBRATION).T
    # The point depth * ray lies on the plane, pi . x = -|pi|^2
    depth = -np.sum(plane**2, axis=1) / np.sum(ray * plane, axis=1)
    there = turn.apply(depth[:, None] * ray - shift) @ CALIBRATION.T
    return np.asarray(there[:, :2] / there[:, 2:])


def unscented(
    function: Callable[[Array], Array], mean: Array, covariance: Array
) -> tuple[Array, Array]:
    """Carry a mean (n,) and covariance (n, n) through a function by sigma points.

    function: turns points (m, n) into values (m, k). Returns the values' mean (k,) and covariance.
    """
    size = len(mean)
    steps = np.sqrt(size) * np.linalg.cholesky(covariance).T
    values = function(np.vstack([mean + steps, mean - steps]))
    off = values - values.mean(axis=0)
    return values.mean(axis=0), off.T @ off / (2 * size)


def transfer_of(pixel: Array, scale: float = 1.0) -> Transfer:
    """Make the inputs of the transfer of a pixel (2,).

    scale: factor on the sigma of the sideways move.
    """
    sigma = SIDE_SIGMA * np.r_[scale, np.ones(5)]
    return Transfer(
        mean=np.r_[np.zeros(6), 0.0, 0.0, -WALL_M, pixel],
        covariance=np.diag(np.r_[sigma, PLANE_SIGMA_M, PIXEL_SIGMA_PX, PIXEL_SIGMA_PX]) ** 2,
    )


def grid() -> Array:
    """Choose pixels (16, 2) of the first image, as the source draws them."""
    u, v = np.meshgrid(np.linspace(150, WIDTH - 150, 4), np.linspace(120, HEIGHT - 120, 4))
    return np.column_stack([u.ravel(), v.ravel()])


def inside(transfer: Transfer, rng: np.random.Generator) -> tuple[float, Array, Array, Array]:
    """Test the ellipse of a transfer by drawing its inputs.

    Returns
    -------
    float
        Share of the drawn transfers inside of the 99 % ellipse.
    Array, Array
        Mean (2,) px and covariance (2, 2) px^2 of the ellipse.
    Array
        The drawn transfers (DRAWS, 2) px.
    """
    mean, spread = unscented(transferred, transfer.mean, transfer.covariance)
    drawn = transferred(rng.multivariate_normal(transfer.mean, transfer.covariance, DRAWS))
    off = drawn - mean
    squared = np.einsum("ni,ij,nj->n", off, np.linalg.inv(spread), off)
    return float((squared < chi2(2).ppf(SHARE)).mean()), mean, spread, drawn


def study() -> StudyResult:
    """Transfer a grid of pixels, with a growing sigma of the sideways move."""
    rng = np.random.default_rng(0)
    # by scale: share inside the ellipses, %, their median height over width, and share searched, %
    rows, shares, low, searched = [], {}, {}, {}
    for scale in SCALES:
        found = [inside(transfer_of(pixel, scale), rng) for pixel in grid()]
        spreads = np.array([spread for _, _, spread, _ in found])
        shares[scale] = 100 * float(np.mean([share for share, *_ in found]))
        low[scale] = float(np.median(np.sqrt(spreads[:, 1, 1] / spreads[:, 0, 0])))
        area = np.pi * chi2(2).ppf(SHARE) * np.sqrt(np.linalg.det(spreads))
        searched[scale] = 100 * float(np.mean(area) / (WIDTH * HEIGHT))
        rows.append(
            (f"{scale * SIDE_SIGMA[0]:g}", f"{shares[scale]:.1f}", f"{low[scale]:.2f}",
             f"{searched[scale]:.1f}")
        )  # fmt: skip
    return StudyResult(
        figures=(draw(rng),),
        heads=("sigma to the side, m", "drawn transfers in the 99 % ellipse, %",
               "height over width", "of the image searched, %"),
        rows=tuple(rows),
        compared=(
            ComparedValue(
                what=f"drawn transfers in the ellipse, {SIDE_SIGMA[0]:g} m to the side",
                unit="%", printed=99.0, ours=shares[1.0],
                note="fairly Gaussian except where the covariance is large",
            ),
            ComparedValue(
                what="height of the ellipses over their width",
                ours=low[1.0], note="corresponding features share similar rows",
            ),
            ComparedValue(
                what="share of the image that is searched", unit="%",
                ours=searched[1.0], note="ellipses, rather than the entire image",
            ),
        ),
    )  # fmt: skip


def draw(rng: np.random.Generator) -> PublishedFigure:
    """Draw ellipses and drawn transfers in the second image [Ozog2016 Fig. 2.11]."""
    figure, axes = new_canvas(7.0, 5.2)
    axis, table = axes[0][0], ["u_px,v_px,sigma_u_px,sigma_v_px,inside"]
    for pixel in grid():
        share, mean, spread, drawn = inside(transfer_of(pixel, SCALES[0]), rng)
        axis.plot(*drawn[:300].T, ".", ms=1, color=COLOURS["naive"], alpha=0.5)
        draw_ellipse(axis, mean, spread, float(np.sqrt(chi2(2).ppf(SHARE))), RED)
        axis.plot(*pixel, "x", color=COLOURS["maxmix"])
        u, v = np.sqrt(np.diag(spread))
        table.append(f"{pixel[0]:.1f},{pixel[1]:.1f},{u:.2f},{v:.2f},{share:.4f}")
    axis.set(xlim=(-200, WIDTH + 200), ylim=(HEIGHT + 50, -50), xlabel="u (px)", ylabel="v (px)")
    return finish_figure(
        "periscope_ellipses",
        figure,
        table,
        f"Pixels of one image above water (crosses) in another, {SCALES[0] * SIDE_SIGMA[0]:g} m to "
        "the side: drawn, and the 99 % ellipses by sigma points.",
    )

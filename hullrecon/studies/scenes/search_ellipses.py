# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Do transferred points spread as the ellipses that are searched? [Ozog2016 Fig. D.4]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue
from hullrecon.typing import Array

GATE_CHI2 = -2 * np.log(0.01)  # 99 % of two degrees of freedom
MOST_DRAWN = 250  # samples of a point


@dataclass(frozen=True, kw_only=True)
class TransferredPoints:
    """Points (p) in the second image, px."""

    mean: Array  # (p, 2) predicted
    covariance: Array  # (p, 2, 2) predicted
    samples: Array  # (p, s, 2) of where they come to lie

    def share_within(self) -> Array:
        """Compute the share (p,) of the samples within the 99 % ellipse."""
        off = self.samples - self.mean[:, None]
        square = np.einsum("psi,pij,psj->ps", off, np.linalg.inv(self.covariance), off)
        return np.asarray(np.mean(square < GATE_CHI2, axis=1))

    def semi_axes_px(self) -> Array:
        """Compute semi-axes (p, 2) of the 99 % ellipse, the shorter first."""
        return np.asarray(np.sqrt(GATE_CHI2 * np.linalg.eigvalsh(self.covariance)))

    def outlines(self) -> Array:
        """Trace the ellipses (p, 73, 2) as closed lines."""
        angle = np.linspace(0, 2 * np.pi, 73)
        circle = np.sqrt(GATE_CHI2) * np.stack([np.cos(angle), np.sin(angle)])
        return np.asarray(
            self.mean[:, None] + (np.linalg.cholesky(self.covariance) @ circle).swapaxes(1, 2)
        )


def search_ellipses(
    sizes: Mapping[str, TransferredPoints], image_px: tuple[int, int]
) -> PublishedFigure:
    """Draw [Ozog2016 Fig. D.4]: samples and 99 % ellipses in the second image."""
    figure, axes = new_canvas(4.4 * len(sizes), 4.4, 1, len(sizes))
    table, words = ["size,point,u_px,v_px,semi_axis_short_px,semi_axis_long_px,share_within_99"], []
    for axis, (name, points) in zip(axes[0], sizes.items(), strict=True):
        _draw_points(axis, points, image_px)
        share, semi = points.share_within(), points.semi_axes_px()
        axis.set_title(f"{name}: {100 * np.median(share):.1f} % within", fontsize=9)
        axis.set_xlabel("column in the second image (px)")
        for k, (u, v) in enumerate(points.mean):
            table.append(
                f"{name},{k},{u:.1f},{v:.1f},{semi[k, 0]:.2f},{semi[k, 1]:.2f},{share[k]:.4f}"
            )
        words.append(f"{name} {100 * np.median(share):.1f} % (least {100 * share.min():.1f} %)")
    axes[0][0].set_ylabel("row (px)")
    figure.legend(
        *axes[0][0].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=3,
        fontsize=8,
        frameon=False,
        markerscale=4,
    )
    caption = (
        "Median share of the transferred points within their 99 % ellipses, by sigmas of the "
        f"pose: {'; '.join(words)}."
    )
    compared = tuple(
        ComparedValue(
            what=f"transferred points within their 99 % ellipse, sigmas of {name}",
            unit="%",
            printed=99.0,
            ours=float(100 * np.median(points.share_within())),
            note='printed: "fairly Gaussian except when" the covariance "becomes large"',
        )
        for name, points in sizes.items()
    )
    return finish_figure("search_ellipses", figure, table, caption, compared)


def _draw_points(axis: Axes, points: TransferredPoints, image_px: tuple[int, int]) -> None:
    """Draw samples and ellipses in four colours, and the image's border."""
    from matplotlib.patches import Rectangle

    width, height = image_px
    border = Rectangle(
        (-0.5, -0.5),
        width,
        height,
        fill=False,
        edgecolor=INK,
        linewidth=1.4,
        label="border of the image",
    )
    palette = (COLOURS["maxmix"], COLOURS["geva"], GREEN, RED)
    for k, (samples, outline) in enumerate(
        zip(points.samples[:, :MOST_DRAWN], points.outlines(), strict=True)
    ):
        shade = palette[(k + 2 * (k // 4)) % 4]
        labels = ("samples", "99 % ellipse") if k == 0 else (None, None)
        axis.scatter(
            samples[:, 0],
            samples[:, 1],
            s=1.6,
            color=shade,
            alpha=0.45,
            linewidths=0,
            label=labels[0],
        )
        axis.plot(*outline.T, color=shade, linewidth=1.2, label=labels[1])
    axis.add_patch(border)
    axis.set_aspect("equal", adjustable="datalim")
    axis.invert_yaxis()

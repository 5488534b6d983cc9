# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Draws docs/figures/frames.png, the picture of docs/concepts.md: python docs/figures/frames.py"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, Polygon, Rectangle
from numpy.typing import NDArray

mpl.use("Agg")
import matplotlib.pyplot as plt

INK, HULL, BEAM, SEEN, OFF = "#222222", "#5b6b7a", "#c2571a", "#1f6fb2", "#b3261e"


def main() -> None:
    """Write the picture beside this script."""
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(12.5, 4.4), gridspec_kw={"width_ratios": [1.12, 1.0]}
    )
    draw_frames(left)
    draw_chart(right)
    figure.tight_layout()
    figure.savefig(Path(__file__).with_suffix(".png"), dpi=110, metadata={"Software": None})


def draw_frames(axes: Axes) -> None:
    """Section across the hull with the vehicle facing it, seen along the hull."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 80)
    section = np.stack(
        [
            6.2 - 2.4 * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.55,
            0.2 + 2.9 * np.sin(angle),
        ],
        axis=1,
    )
    section = section[section[:, 1] <= 1.5]
    skin = np.vstack([section, [[6.2, 1.5], [6.2, section[0, 1]]]])
    axes.add_patch(Polygon(skin, facecolor="#e6ebef", edgecolor="none"))
    axes.plot(*section.T, color=HULL, lw=2.5)
    axes.plot([-3.1, 6.4], [1.2, 1.2], color="#7fb3d5", lw=1.2)
    axes.text(-1.05, 1.27, "water surface", color="#4a86a8", fontsize=9)
    frame(axes, (-2.3, 1.2), "g", ("x, y", "z"), down=True)
    frame(axes, (6.2, float(section[0, 1])), "M", ("y", "z"), down=False, flip=True)
    _vehicle(axes, section)
    _girth(axes, section)
    axes.set_xlim(-2.8, 6.6)
    axes.set_ylim(-3.0, 1.75)
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_title("Frames, seen along the hull", fontsize=11, loc="left")


def frame(
    axes: Axes,
    at: tuple[float, float],
    name: str,
    marks: tuple[str, str],
    *,
    down: bool,
    flip: bool = False,
    size: float = 0.75,
    place: tuple[float, float] = (-0.16, 0.12),
) -> None:
    """Draw two axes of a frame: the first right (left with `flip`), the second down or up."""
    way = np.array([[-1.0 if flip else 1.0, 0.0], [0.0, -1.0 if down else 1.0]]) * size
    for (dx, dy), mark in zip(way, marks, strict=True):
        axes.annotate(
            "",
            (at[0] + dx, at[1] + dy),
            at,
            arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.3},
        )
        axes.text(
            at[0] + 1.22 * dx,
            at[1] + 1.22 * dy,
            mark,
            fontsize=9,
            ha="center",
            va="center",
            color=INK,
        )
    axes.plot(*at, "o", color=INK, ms=3.5)
    axes.text(
        at[0] + place[0], at[1] + place[1], name, fontsize=12, weight="bold", ha="right", color=INK
    )


def _vehicle(axes: Axes, section: NDArray[np.float64]) -> None:
    axes.add_patch(Rectangle((-1.6, -1.45), 2.0, 0.8, facecolor="#f2d9c4", edgecolor=INK, lw=1.2))
    axes.text(-1.55, -0.61, "vehicle", fontsize=9, va="bottom")
    frame(axes, (-0.9, -1.0), "v", ("x", "z"), down=True, size=0.55, place=(-0.08, 0.06))
    origin, tilt = np.array([1.05, -1.2]), np.radians(10)
    turn = np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
    tray = np.array([[0.0, -0.75], [0.12, -0.75], [0.12, 0.75], [0.0, 0.75]]) @ turn + origin
    axes.add_patch(Polygon(tray, facecolor="#d7dee4", edgecolor=INK, lw=1.2))
    axes.plot([0.4, origin[0]], [-1.1, origin[1]], color=INK, lw=2)
    axes.add_patch(Circle(origin, 0.06, facecolor="white", edgecolor=INK))
    axes.add_patch(Arc(tuple(origin), 2.3, 2.3, theta1=0, theta2=10, color=INK, lw=1))
    axes.plot([origin[0], origin[0] + 1.25], [origin[1], origin[1]], color=INK, lw=0.7, ls=":")
    normal = 1.25 * np.array([np.cos(tilt), np.sin(tilt)])
    axes.plot(
        [origin[0], origin[0] + normal[0]],
        [origin[1], origin[1] + normal[1]],
        color=INK,
        lw=0.7,
        ls=":",
    )
    axes.text(origin[0] + 1.27, origin[1] + 0.02, "θ", fontsize=11)
    axes.text(origin[0] - 0.3, origin[1] - 0.3, "s", fontsize=12, weight="bold")
    axes.text(
        origin[0] - 0.35,
        origin[1] - 0.85,
        "tray: turns about\nthe vehicle's y",
        fontsize=9,
        ha="center",
        va="top",
    )
    for offset, name, color, half in (
        (-0.5, "d", BEAM, 22),
        (0.25, "cb", SEEN, 0),
        (0.62, "ct", SEEN, 17),
    ):
        at = np.array([0.12, offset]) @ turn + origin
        axes.plot(*at, "s", color=color, ms=7)
        axes.text(
            at[0] - 0.2,
            at[1] + 0.02,
            name,
            fontsize=11,
            weight="bold",
            color=color,
            ha="right",
            va="center",
        )
        for way in (-half, half) if half else ():
            end = _met(at, tilt + np.radians(way), section)
            axes.plot(
                [at[0], end[0]],
                [at[1], end[1]],
                color=color,
                lw=1.0,
                ls="-" if name == "d" else "--",
            )
    axes.text(2.1, -2.5, "DVL beams:\nranges and velocity", color=BEAM, fontsize=9)
    axes.text(1.15, 0.42, "camera's\nfield of view", color=SEEN, fontsize=9)


def _met(
    at: NDArray[np.float64], angle: float, section: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Where a ray meets the section: the first of its points that lies beyond the skin."""
    ray = at + np.linspace(0, 6, 1200)[:, None] * np.array([np.cos(angle), np.sin(angle)])
    skin = np.interp(ray[:, 1], section[:, 1], section[:, 0])
    return np.asarray(ray[int(np.argmax(ray[:, 0] >= skin))])


def _girth(axes: Axes, section: NDArray[np.float64]) -> None:
    inner = section + np.array([0.28, 0.0])
    part = inner[(inner[:, 1] > -2.6) & (inner[:, 1] < 0.4)]
    axes.plot(*part.T, color=INK, lw=1, ls="-")
    axes.annotate(
        "",
        tuple(part[-1]),
        tuple(part[-4]),
        arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1},
    )
    axes.text(4.5, -0.9, "girth: arc from\nthe keel up", fontsize=9)
    axes.text(4.6, 0.7, "CAD model", fontsize=9, color=HULL)


def draw_chart(axes: Axes) -> None:
    """The hull chart with two legs of a survey."""
    rng = np.random.default_rng(4)
    for row, sense in ((0.9, 1), (1.75, -1)):
        x = np.linspace(0.5, 5.5, 14)[::sense]
        y = row + 0.04 * np.sin(2.2 * x)
        for k in range(0, 14, 3):
            axes.add_patch(
                Rectangle(
                    (x[k] - 0.62, y[k] - 0.52),
                    1.24,
                    1.04,
                    facecolor=SEEN,
                    alpha=0.10,
                    edgecolor=SEEN,
                    lw=0.8,
                )
            )
        axes.plot(x, y, color="#777777", lw=0.8, zorder=1)
        axes.plot(x, y, "o", color=INK, ms=3, zorder=2)
        axes.plot(x[::3], y[::3], "o", color=SEEN, ms=7, mfc="none", zorder=2)
    on = rng.uniform([0.1, 0.35], [5.9, 2.3], (130, 2))
    off = rng.normal([3.9, 1.35], [0.16, 0.10], (26, 2))
    axes.plot(*on[np.linalg.norm(on - [3.9, 1.35], axis=1) > 0.35].T, ".", color="#4b8f4b", ms=4)
    axes.plot(*off.T, ".", color=OFF, ms=5)
    axes.text(0.0, 3.12, "● node   ", fontsize=9, color=INK)
    axes.text(0.95, 3.12, "○ keyframe, with its footprint", fontsize=9, color=SEEN)
    axes.text(0.0, 2.86, "· landmark on the hull (label 1)", fontsize=9, color="#4b8f4b")
    axes.text(0.0, 2.60, "· landmark off it (label 0): a structure", fontsize=9, color=OFF)
    axes.annotate(
        "along (m), forward",
        (3.0, -0.1),
        (0.0, -0.13),
        arrowprops={"arrowstyle": "-|>", "color": INK},
        fontsize=9,
    )
    axes.annotate(
        "girth (m), up",
        (-0.22, 2.1),
        (-0.22, 0.12),
        arrowprops={"arrowstyle": "-|>", "color": INK},
        fontsize=9,
        rotation=90,
        ha="center",
        va="bottom",
    )
    axes.add_patch(Rectangle((-0.1, 0.1), 6.2, 2.4, facecolor="none", edgecolor=HULL, lw=1.2))
    axes.set_xlim(-0.5, 6.3)
    axes.set_ylim(-0.4, 3.4)
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_title(
        "Hull chart: the side unrolled, with two legs of a dive", fontsize=11, loc="left"
    )


if __name__ == "__main__":
    main()

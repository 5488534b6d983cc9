# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""O's figures of chapter 4 from solutions of our own: each a picture and the table behind it, as bytes and text."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
COLOURS = {"naive": "#7a7a7a", "geva": "#c8702a", "maxmix": "#1f6fb4"}


@dataclass(frozen=True)
class Figure:
    """name without ending; png: the picture; csv: the numbers in it."""

    name: str
    png: bytes
    csv: str


@dataclass(frozen=True)
class Section:
    """A thin slice across the hull at a structure, in its own plane: tangent (girth) and height over the steel, m.

    dvl, on, off (n, 2): returns and landmarks of label 1 and 0; steel (m, 2): the true surface; drawing (m, 2) or empty."""

    title: str
    dvl: Array
    on: Array
    off: Array
    steel: Array
    drawing: Array


@dataclass(frozen=True)
class Progress:
    """One solve: cost (k,), landmarks labelled 1 (k,) of how many, seconds of the whole step."""

    method: str
    cost: Array
    on_surface: Array
    landmarks: int
    seconds: float


def cross_sections(rows: Sequence[Sequence[Section]]) -> Figure:
    """O Fig. 4.10 (4.11 for one camera): a column a method, a row a weighting."""
    plt = _pyplot()
    figure, axes = plt.subplots(len(rows), len(rows[0]), figsize=(4.2 * len(rows[0]), 2.9 * len(rows)), squeeze=False)
    table = ["section,kind,tangent_m,height_m"]
    for axis, section in zip(axes.flat, [s for row in rows for s in row], strict=True):
        _section(axis, section)
        for kind in ("dvl", "on", "off", "steel", "drawing"):
            table += [f"{section.title},{kind},{x:.5f},{y:.5f}" for x, y in getattr(section, kind).tolist()]
    axes.flat[0].legend(loc="upper left", fontsize=7)
    for axis in axes[:, 0]:
        axis.set_ylabel("height over the steel, m")
    for axis in axes[-1]:
        axis.set_xlabel("along the girth, m")
    return Figure("cross_sections", _png(figure), _text(table))


def label_frequency(solves: Sequence[Progress]) -> Figure:
    """O Fig. 4.12: share of the landmarks with label 1 by iteration."""
    plt = _pyplot()
    figure, axis = plt.subplots(figsize=(5.2, 3.2))
    table = ["method,iteration,share_on_surface"]
    for solve in solves:
        share = solve.on_surface / max(1, solve.landmarks)
        axis.plot(share, marker=".", label=solve.method, **_line(solve.method))
        table += [f"{solve.method},{k},{value:.6f}" for k, value in enumerate(share.tolist())]
    axis.set(xlabel="iteration", ylabel="share of landmarks with label 1")
    axis.legend(fontsize=8)
    return Figure("label_frequency", _png(figure), _text(table))


def cost_history(solves: Sequence[Progress]) -> Figure:
    """O Fig. 4.13: cost by iteration and by time. What is drawn is the share by which a cost exceeds the solve's last one:
    weightings have costs of their own. The step's time is shared out evenly over the iterations of its last round."""
    plt = _pyplot()
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), sharey=True)
    table = ["method,iteration,seconds,cost"]
    for solve in solves:
        time = solve.seconds * (1 + np.arange(len(solve.cost))) / max(1, len(solve.cost))
        look = {"label": solve.method, **_line(solve.method)}
        excess = np.maximum(solve.cost / solve.cost[-1] - 1, 1e-9)[:-1]
        axes[0].plot(excess, **look)
        axes[1].plot(time[:-1], excess, **look)
        table += [f"{solve.method},{k},{t:.3f},{c:.9g}" for k, (t, c) in enumerate(zip(time, solve.cost, strict=True))]
    axes[0].set(xlabel="iteration", ylabel="cost over the last one", yscale="log")
    axes[1].set(xlabel="seconds of the step, shared out evenly")
    axes[0].legend(fontsize=8)
    return Figure("cost_history", _png(figure), _text(table))


def range_histogram(before: Array, after: Mapping[str, Array], reach_m: float = 0.3) -> Figure:
    """O Fig. 4.14: residuals of the DVL's ranges, dead reckoned and adjusted."""
    plt = _pyplot()
    figure, axis = plt.subplots(figsize=(5.2, 3.2))
    edges = np.linspace(-reach_m, reach_m, 81)
    middle = 0.5 * (edges[1:] + edges[:-1])
    counts = {name: np.histogram(values, edges)[0] for name, values in {"dead reckoned": before, **after}.items()}
    for name, count in counts.items():
        look = {"color": "#bbbbbb", "fill": True} if name == "dead reckoned" else _line(name)
        axis.stairs(count, edges, label=f"{name}: {_spread({'dead reckoned': before, **after}[name]):.3f} m", **look)
    axis.set(xlabel="predicted minus measured range, m", ylabel="returns")
    axis.legend(fontsize=7, title="robust sigma", title_fontsize=7, loc="upper left")
    rows = zip(middle.tolist(), *(count.tolist() for count in counts.values()), strict=True)
    table = [",".join(["residual_m", *counts]), *(",".join(f"{value:.5g}" for value in row) for row in rows)]
    return Figure("range_residuals", _png(figure), _text(table))


def structure_heights(heights: Mapping[str, Array], true: Array, kind: str) -> Figure:
    """O Fig. 4.16: heights of the landmarks on top of one structure, method by method, beside the true ones."""
    plt = _pyplot()
    figure, axis = plt.subplots(figsize=(5.2, 3.2))
    table = ["method,height_m"]
    for k, (method, values) in enumerate(heights.items()):
        spread = np.linspace(-0.3, 0.3, len(values)) if len(values) > 1 else np.zeros(len(values))
        axis.scatter(k + spread, np.sort(values), s=6, color=_colour(method))
        if len(values):
            axis.hlines(np.median(values), k - 0.4, k + 0.4, color="black")
            axis.annotate(f"{np.median(values):.3f} m", (k, max(values) + 0.004), fontsize=7, ha="center")
        table += [f"{method},{value:.5f}" for value in values.tolist()]
    if len(true):
        axis.axhline(float(np.median(true)), color="#2a8a3a", linestyle="--", label=f"true: {np.median(true):.3f} m")
        axis.legend(fontsize=8)
    axis.set_xticks(
        range(len(heights)), [name.replace(" ", "\n", 1).replace("weighted ", "weighted\n") for name in heights], fontsize=7
    )
    axis.set_ylabel(f"height of the {kind}'s landmarks, m")
    return Figure("structure_height", _png(figure), _text([*table, *(f"true,{value:.5f}" for value in true.tolist())]))


def _section(axis: Any, section: Section) -> None:
    if len(section.drawing):
        axis.plot(*section.drawing.T, color="black", linewidth=0.8, label="drawing")
    axis.plot(*section.steel.T, color="#2a8a3a", linewidth=0.8, label="as it is")
    axis.scatter(*section.dvl.T, s=9, color="#999999", marker="x", linewidth=0.6, label="DVL")
    axis.scatter(*section.on.T, s=4, color="#1f6fb4", label="label 1")
    axis.scatter(*section.off.T, s=4, color="#c02030", label="label 0")
    axis.set_title(section.title, fontsize=9)
    axis.set_ylim(-0.12, 0.22)
    axis.grid(alpha=0.3)


def _spread(values: Array) -> float:
    """Robust sigma, 1.4826 MAD."""
    return float(1.4826 * np.median(np.abs(values - np.median(values)))) if len(values) else float("nan")


def _colour(method: str) -> str:
    return next((colour for name, colour in COLOURS.items() if method.startswith(name)), "#444444")


def _line(method: str) -> dict[str, Any]:
    """Colour by method, dashed as printed."""
    return {"color": _colour(method), "linestyle": "--" if "printed" in method else "-"}


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    return pyplot


def _png(figure: Any) -> bytes:
    from matplotlib import pyplot

    figure.tight_layout()
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=130, metadata={"Software": None})
    pyplot.close(figure)
    return buffer.getvalue()


def _text(lines: list[str]) -> str:
    return "\n".join(lines) + "\n"

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Labels by iteration [Ozog2016 Fig. 4.12], cost by iteration and time [Ozog2016 Fig. 4.13]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hullrecon.records.iterations import broken, count
from hullrecon.studies.figure_style import (
    COLOURS,
    PublishedFigure,
    colour,
    finish_figure,
    label_log_axis,
    new_canvas,
)
from hullrecon.typing import Array, Ints

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_NEAR = 0.001  # of its last cost


@dataclass(frozen=True, kw_only=True)
class SolveHistory:
    """The iterations (k,) of one method, in the order of the rounds."""

    method: str
    as_published: bool  # one solve, as published
    round: Ints  # (k,)
    cost: Array  # (k,)
    landmarks: Ints  # (k,)
    on_surface: Ints  # (k,) landmarks labelled 1
    label_changes: Ints  # (k,)
    seconds: Array  # (k,) since the first solve began


def label_frequency(solves: Sequence[SolveHistory]) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.12]: the share of label 1 by iteration, one panel per solve."""
    figure, axes = new_canvas(
        4.4 * len(solves) + 0.4, 4.6, 2, len(solves), sharex="col", height_ratios=(3, 2)
    )
    table, captions = ["method,round,iteration,landmarks,on_surface,label_changes"], []
    for k, solve in enumerate(solves):
        share = 100 * solve.on_surface / np.maximum(1, solve.landmarks)
        step = np.arange(len(share))
        axes[0][k].plot(
            *broken(step, share, solve.round),
            color=COLOURS["maxmix"],
            linewidth=1.8,
            marker=".",
            markersize=4,
        )
        axes[0][k].set_title(_title(solve), fontsize=9)
        axes[0][k].annotate(
            f"starts at {share[0]:.1f} %, ends at {share[-1]:.1f} %",
            (0.97, 0.06),
            xycoords="axes fraction",
            ha="right",
            fontsize=8,
        )
        changed = np.where(solve.label_changes > 0, solve.label_changes, np.nan)
        axes[1][k].bar(step, changed, color=COLOURS["geva"], width=0.8)
        axes[1][k].set(
            xlabel="iteration" if solve.as_published else "iteration, all rounds", yscale="log"
        )
        label_log_axis(axes[1][k].yaxis)
        for axis in [row[k] for row in axes]:
            _mark_rounds(axis, solve.round)
        table += [
            f"{solve.method},{r},{i},{n},{on},{c}"
            for i, (r, n, on, c) in enumerate(
                zip(
                    solve.round, solve.landmarks, solve.on_surface, solve.label_changes, strict=True
                )
            )
        ]
        captions.append(
            f"{solve.method}: {share[0]:.1f} % to {share[-1]:.1f} %, {_labels_converged(solve)}"
        )
    axes[0][0].set_ylabel("landmarks on the hull (%)")
    axes[1][0].set_ylabel("labels changed")
    return finish_figure(
        "label_frequency", figure, table, "Labels by iteration. " + "; ".join(captions) + "."
    )


def cost_history(solves: Sequence[SolveHistory]) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.13]: cost by iteration and by time.

    Above are the solves as published, which share one weighting. Below are ours, whose lines break
    where a round begins: sigmas and landmarks change there, so costs do not compare across it.
    """
    groups = [
        g
        for g in ([s for s in solves if s.as_published], [s for s in solves if not s.as_published])
        if g
    ]
    figure, axes = new_canvas(9.2, 3.1 * len(groups), len(groups), 2, sharey="row")
    table, captions = ["method,round,iteration,seconds,cost"], []
    for row, group in zip(axes, groups, strict=True):
        for solve in group:
            _draw_costs(row, solve)
            rows = enumerate(zip(solve.round, solve.seconds, solve.cost, strict=True))
            table += [f"{solve.method},{r},{k},{t:.3f},{c:.9g}" for k, (r, t, c) in rows]
            captions.append(f"{solve.method} {_count(solve)}, {solve.seconds[-1]:.1f} s")
        row[0].set_ylabel(f"{_title(group[0], method=False)}\ncost (half sum of squares)")
        row[0].set_yscale("log")
        label_log_axis(row[0].yaxis)
        for axis, name, linear in zip(row, ("iteration", "time (s)"), (10.0, 1.0), strict=True):
            if group[0].as_published:
                axis.set_xscale("symlog", linthresh=linear)
                axis.xaxis.set_major_formatter("{x:g}")
                axis.set_xlim(left=0)
            axis.set_xlabel(name + ("" if group[0].as_published else ", all rounds"))
            axis.legend(
                fontsize=8,
                frameon=False,
                title=f"dot: within {_NEAR:.1%} of its end",
                title_fontsize=8,
            )
    return finish_figure(
        "cost_history", figure, table, "Cost by iteration and by time. " + "; ".join(captions) + "."
    )


def _draw_costs(row: list[Axes], solve: SolveHistory) -> None:
    """Draw the two curves of a method, with a dot where a round comes near its last cost."""
    ink, name = colour(solve.method), solve.method.split()[0]
    last = np.array([solve.cost[solve.round == number][-1] for number in solve.round])
    _, near = np.unique(
        np.where(solve.cost <= (1 + _NEAR) * last, solve.round, 0), return_index=True
    )
    near = near[solve.cost[near] <= (1 + _NEAR) * last[near]]
    step = np.arange(len(solve.cost), dtype=float)
    for axis, at, extent in (
        (row[0], step, _count(solve)),
        (row[1], solve.seconds, f"{solve.seconds[-1]:.1f} s"),
    ):
        axis.plot(
            *broken(at, solve.cost, solve.round),
            label=f"{name}, {extent}",
            color=ink,
            linewidth=1.8,
        )
        axis.plot(at[near], solve.cost[near], "o", color=ink, markersize=4)


def _title(solve: SolveHistory, method: bool = True) -> str:
    kind = (
        "as published, one solve"
        if solve.as_published
        else f"as weighted by us, {solve.round.max()} rounds"
    )
    return f"{solve.method.split()[0]}, {kind}" if method else kind


def _count(solve: SolveHistory) -> str:
    iterations = count(solve.round)
    return f"{iterations} iteration{'' if iterations == 1 else 's'}"


def _labels_converged(solve: SolveHistory, share: float = 0.001) -> str:
    """Say after how many iterations of the last round few labels change."""
    last = solve.round == solve.round.max()
    changing = np.flatnonzero(solve.label_changes[last] > share * solve.landmarks[last])
    iterations = int(changing.max()) if len(changing) else 0
    plural = "" if iterations == 1 else "s"
    return f"converged after {iterations} iteration{plural}" + (
        "" if solve.as_published else " of the last round"
    )


def _mark_rounds(axis: Axes, rounds: Ints) -> None:
    for k in np.flatnonzero(np.diff(rounds)) + 1:
        axis.axvline(k - 0.5, color="#7b8794", linewidth=0.8, linestyle=":")

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Labels by iteration [Ozog2016 Fig. 4.12], cost by iteration and time [Ozog2016 Fig. 4.13]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes

from hullrecon.records.iterations import broken, count
from hullrecon.studies.figure_style import (
    COLOURS,
    PublishedFigure,
    colour,
    finish_figure,
    label_log_axis,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue
from hullrecon.typing import Array, Ints

_NEAR = 0.001  # of its last cost
# [Ozog2016 Fig. 4.13, 4.4.1], of the stereo dataset
PRINTED_ITERATIONS = {"naive": 26.0, "geva": 38.0, "maxmix": 29.0}
PRINTED_EXTRA_TIME = {"geva": 50.0, "maxmix": 22.3}


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

    def last_round(self) -> SolveHistory:
        """Keep the last round, the only one with the CAD model and so with labels."""
        last = self.round == self.round.max()
        parts = ("round", "cost", "landmarks", "on_surface", "label_changes")
        seconds = self.seconds[last]
        return replace(
            self,
            **{name: getattr(self, name)[last] for name in parts},
            seconds=seconds - seconds[0],
        )


def label_frequency(solves: Sequence[SolveHistory]) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.12]: the share of label 1 by iteration, one panel per solve.

    The path is solved first, without the CAD model and so without labels. That is not drawn.
    """
    solves = [solve.last_round() for solve in solves]
    figure, axes = new_canvas(
        4.4 * len(solves) + 0.4, 4.6, 2, len(solves), sharex="col", height_ratios=(3, 2)
    )
    table, captions = ["method,round,iteration,landmarks,on_surface,label_changes"], []
    for k, solve in enumerate(solves):
        share = 100 * solve.on_surface / np.maximum(1, solve.landmarks)
        step = np.arange(len(share))
        axes[0][k].plot(
            step,
            share,
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
        axes[1][k].set(xlabel="iteration of the solve with labels", yscale="log")
        label_log_axis(axes[1][k].yaxis)
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
        "label_frequency",
        figure,
        table,
        "Labels by iteration, in the solve with the CAD model. " + "; ".join(captions) + ".",
        _compare_labels([solve for solve in solves if solve.as_published]),
    )


def cost_history(solves: Sequence[SolveHistory]) -> PublishedFigure:
    """Draw [Ozog2016 Fig. 4.13]: cost by iteration and by time.

    Above are the solves as published, which share one weighting: of each its last round, the one
    with the CAD model, as the source counts. Below are ours, whose lines break
    where a round begins: sigmas and landmarks change there, so costs do not compare across it.
    """
    published = [s.last_round() for s in solves if s.as_published]
    groups = [g for g in (published, [s for s in solves if not s.as_published]) if g]
    figure, axes = new_canvas(9.2, 3.1 * len(groups), len(groups), 2, sharey="row")
    table, captions = ["method,round,iteration,seconds,cost"], []
    for row, group in zip(axes, groups, strict=True):
        for solve in group:
            _draw_costs(row, solve)
            rows = enumerate(zip(solve.round, solve.seconds, solve.cost, strict=True))
            table += [f"{solve.method},{r},{k},{t:.3f},{c:.9g}" for k, (r, t, c) in rows]
            captions.append(f"{solve.method} {_count(solve)}, {solve.seconds[-1]:.1f} s")
        row[0].set(
            ylabel=f"{_title(group[0], method=False)}\ncost (half sum of squares)", yscale="log"
        )
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
        "cost_history",
        figure,
        table,
        "Cost by iteration and by time. " + "; ".join(captions) + ".",
        _compare_iterations(published),
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
    """Say how a solve was weighted, and by which method if asked."""
    kind = (
        "as published, one solve" if solve.as_published else f"as weighted by us, {_rounds(solve)}"
    )
    return f"{solve.method.split()[0]}, {kind}" if method else kind


def _rounds(solve: SolveHistory) -> str:
    """Say which rounds a history holds."""
    first, last = solve.round.min(), solve.round.max()
    return f"{last} rounds" if first < last else f"round {last}"


def _count(solve: SolveHistory) -> str:
    """Say how many iterations a history holds."""
    iterations = count(solve.round)
    return f"{iterations} iteration{'' if iterations == 1 else 's'}"


def _labels_converged(solve: SolveHistory) -> str:
    """Say after how many iterations of a round few labels change."""
    iterations = _settled_after(solve)
    return f"converged after {iterations} iteration{'' if iterations == 1 else 's'}"


def _settled_after(solve: SolveHistory) -> int:
    """Find the last iteration in which more than a thousandth of the labels changed."""
    changing = np.flatnonzero(solve.label_changes > 0.001 * solve.landmarks)
    return int(changing.max()) if len(changing) else 0


def _compare_labels(solves: Sequence[SolveHistory]) -> tuple[ComparedValue, ...]:
    """Set labels as the source prints them beside those of the solves as published.

    solves: last rounds alone, of which row 0 is the first labelled iteration.
    """
    return tuple(
        value
        for solve in solves
        for value in (
            ComparedValue(
                what="share of landmarks on the hull at the first labelled iteration",
                printed=0.82,
                ours=float(solve.on_surface[0] / max(1, solve.landmarks[0])),
                note="of another hull; printed with one camera: 0.34",
            ),
            ComparedValue(
                what="iterations until the labels settle",
                printed=20.0,
                ours=float(_settled_after(solve)),
                note='printed "about twenty"; ours starts from a solved path',
            ),
        )
    )


def _compare_iterations(solves: Sequence[SolveHistory]) -> tuple[ComparedValue, ...]:
    """Set iterations and time as the source prints them beside those of solves as published."""
    by_method = {solve.method.split()[0]: solve for solve in solves}
    found = [
        ComparedValue(
            what=f"iterations of the solve, {name}",
            printed=printed,
            ours=float(count(by_method[name].round)),
            note="stereo; ours starts from a path solved without the CAD model",
        )
        for name, printed in PRINTED_ITERATIONS.items()
        if name in by_method
    ]
    naive = by_method.get("naive")
    if naive is None or naive.seconds[-1] <= 0:
        return tuple(found)
    return tuple(found) + tuple(
        ComparedValue(
            what=f"time of the solve over naive's, {name}",
            unit="%",
            printed=printed,
            ours=float(100 * (by_method[name].seconds[-1] / naive.seconds[-1] - 1)),
            note="at field size: docs/adr/0009",
        )
        for name, printed in PRINTED_EXTRA_TIME.items()
        if name in by_method
    )

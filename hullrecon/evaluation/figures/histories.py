# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How a solve goes: labels by iteration [Ozog2016 Fig. 4.12], cost by iteration and by time [Ozog2016 Fig. 4.13]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hullrecon.evaluation.figures.figure_style import COLOURS, Figure, colour, finished, new_figure, plain_log
from hullrecon.records.iterations import broken, count
from hullrecon.typing import Array, Ints

_NEAR = 0.001  # of its last cost


@dataclass(frozen=True)
class Progress:
    """One method's iterations (k,), rounds one after the other: round, cost, landmarks and those labelled 1, labels changed,
    seconds since the first solve began. printed: one solve as published."""

    method: str
    printed: bool
    round: Ints
    cost: Array
    landmarks: Ints
    on_surface: Ints
    label_changes: Ints
    seconds: Array


def label_frequency(solves: Sequence[Progress]) -> Figure:
    """[Ozog2016 Fig. 4.12]: share of the landmarks with label 1 by iteration, a panel a solve; below, how many labels
    changed."""
    figure, axes = new_figure(4.4 * len(solves) + 0.4, 4.6, 2, len(solves), sharex="col", height_ratios=(3, 2))
    table, words = ["method,round,iteration,landmarks,on_surface,label_changes"], []
    for k, solve in enumerate(solves):
        share = 100 * solve.on_surface / np.maximum(1, solve.landmarks)
        step = np.arange(len(share))
        axes[0, k].plot(*broken(step, share, solve.round), color=COLOURS["maxmix"], linewidth=1.8, marker=".", markersize=4)
        axes[0, k].set_title(_title(solve), fontsize=9)
        axes[0, k].annotate(
            f"starts at {share[0]:.1f} %, ends at {share[-1]:.1f} %",
            (0.97, 0.06),
            xycoords="axes fraction",
            ha="right",
            fontsize=8,
        )
        changed = np.where(solve.label_changes > 0, solve.label_changes, np.nan)
        axes[1, k].bar(step, changed, color=COLOURS["geva"], width=0.8)
        axes[1, k].set(xlabel="iteration" if solve.printed else "iteration, all rounds", yscale="log")
        plain_log(axes[1, k].yaxis)
        for axis in axes[:, k]:
            _mark_rounds(axis, solve.round)
        table += [
            f"{solve.method},{r},{i},{n},{on},{c}"
            for i, (r, n, on, c) in enumerate(
                zip(solve.round, solve.landmarks, solve.on_surface, solve.label_changes, strict=True)
            )
        ]
        words.append(f"{solve.method}: {share[0]:.1f} % to {share[-1]:.1f} %, {_settled(solve)}")
    axes[0, 0].set_ylabel("landmarks on the hull (%)")
    axes[1, 0].set_ylabel("labels changed")
    return finished("label_frequency", figure, table, "Labels by iteration. " + "; ".join(words) + ".")


def cost_history(solves: Sequence[Progress]) -> Figure:
    """[Ozog2016 Fig. 4.13]: cost by iteration and by time. Above the solves as printed, which share one weighting; below ours,
    whose lines break where a round begins: sigmas and landmarks change there, so costs do not compare across the gap."""
    groups = [g for g in ([s for s in solves if s.printed], [s for s in solves if not s.printed]) if g]
    figure, axes = new_figure(9.2, 3.1 * len(groups), len(groups), 2, sharey="row")
    table, words = ["method,round,iteration,seconds,cost"], []
    for row, group in zip(axes, groups, strict=True):
        for solve in group:
            _costs(row, solve)
            rows = enumerate(zip(solve.round, solve.seconds, solve.cost, strict=True))
            table += [f"{solve.method},{r},{k},{t:.3f},{c:.9g}" for k, (r, t, c) in rows]
            words.append(f"{solve.method} {_count(solve)}, {solve.seconds[-1]:.1f} s")
        row[0].set_ylabel(f"{_title(group[0], method=False)}\ncost (half sum of squares)")
        row[0].set_yscale("log")
        plain_log(row[0].yaxis)
        for axis, name, linear in zip(row, ("iteration", "time (s)"), (10.0, 1.0), strict=True):
            if group[0].printed:
                axis.set_xscale("symlog", linthresh=linear)
                axis.xaxis.set_major_formatter("{x:g}")
                axis.set_xlim(left=0)
            axis.set_xlabel(name + ("" if group[0].printed else ", all rounds"))
            axis.legend(fontsize=8, frameon=False, title=f"dot: within {_NEAR:.1%} of its end", title_fontsize=8)
    return finished("cost_history", figure, table, "Cost by iteration and by time. " + "; ".join(words) + ".")


def _costs(row: Any, solve: Progress) -> None:
    """The two curves of one method; a dot where a round's cost comes near its last one."""
    look, name = {"color": colour(solve.method), "linewidth": 1.8}, solve.method.split()[0]
    last = np.array([solve.cost[solve.round == number][-1] for number in solve.round])
    _, near = np.unique(np.where(solve.cost <= (1 + _NEAR) * last, solve.round, 0), return_index=True)
    near = near[solve.cost[near] <= (1 + _NEAR) * last[near]]
    step = np.arange(len(solve.cost), dtype=float)
    for axis, at, said in ((row[0], step, _count(solve)), (row[1], solve.seconds, f"{solve.seconds[-1]:.1f} s")):
        axis.plot(*broken(at, solve.cost, solve.round), label=f"{name}, {said}", **look)
        axis.plot(at[near], solve.cost[near], "o", color=look["color"], markersize=4)


def _title(solve: Progress, method: bool = True) -> str:
    kind = "as printed, one solve" if solve.printed else f"as weighted by us, {solve.round.max()} rounds"
    return f"{solve.method.split()[0]}, {kind}" if method else kind


def _count(solve: Progress) -> str:
    return f"{count(solve.round)} iterations"


def _settled(solve: Progress, share: float = 0.001) -> str:
    """After how many iterations of its last round fewer than that share of the labels change."""
    last = solve.round == solve.round.max()
    restless = np.flatnonzero(solve.label_changes[last] > share * solve.landmarks[last])
    last_one = int(restless.max()) if len(restless) else 0
    return f"settled after {last_one} iterations" + ("" if solve.printed else " of the last round")


def _mark_rounds(axis: Any, rounds: Ints) -> None:
    for k in np.flatnonzero(np.diff(rounds)) + 1:
        axis.axvline(k - 0.5, color="#7b8794", linewidth=0.8, linestyle=":")

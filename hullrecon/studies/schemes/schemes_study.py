# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A binary tree of joins, a graph of submaps over a mission, and submaps that share variables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    RED,
    PublishedFigure,
    draw_ellipse,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.schemes import shared_variables as shared
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits
from hullrecon.studies.submaps.hierarchy import Hierarchy
from hullrecon.studies.submaps.missions import build_submaps
from hullrecon.studies.submaps.sequence import PlainMap, join_next, plain_map
from hullrecon.studies.submaps.worlds import Noise, Survey, simulate_loop
from hullrecon.typing import Array

SQUARE = Survey(leg_m=40.0, leg_spacing_m=10.0, steps_a_scan=10)
LAPS, SEED, LEAVES = 1.5, 1, 8
SIGMAS = 3


@dataclass(frozen=True, kw_only=True)
class Tree:
    """Maps level by level, and the multiplications that each level cost."""

    levels: list[list[PlainMap]]
    efforts: list[float]
    one_by_one: float  # multiplications, each map joined to the one that grows


@dataclass(frozen=True, kw_only=True)
class Moment:
    """The frames of a graph of submaps at a moment of the mission."""

    frames: Array  # (n, 3) x, y m and heading rad
    covariances: Array  # (n, 2, 2) of their places
    loops: int


def study() -> StudyResult:
    """Follow the three schemes on simulated submaps, and compare their costs and sigmas."""
    world = simulate_loop(SQUARE, LAPS, Noise(), SEED)
    submaps = build_submaps(world.log, Limits(), Effort())
    tree, moments = tree_of_joins(submaps[:LEAVES]), graph_over_time(submaps)
    rows = shared.measured(np.random.default_rng(SEED))
    two, one = shared.in_two_submaps(rows), shared.whole(rows)
    sigmas = np.sqrt(np.diag(two.covariance) / np.diag(one.covariance))
    before, after = (float(np.sqrt(np.trace(m.covariances[-1]))) for m in moments[:2])
    return StudyResult(
        figures=(draw_tree(tree), draw_graph(moments), draw_shared(one)),
        compared=(
            ComparedValue(
                what=f"multiplications in a tree over those one by one, {LEAVES} submaps",
                ours=sum(tree.efforts) / tree.one_by_one,
                note="a global map in approximately O(n) time, drawn as a scheme alone",
            ),
            ComparedValue(
                what="sigma of the last frame after the first loop over that before",
                ours=after / before,
                note="ellipses shrink when the loop is closed, drawn alone",
            ),
            ComparedValue(
                what="two submaps beside one estimate, largest difference of a sigma",
                unit="%", printed=0.0,
                ours=100 * float(np.abs(sigmas - 1).max()),
                note="conditionally independent given what they share",
            ),
            ComparedValue(
                what="covariance across the submaps given what they share, largest correlation",
                printed=0.0, ours=correlation_left(one),
            ),
        ),
    )  # fmt: skip


def tree_of_joins(submaps: list[EkfMap]) -> Tree:
    """Join maps two by two, and the same maps one after the other.

    The effort of a level is that of its joins alone.
    """
    # Association draws samples. With the seed anew, a level does not depend on the ones before
    levels, efforts = [[plain_map(built) for built in submaps]], [0.0]
    while len(levels[-1]) > 1:
        effort, rng, last = Effort(), np.random.default_rng(SEED), levels[-1]
        pairs = zip(last[::2], last[1::2], strict=False)
        joined = [join_next(first, second, effort, rng) for first, second in pairs]
        levels.append(joined + ([last[-1]] if len(last) % 2 else []))
        efforts.append(effort.total_multiplications)
    effort, rng, grown = Effort(), np.random.default_rng(SEED), levels[0][0]
    for following in levels[0][1:]:
        grown = join_next(grown, following, effort, rng)
    return Tree(levels=levels, efforts=efforts, one_by_one=effort.total_multiplications)


def graph_over_time(submaps: list[EkfMap]) -> list[Moment]:
    """Add submaps to a graph, and keep some moments of it.

    These are the moments before and after the first loop is found, after the next one, and the end.
    """
    graph = Hierarchy(Effort())
    moments: list[Moment] = []
    last: Moment | None = None
    for built in submaps:
        known = len(graph.loops)
        graph.add(built)
        now = _moment(graph)
        if now.loops > known:
            if not moments and last is not None:
                moments.append(last)
            moments.append(now)
        last = now
    assert last is not None
    return [*moments[:3], last] if len(moments) > 1 else [last, last]


def _moment(graph: Hierarchy) -> Moment:
    """Record the frames of the graph with the covariances of their places in the first one."""
    world = graph.world
    blocks = []
    for k in range(len(world) + 1):
        jacobian = world.relative(0, k)[1] if k else np.zeros((3, len(world.mean)))
        blocks.append((jacobian @ world.covariance @ jacobian.T)[:2, :2])
    return Moment(frames=world.frames(), covariances=np.array(blocks), loops=len(graph.loops))


def correlation_left(found: shared.Normal) -> float:
    """Compute the largest correlation of both submaps' own variables given what they share."""
    # four variables of the first, then those of the second
    own = np.r_[shared.FIRST, shared.SECOND]
    across = found.covariance[np.ix_(own, shared.SHARED)]
    given = np.linalg.inv(found.covariance[np.ix_(shared.SHARED, shared.SHARED)])
    left = found.covariance[np.ix_(own, own)] - across @ given @ across.T
    sigma = np.sqrt(np.diag(left))
    return float(np.abs(left / np.outer(sigma, sigma))[:4, 4:].max())


def draw_tree(tree: Tree) -> PublishedFigure:
    """Draw the maps level by level [Aulinas2011 Fig. 2.3]."""
    figure, axes = new_canvas(9.6, 1.5 * len(tree.levels), len(tree.levels), 1)
    table = ["level,map,landmarks,multiplications_of_level"]
    for level, (maps, effort) in enumerate(zip(tree.levels, tree.efforts, strict=True)):
        axis = axes[level][0]
        for k, joined in enumerate(maps):
            place = (k + 0.5) * LEAVES / len(maps)
            axis.bar(place, len(joined.truth), 0.9 * LEAVES / len(maps), color=COLOURS["maxmix"])
            table.append(f"{level},{k},{len(joined.truth)},{effort:.0f}")
        axis.set(ylabel="landmarks", xticks=[], xlim=(0, LEAVES))
        axis.set_title(f"level {level}: {effort:,.0f} multiplications", fontsize=8, loc="left")
    return finish_figure(
        "tree_of_joins",
        figure,
        table,
        "Eight submaps joined two by two: how many landmarks the maps of each level have.",
    )


def draw_graph(moments: list[Moment]) -> PublishedFigure:
    """Draw the graph of submaps over the mission [Aulinas2011 Fig. 2.4]."""
    figure, axes = new_canvas(9.6, 2.8, 1, len(moments), sharex="all", sharey="all")
    table = ["moment,frame,x_m,y_m,sigma_x_m,sigma_y_m,loops"]
    for number, (axis, moment) in enumerate(zip(axes[0], moments, strict=True)):
        axis.plot(*moment.frames[:, :2].T, ".-", color=INK, lw=0.8)
        for k, (at, block) in enumerate(zip(moment.frames, moment.covariances, strict=True)):
            draw_ellipse(axis, at, block, SIGMAS, RED)
            table.append(
                f"{number},{k},{at[0]:.3f},{at[1]:.3f},{block[0, 0] ** 0.5:.4f},"
                f"{block[1, 1] ** 0.5:.4f},{moment.loops}"
            )
        axis.set_title(f"{len(moment.frames) - 1} submaps, {moment.loops} loops", fontsize=8)
        axis.set(xlabel="x (m)", aspect="equal")
    return finish_figure(
        "graph_of_submaps",
        figure,
        table,
        "Frames of submaps with three-sigma ellipses: before the first loop is closed, after it, "
        "and as more are.",
    )


def draw_shared(found: shared.Normal) -> PublishedFigure:
    """Draw which variables of two submaps depend on each other [Aulinas2011 Fig. 2.5]."""
    figure, axes = new_canvas(9.6, 4.0, 1, 2)
    rows = shared.measured(np.random.default_rng(SEED))
    for a, b, *_ in rows:
        ends = shared.PLACES_M[[shared.NAMES.index(a), shared.NAMES.index(b)]]
        axes[0][0].plot(*ends.T, color=COLOURS["naive"], lw=0.8)
    for group, ink, name in (
        (shared.FIRST, COLOURS["maxmix"], "first submap"),
        (shared.SHARED, RED, "shared"),
        (shared.SECOND, GREEN, "second submap"),
    ):
        axes[0][0].plot(*shared.PLACES_M[group].T, "o", color=ink, label=name)
    for name, at in zip(shared.NAMES, shared.PLACES_M, strict=True):
        axes[0][0].annotate(name, at, xytext=(3, 5), textcoords="offset points", fontsize=8)
    axes[0][0].legend(fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0, 1), ncols=3)
    matrix = np.abs(np.linalg.inv(found.covariance))
    axes[0][1].imshow(matrix > 1e-6, cmap="Greys")
    axes[0][1].set_xticks(range(10), shared.NAMES, fontsize=7)
    axes[0][1].set_yticks(range(10), shared.NAMES, fontsize=7)
    axes[0][1].set_title("information that is not zero", fontsize=9)
    table = ["first,second,information"]
    table += [
        f"{a},{b},{matrix[i, j]:.6g}"
        for i, a in enumerate(shared.NAMES)
        for j, b in enumerate(shared.NAMES)
    ]
    return finish_figure(
        "shared_variables",
        figure,
        table,
        "Two submaps that share a pose and a feature: no information ties what only one has to "
        "what only the other has.",
    )

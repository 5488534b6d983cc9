# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A graph that is solved while the vehicle dives: the square root of its information is updated.

[Ozog2016 1.3.2, 2.3.2] names incremental smoothing as what makes a survey in real time possible. A
new pose adds rows; an orthogonal rotation makes the square root triangular again, from the first
column on that they touch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular

from hullrecon.geometry.poses import stacked
from hullrecon.studies.figure_style import COLOURS, RED, PublishedFigure, finish_figure, new_canvas
from hullrecon.studies.sessions.factors import Factors, Links, State
from hullrecon.studies.sessions.graph import Graph, linear_system, solve, stepped, whole
from hullrecon.studies.sessions.motions import plane_out
from hullrecon.studies.sessions.survey import Session, legs, survey
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array, Ints

SEED, STRETCH_M, DEPTHS_M = 3, (-6.0, 5.0), (1.5, 2.5, 3.5)
RELINEARISE_EVERY = 12  # poses


@dataclass(frozen=True, kw_only=True)
class Progress:
    """How the incremental solver went."""

    state: State
    touched: Ints  # (n,) columns that were made triangular again with each pose
    columns: Ints  # (n,) that there were


class SquareRoot:
    """Triangular square root R of an information matrix, and the right hand side: R x = d."""

    def __init__(self) -> None:
        self.root, self.right = np.zeros((0, 0)), np.zeros(0)

    def add(self, jacobian: Array, residual: Array, columns: int) -> int:
        """Add linearised factors, and make the square root triangular again.

        Parameters
        ----------
        jacobian, residual
            Whitened, (m, columns) and (m,).
        columns
            Number of unknowns from now on. Those that are new come last.

        Returns
        -------
        int
            Columns that were made triangular again.
        """
        grown = np.zeros((columns, columns))
        size = len(self.root)
        grown[:size, :size] = self.root
        right = np.concatenate([self.right, np.zeros(columns - size)])
        first = int(np.flatnonzero(np.abs(jacobian).max(axis=0) > 0)[0])
        stack = np.column_stack(
            [np.vstack([grown[first:, first:], jacobian[:, first:]]),
             np.concatenate([right[first:], -residual])]
        )  # fmt: skip
        turned = qr(stack, mode="r")[0][: columns - first]
        grown[first:, first:], right[first:] = np.triu(turned[:, :-1]), turned[:, -1]
        self.root, self.right = grown, right
        return columns - first

    def step(self) -> Array:
        """Solve for the step (columns,) from the state at which the factors were linearised."""
        return np.asarray(solve_triangular(self.root, self.right))


def arrivals(session: Session) -> tuple[Graph, Ints, Ints]:
    """Order a graph's columns as its poses and planes come while the vehicle dives.

    Returns
    -------
    Graph
        The graph of the whole session.
    Ints
        Its columns in the order in which they come.
    Ints
        (n,) columns that have come with each pose.
    """
    graph = whole(session.factors, session.start)
    of_poses, of_planes, _ = graph.starts()
    order, ends = [], []
    for k in range(len(session.truth)):
        order += list(of_poses[k] + np.arange(6))
        for plane in np.flatnonzero(session.seen_from == k):
            order += list(of_planes[plane] + np.arange(3))
        ends.append(len(order))
    return graph, np.array(order), np.array(ends)


def smooth(session: Session) -> Progress:
    """Solve a session pose by pose, and linearise it anew every RELINEARISE_EVERY poses."""
    graph, order, ends = arrivals(session)
    odometry = next(table for table in session.factors if isinstance(table, Links))
    back = np.argsort(order)  # from the order of arrival to the graph's columns
    state, root = session.start, SquareRoot()  # what factors are linearised at, and their root
    touched = []
    for k, end in enumerate(ends):
        estimate = _estimate(graph, state, root, back)
        if k and k % RELINEARISE_EVERY == 0:
            state, root = estimate, SquareRoot()
            _add(graph, state, _rows(graph, session, 0, k), order, int(ends[k - 1]), root)
        if k:
            state = _with_pose(state, estimate, odometry, session, k)
        new = _rows(graph, session, k, k + 1)
        touched.append(_add(graph, state, new, order, int(end), root))
    return Progress(
        state=_estimate(graph, state, root, back), touched=np.array(touched), columns=ends
    )


def _estimate(graph: Graph, state: State, root: SquareRoot, back: Ints) -> State:
    """Move a state by the step that its square root gives. What has not come yet stays.

    back: for each column of the graph, its place in the order of arrival.
    """
    step = np.zeros(len(back))
    step[: len(root.right)] = root.step() if len(root.right) else 0.0
    return stepped(graph, state, step[back])


def _with_pose(state: State, estimate: State, odometry: Links, session: Session, k: int) -> State:
    """Set pose k by odometry from the estimate of the one before, and its plane by what it sees."""
    count = len(state.poses)
    pose = estimate.poses[k - 1] @ odometry.measured[k - 1]
    poses = stacked([state.poses[:k], pose, state.poses[np.arange(k + 1, count)]])
    planes = state.planes.copy()
    seen = np.flatnonzero(session.seen_from == k)
    from_start = session.start.poses[np.full(len(seen), k)]
    if len(seen):
        # the start has the plane as it was seen from the start's pose
        local = plane_out(from_start.inverse(), session.start.planes[seen])
        planes[seen] = plane_out(pose[np.zeros(len(seen), int)], local)
    return State(poses=poses, planes=planes)


def _rows(graph: Graph, session: Session, first: int, last: int) -> list[Factors]:
    """Select the factors that come with poses `first` to `last`, the latter excluded.

    A factor comes with the last of its poses, or of those that see its planes.
    """
    out = []
    for table in graph.factors:
        comes = table.poses.max(axis=1)
        if table.planes.shape[1]:
            comes = np.maximum(comes, session.seen_from[table.planes].max(axis=1))
        out.append(table.take((comes >= first) & (comes < last)))
    return [table for table in out if len(table)]


def _add(
    graph: Graph, state: State, tables: list[Factors], order: Ints, columns: int, root: SquareRoot
) -> int:
    """Linearise factors at a state, and add them to the square root. Returns columns touched.

    columns: number of the columns, in order of arrival, that have come.
    """
    part = Graph(factors=tuple(tables), live_poses=graph.live_poses, live_planes=graph.live_planes)
    jacobian, residual = linear_system(part, state)
    return root.add(jacobian.toarray()[:, order[:columns]], residual, columns)


def study() -> StudyResult:
    """Solve a session pose by pose, and beside it in one batch."""
    session = survey(legs(*STRETCH_M, DEPTHS_M), np.random.default_rng(SEED))
    going = smooth(session)
    batch = solve(whole(session.factors, session.start), session.start).state
    off = np.linalg.norm(going.state.poses.translation - batch.poses.translation, axis=1)
    share = going.touched / going.columns
    return StudyResult(
        figures=(draw(going),),
        compared=(
            ComparedValue(
                what="largest distance of a pose to the batch solution",
                unit="mm", ours=1e3 * float(off.max()),
                note=f"linear anew every {RELINEARISE_EVERY} poses",
            ),
            ComparedValue(
                what="columns made triangular again with a pose, median share",
                unit="%", ours=100 * float(np.median(share)),
                note="all of them in a batch; links across legs reach far back",
            ),
        ),
    )  # fmt: skip


def draw(going: Progress) -> PublishedFigure:
    """Draw how many columns of the square root each pose touches, beside how many there are."""
    figure, axes = new_canvas(7.0, 3.0)
    axis, number = axes[0][0], np.arange(len(going.touched))
    axis.plot(number, going.columns, color=RED, label="all columns, as in a batch")
    axis.plot(number, going.touched, ".-", color=COLOURS["maxmix"], lw=0.7, label="columns touched")
    axis.set(xlabel="pose", ylabel="columns")
    axis.legend(fontsize=8, frameon=False)
    rows = zip(number, going.touched, going.columns, strict=True)
    return finish_figure(
        "columns_touched",
        figure,
        ["pose,touched,columns", *(f"{k},{t},{c}" for k, t, c in rows)],
        "Columns of the square root that each new pose touches: few along a leg, many where images "
        "of an earlier leg are found again.",
    )

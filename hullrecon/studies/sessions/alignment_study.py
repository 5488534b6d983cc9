# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Three sessions in one frame, by anchors and without [Ozog2016 1.3.2, 2.4.2]."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon.evaluation.trajectory import rms_length
from hullrecon.geometry.poses import Poses, exp, stacked
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.sessions.anchors import (
    Anchored,
    common_frame_derivative,
    in_common_frame,
    join,
    laid_on,
    merged,
    path_errors,
)
from hullrecon.studies.sessions.factors import Levels, State
from hullrecon.studies.sessions.graph import (
    Graph,
    Solution,
    covariance,
    information,
    pose_covariances,
    solve,
    whole,
)
from hullrecon.studies.sessions.motions import errors
from hullrecon.studies.sessions.survey import (
    ANCHOR_SIGMA,
    KNOWN_SIGMA,
    LINK_SHARE,
    Session,
    encounters,
    legs,
    survey,
    through_anchors,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array

DRAWS = 4  # of the errors of all sensors
STRETCHES_M = ((-13.0, -2.0), (-5.0, 6.0), (3.0, 14.0))
WAYS = ("laid on by the first link", "poses in one frame", "anchors")
NAMES, INKS = "ABC", (COLOURS["maxmix"], COLOURS["geva"], GREEN)


@dataclass(frozen=True, kw_only=True)
class Aligned:
    """The sessions aligned in one way."""

    state: State  # in the common frame, no anchors
    first: Solution | None = None  # with the first link between each two sessions
    last: Solution | None = None  # with all


@dataclass(frozen=True, kw_only=True)
class Draw:
    """Sessions with one draw of errors, aligned in each way."""

    sessions: list[Session]
    ways: dict[str, Aligned]
    joint: Anchored  # solved

    @property
    def truth(self) -> Poses:
        """Put the true paths of all sessions one after the other."""
        return stacked([s.truth for s in self.sessions])

    def error_m(self, way: str) -> float:
        """Compute how far the paths are off the truth, root mean square."""
        return rms_length(path_errors(self.ways[way].state.poses, self.truth)[:, :3])


def study() -> StudyResult:
    """Align three sessions in three ways, and convert what anchors give to the common frame."""
    draws = [align(simulate(seed), seed) for seed in range(DRAWS)]
    losses, nees = np.transpose([conversion(draw) for draw in draws])
    heads = ("sessions put together", "off the truth, m", "steps, first link", "steps, all links")
    return StudyResult(
        figures=(draw_information(), draw_paths(draws[0])),
        heads=heads,
        rows=tuple(row(way, draws) for way in WAYS),
        compared=(
            *(
                ComparedValue(
                    what=f"solver's steps from unaligned sessions to the end, {way}",
                    ours=mean_steps(way, draws)[0],
                    note="fewer with anchors, says the source",
                )
                for way in WAYS[1:]
            ),
            ComparedValue(
                what="sigmas in the common frame, (2.9) beside (2.8): median difference",
                unit="%",
                printed=0.0,
                ours=100 * float(np.median(losses)),
                note="no information is lost, says the source; only first poses of sessions, "
                "whose priors are dropped, come out less sure",
            ),
            ComparedValue(
                what="squared error over the covariance (2.8), mean of six numbers",
                ours=float(np.mean(nees)),
                note="6 where the covariance holds",
            ),
        ),
    )


def simulate(seed: int) -> list[Session]:
    """Survey three stretches that overlap by some metres."""
    rng = np.random.default_rng(seed)
    return [survey(legs(*stretch), rng) for stretch in STRETCHES_M]


def anchored(sessions: list[Session], seed: int, share: float = LINK_SHARE) -> Anchored:
    """Put the sessions, each solved alone, into one graph with links between neighbours.

    share: of the overlapping images of two sessions that are linked.
    """
    rng = np.random.default_rng([seed, 1])
    alone = [solve(whole(s.factors, s.start), s.start).state for s in sessions]
    frames = stacked([sessions[0].frame, exp(np.zeros((len(sessions) - 1, 6)))])
    sigma = np.tile(ANCHOR_SIGMA, (len(sessions), 1))
    sigma[0] = KNOWN_SIGMA
    joint = join(alone, [s.factors for s in sessions], frames, sigma)
    across = []
    for k in range(len(sessions) - 1):
        pairs, links = encounters(sessions[k].truth, sessions[k + 1].truth, rng, share)
        across.append(through_anchors(links, pairs, (k, k + 1), joint.first_pose[[k, k + 1]]))
    return replace(joint, across=tuple(across))


def align(sessions: list[Session], seed: int) -> Draw:
    """Align unaligned sessions by the first links alone, in one frame, and by anchors."""
    joint = anchored(sessions, seed)
    # First by one link between each two sessions, then from there by all
    few = replace(joint, across=tuple(table.take(slice(0, 1)) for table in joint.across))
    first = solve(few.graph(), few.state)
    last = solve(joint.graph(), first.state)
    solved = replace(joint, state=last.state)
    # sessions moved as a whole, so that they agree with these few links, and nothing solved
    laid = replace(joint, state=laid_on(few))
    # the same two solves with all poses in one frame
    plain = solve(*one_frame(few))
    plain_last = solve(one_frame(joint)[0], plain.state)
    ways = (
        Aligned(state=in_common_frame(laid)),
        Aligned(state=plain_last.state, first=plain, last=plain_last),
        Aligned(state=in_common_frame(solved), first=first, last=last),
    )
    return Draw(sessions=sessions, ways=dict(zip(WAYS, ways, strict=True)), joint=solved)


def one_frame(joint: Anchored) -> tuple[Graph, State]:
    """Take all sessions as if their frames were the first one's [Ozog2016 1.3.2.1]."""
    anchors = joint.state.poses[np.zeros(joint.sessions, int)]
    rest = joint.state.poses[np.arange(joint.sessions, len(joint.anchor))]
    return merged(
        replace(joint, state=State(poses=stacked([anchors, rest]), planes=joint.state.planes))
    )


def conversion(draw: Draw) -> tuple[float, float]:
    """Compare the covariance of poses by (2.8) with that of the merged graph (2.9), and errors.

    Returns the median relative difference of sigmas, and the mean NEES by (2.8).
    """
    joint = draw.joint
    by = common_frame_derivative(joint)
    graph, state = merged(joint)
    own, other = (
        pose_covariances(graph, dense)
        for dense in (by @ covariance(joint.graph(), joint.state) @ by.T, covariance(graph, state))
    )
    sigma, without = (np.sqrt(np.diagonal(c, axis1=1, axis2=2)) for c in (own, other))
    error, by_error = errors(draw.truth, state.poses)
    spread = by_error @ own @ by_error.swapaxes(1, 2)
    nees = np.einsum("ni,nij,nj->n", error, np.linalg.inv(spread), error)
    return float(np.median(np.abs(without / sigma - 1))), float(nees.mean())


def mean_steps(way: str, draws: list[Draw]) -> tuple[float, float]:
    """Average the solver's iterations over draws: with the first links, and from there with all.

    way: one of WAYS.
    """
    ways = [draw.ways[way] for draw in draws]
    return (
        float(np.mean([w.first.iterations for w in ways if w.first])),
        float(np.mean([w.last.iterations for w in ways if w.last])),
    )


def row(way: str, draws: list[Draw]) -> tuple[str, ...]:
    """Write one way's error and iterations, over all draws, as a row of the table."""
    off = float(np.sqrt(np.mean([draw.error_m(way) ** 2 for draw in draws])))
    solved = draws[0].ways[way].first is not None
    steps = (
        f"{mean:.1f}" if solved else "" for mean in (mean_steps(way, draws) if solved else (0, 0))
    )
    return (way, f"{off:.3f}", *steps)


def rank(matrix: Array) -> int:
    """Compute the rank of an information matrix whose columns are scaled alike."""
    scale = np.sqrt(np.diag(matrix))
    return int(np.linalg.matrix_rank(matrix / np.outer(scale, scale), tol=1e-9, hermitian=True))


def draw_information() -> PublishedFigure:
    """Draw the information matrices of two short sessions before and after they meet."""
    rng = np.random.default_rng(0)
    short = [survey(legs(x, x + 3, (2.0,)), rng, planes=False) for x in (-2.0, 0.0)]
    # depth and level would determine the frames in part: poses and links alone, as printed
    bare = [
        replace(s, factors=tuple(f for f in s.factors if not isinstance(f, Levels))) for s in short
    ]
    joint = anchored(bare, 0, share=1.0)
    apart = replace(joint, across=())
    grids = {
        "one frame, before": one_frame(apart),
        "one frame, after": one_frame(joint),
        "anchors, before": (apart.graph(), joint.state),
        "anchors, after": (joint.graph(), joint.state),
    }
    figure, axes = new_canvas(9.6, 2.9, 1, 4)
    table, compared = ["frame,columns,rank"], []
    for axis, (name, (graph, state)) in zip(axes[0], grids.items(), strict=True):
        dense = information(graph, state).toarray()
        found = rank(dense)
        axis.spy(np.abs(dense) > 1e-9, markersize=2, color=INK)
        axis.set_title(f"{name}: rank {found} of {len(dense)}", fontsize=8)
        axis.set(xticks=[], yticks=[])
        table.append(f"{name},{len(dense)},{found}")
        compared.append(
            ComparedValue(
                what=f"rank that is missing, {name}",
                ours=float(len(dense) - found),
                note="low rank, says the source" if name == "one frame, before" else "full rank",
            )
        )
    return finish_figure(
        "information_matrices",
        figure,
        table,
        "The information of two sessions before and after they meet: poses in one frame leave the "
        "second session free before, anchors never.",
        tuple(compared),
    )


def draw_paths(draw: Draw) -> PublishedFigure:
    """Draw the sessions before they are aligned, and in each way after."""
    truth = draw.truth
    raw = stacked([s.start.poses for s in draw.sessions])
    ends = np.cumsum([0, *(len(s.truth) for s in draw.sessions)])
    figure, axes = new_canvas(9.6, 6.0, 2, 2)
    table = ["way,session,x_m,y_m,z_m"]
    drawn = {"each in its own frame": raw, **{n: one.state.poses for n, one in draw.ways.items()}}
    for axis, (name, poses) in zip([*axes[0], *axes[1]], drawn.items(), strict=True):
        axis.plot(*truth.translation[:, :2].T, ".", color=COLOURS["naive"], ms=2, label="truth")
        for k, ink in enumerate(INKS):
            at = poses.translation[ends[k] : ends[k + 1]]
            axis.plot(*at[:, :2].T, "-", color=ink, lw=1, label=f"session {NAMES[k]}")
            table += [f"{name},{NAMES[k]},{x:.3f},{y:.3f},{z:.3f}" for x, y, z in at]
        axis.set_title(name, fontsize=9)
        axis.set(xlabel="x (m)", ylabel="y (m)")
    axes[0][0].legend(fontsize=7, frameon=False)
    return finish_figure(
        "sessions_aligned",
        figure,
        table,
        "Three sessions seen from above: each in the frame of its own start, laid on each other by "
        "the first link, solved as if all frames were one, and by anchors.",
    )

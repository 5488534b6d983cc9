# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A map that forgets nodes session by session, beside one that keeps all [Ozog2016 2.5]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.evaluation.trajectory import rms_length
from hullrecon.geometry.poses import Poses, exp, stacked
from hullrecon.studies.figure_style import (
    COLOURS,
    INK,
    RED,
    PublishedFigure,
    draw_ellipse,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.sessions.anchors import join, laid_on, merged, path_errors
from hullrecon.studies.sessions.factors import Links, State
from hullrecon.studies.sessions.graph import (
    Graph,
    compacted,
    covariance,
    pose_covariances,
    solve,
    whole,
)
from hullrecon.studies.sessions.motions import errors
from hullrecon.studies.sessions.sparsify import (
    Candidates,
    Neighbourhood,
    choose_nodes,
    remove_nodes,
)
from hullrecon.studies.sessions.survey import (
    ANCHOR_SIGMA,
    KNOWN_SIGMA,
    Session,
    encounters,
    legs,
    survey,
    through_anchors,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array, Ints

SEED = 0
STARTS_M = (-10.0, -5.0, 0.0, 3.0, -8.0, -2.0, 2.0, -6.0)  # of eight sessions, as before a ship
LENGTH_M, NODE_M, LEGS_M = 7.0, 0.5, (1.5, 2.5)
DAY_S = 86400.0
SALIENT = 0.35  # least saliency of a key frame; of the texture that the hull has here
TIED_BY = 0.35  # share of the overlapping images of two sessions that are linked
PERCENT = (5, 50, 95)


@dataclass(frozen=True, kw_only=True)
class Map:
    """All sessions so far in one frame."""

    graph: Graph
    state: State
    number: Ints  # (n,) of each pose, counted through all sessions
    truth: Poses  # (n) true global_from_vehicle
    seer: Ints  # (p,) of each plane, the number of the pose that sees it


@dataclass(frozen=True, kw_only=True)
class SessionResult:
    """Both maps after a session, and how the small one differs at the nodes it has."""

    nodes: tuple[int, int]  # small, full
    factors: tuple[int, int]
    removed: float  # share of this session's nodes
    divergence: Array  # (k,) nats
    position_m: Array  # (k,)
    attitude_rad: Array  # (k,)
    log_ratio: Array  # (k,) of the determinants, small over full
    error_m: tuple[float, float]  # off the truth, root mean square of the nodes of the small map


def study() -> StudyResult:
    """Merge eight sessions with and without removing nodes."""
    steps, small, full = many_sessions()
    variants = one_session()
    return StudyResult(
        figures=(draw_sizes(steps), draw_differences(steps), draw_ellipses(small, full)),
        heads=("nodes of a session removed", "largest sigma's error, %", "path moved, mm"),
        rows=tuple(
            (name, f"{100 * sigma:.3g}", f"{1e3 * moved:.3g}")
            for name, (sigma, moved) in variants.items()
        ),
        compared=compare(steps, variants),
    )


def compare(
    steps: list[SessionResult], variants: Mapping[str, tuple[float, float]]
) -> tuple[ComparedValue, ...]:
    """Compare the maps after the last session with what the source says.

    variants: as of `one_session`.
    """
    last = steps[-1]
    return (
        ComparedValue(
            what="nodes removed after a session, mean from the second on",
            unit="%",
            printed=95.0,
            ours=100 * float(np.mean([step.removed for step in steps[1:]])),
            note="approximately; poses here are half a metre apart, at sea some 0.2 m",
        ),
        ComparedValue(
            what="position beside the full graph's after eight sessions, median",
            unit="m",
            ours=float(np.median(last.position_m)),
            note="well within a metre, over kilometres",
        ),
        ComparedValue(
            what="nodes and factors after eight sessions, full over small graph",
            ours=(last.nodes[1] + last.factors[1]) / (last.nodes[0] + last.factors[0]),
            note="bounded by the size of the hull; without removal no real time after session 3",
        ),
        ComparedValue(
            what="log ratio of the determinants, small over full, median after eight sessions",
            ours=float(np.median(last.log_ratio)),
            note="drawn alone; above zero the small graph is less sure than it might be",
        ),
        ComparedValue(
            what="largest relative error of a sigma, one factor of all neighbours",
            unit="%",
            printed=0.0,
            ours=100 * variants["one factor of all neighbours"][0],
            note="exact at the state of linearisation",
        ),
    )


def many_sessions() -> tuple[list[SessionResult], Map, Map]:
    """Merge all sessions into a small map and a full one, with the same measurements."""
    rng = np.random.default_rng(SEED)
    places: list[Neighbourhood] = []
    small = full = None
    steps = []
    for k, start in enumerate(STARTS_M):
        session = survey(legs(start, start + LENGTH_M, LEGS_M, NODE_M), rng)
        if small is None or full is None:
            small = full = first_map(session)
        else:
            pairs, links = encounters(small.truth, session.truth, rng, TIED_BY)
            both = np.column_stack([small.number[pairs[:, 0]], pairs[:, 1]])
            first = len(full.number)
            small = add(small, session, links, pairs, first)
            full = add(full, session, links, both, first)
        small, gone = forget(small, places, len(session.truth), k)
        steps.append(compare_maps(small, full, gone))
    assert small is not None
    assert full is not None
    return steps, small, full


def first_map(session: Session) -> Map:
    """Solve a session and put it into the common frame."""
    alone = solve(whole(session.factors, session.start), session.start).state
    joint = join([alone], [session.factors], session.frame, KNOWN_SIGMA[None])
    graph, state = merged(joint)
    numbers = np.arange(len(session.truth))
    return Map(
        graph=graph, state=state, number=numbers, truth=session.truth, seer=session.seen_from
    )


def add(known: Map, session: Session, links: Links, pairs: Ints, first: int) -> Map:
    """Align a session with a map by links between them, and merge it into the map.

    Parameters
    ----------
    known
        The map of the sessions before.
    session
        The new session.
    links, pairs
        Links between poses of the map and of the session, as of `encounters`.
    first
        Number of the session's first pose, counted through all sessions.
    """
    alone = solve(whole(session.factors, session.start), session.start).state
    joint = join(
        [known.state, alone],
        [known.graph.factors, session.factors],
        exp(np.zeros((2, 6))),
        np.stack([KNOWN_SIGMA, ANCHOR_SIGMA]),
    )
    joint = replace(joint, across=(through_anchors(links, pairs, (0, 1), joint.first_pose),))
    joint = replace(joint, state=laid_on(joint))
    joint = replace(joint, state=solve(joint.graph(), joint.state).state)
    graph, state = merged(joint)
    return Map(
        graph=graph,
        state=state,
        number=np.concatenate([known.number, first + np.arange(len(session.truth))]),
        truth=stacked([known.truth, session.truth]),
        seer=np.concatenate([known.seer, first + session.seen_from]),
    )


def forget(known: Map, places: list[Neighbourhood], new: int, day: int) -> tuple[Map, float]:
    """Remove nodes of a map by Algorithm 2, and measure the share removed of the last session's.

    Parameters
    ----------
    known
        The map.
    places
        Places of the hull with the views kept so far, which are updated.
    new
        Number of the last session's poses, which are the map's last ones.
    day
        Number of the last session, of which there is one a day.
    """
    nodes = known.number[-new:]
    candidates = Candidates(
        nodes=nodes,
        places=known.state.poses.translation[-new:],
        times_s=np.asarray(DAY_S * day + NODE_M / 0.3 * np.arange(new)),
        salient=saliency(known.truth.translation[-new:]) > SALIENT,
    )
    gone = choose_nodes(places, candidates)
    poses = np.flatnonzero(np.isin(known.number, gone))
    planes = np.flatnonzero(np.isin(known.seer, gone))
    graph = remove_nodes(known.graph, known.state, poses.tolist(), planes.tolist())
    small, state = compacted(graph, known.state)
    return (
        Map(
            graph=small,
            state=state,
            number=known.number[graph.live_poses],
            truth=known.truth[graph.live_poses],
            seer=known.seer[graph.live_planes],
        ),
        float(np.isin(nodes, gone).mean()),
    )


def saliency(places: Array) -> Array:
    """Simulate the texture of the hull at places (n, 3) m, 0 to 1, the same in all sessions."""
    x, z = places[:, 0], places[:, 2]
    return np.asarray(0.5 + 0.25 * (np.sin(1.3 * x + 0.7 * z) + np.cos(0.6 * x - 1.9 * z)))


def compare_maps(small: Map, full: Map, removed: float) -> SessionResult:
    """Compare both maps at the poses of the small one [Ozog2016 2.5.5].

    removed: share of the last session's nodes that the small one lost.
    """
    here = solve(small.graph, small.state).state.poses
    kept = np.isin(full.number, small.number)
    there = full.state.poses[kept]
    small_spread = pose_covariances(small.graph, covariance(small.graph, small.state))
    full_spread = pose_covariances(full.graph, covariance(full.graph, full.state))[kept]
    off = errors(there, here)[0]
    by = errors(there, there)[1]
    in_pose = [by @ spread @ by.swapaxes(1, 2) for spread in (small_spread, full_spread)]
    logs = [np.linalg.slogdet(spread)[1] for spread in in_pose]
    turned = _euler(here) - _euler(there)
    truth = small.truth
    return SessionResult(
        nodes=(small.graph.nodes, full.graph.nodes),
        factors=(small.graph.factor_count, full.graph.factor_count),
        removed=removed,
        divergence=divergence(off, in_pose[0], in_pose[1]),
        position_m=np.linalg.norm(here.translation - there.translation, axis=1),
        attitude_rad=np.linalg.norm((turned + np.pi) % (2 * np.pi) - np.pi, axis=1),
        log_ratio=logs[0] - logs[1],
        error_m=(_rms(here, truth), _rms(there, truth)),
    )


def divergence(off: Array, approximate: Array, exact: Array) -> Array:
    """Compute the Kullback-Leibler divergence (k,), nats, of approximate from exact Gaussians.

    off: (k, 6) differences of their means. approximate, exact: (k, 6, 6) covariances.
    """
    back = np.linalg.inv(approximate)
    logs = np.linalg.slogdet(approximate)[1] - np.linalg.slogdet(exact)[1]
    trace = np.trace(back @ exact, axis1=1, axis2=2)
    return np.asarray(
        0.5 * (trace + np.einsum("ni,nij,nj->n", off, back, off) - off.shape[1] + logs)
    )


def one_session() -> dict[str, tuple[float, float]]:
    """Remove three of four poses of one session in four ways.

    By way: the largest relative error of a sigma, and how far the path moves when it is solved
    again, m.
    """
    session = survey(legs(-4.0, 4.0, LEGS_M, 1.0), np.random.default_rng(SEED))
    graph = whole(session.factors, session.start)
    state = solve(graph, session.start).state
    exact = pose_covariances(graph, covariance(graph, state))
    poses = [k for k in range(len(session.truth)) if k % 4]
    planes = np.flatnonzero(np.isin(session.seen_from, poses)).tolist()
    found = {}
    for name, tree, at_root in (
        ("one factor of all neighbours", False, True),
        ("one factor, linear in the world", False, False),
        ("along a Chow-Liu tree", True, True),
        ("along a tree, linear in the world", True, False),
    ):
        less = remove_nodes(graph, state, poses, planes, tree=tree, at_root=at_root)
        spread = pose_covariances(less, covariance(less, state))
        sigma = np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
        true = np.sqrt(np.diagonal(exact[less.live_poses], axis1=1, axis2=2))
        again = solve(less, state).state.poses[less.live_poses]
        way = np.linalg.norm(again.translation - state.poses.translation[less.live_poses], axis=1)
        found[name] = (float(np.abs(sigma / true - 1).max()), float(way.max()))
    return found


def draw_sizes(steps: list[SessionResult]) -> PublishedFigure:
    """Draw nodes and factors of both maps over the sessions [Ozog2016 Fig. 2.16]."""
    figure, axes = new_canvas(7.0, 3.2, 1, 2)
    number = np.arange(1, len(steps) + 1)
    table = ["session,nodes_small,nodes_full,factors_small,factors_full,removed"]
    for axis, name in zip(axes[0], ("nodes", "factors"), strict=True):
        for k, (ink, label) in enumerate(((COLOURS["maxmix"], "nodes removed"), (RED, "full"))):
            axis.plot(number, [getattr(s, name)[k] for s in steps], "o-", color=ink, label=label)
        axis.set(xlabel="session", ylabel=name, ylim=(0, None))
    axes[0][0].legend(fontsize=8, frameon=False)
    for session, s in zip(number, steps, strict=True):
        table.append(
            f"{session},{s.nodes[0]},{s.nodes[1]},{s.factors[0]},{s.factors[1]},{s.removed:.4f}"
        )
    return finish_figure(
        "graph_complexity",
        figure,
        table,
        "The graph grows with the sessions unless nodes are removed; then with the hull that has "
        "been seen.",
    )


def draw_differences(steps: list[SessionResult]) -> PublishedFigure:
    """Draw how the small map differs from the full one [Ozog2016 Figs 2.19, 2.20]."""
    figure, axes = new_canvas(9.6, 5.6, 2, 2)
    number = np.arange(1, len(steps) + 1)
    table = ["measure,session,low,median,high"]
    for axis, (name, label, factor) in zip(
        [*axes[0], *axes[1]],
        (
            ("position_m", "position (mm)", 1e3),
            ("attitude_rad", "attitude (mrad)", 1e3),
            ("divergence", "divergence (nats)", 1.0),
            ("log_ratio", "log ratio of determinants", 1.0),
        ),
        strict=True,
    ):
        low, middle, high = np.transpose([np.percentile(getattr(s, name), PERCENT) for s in steps])
        axis.fill_between(number, factor * low, factor * high, color=COLOURS["maxmix"], alpha=0.2)
        axis.plot(number, factor * middle, "o-", color=COLOURS["maxmix"])
        axis.set(xlabel="session", ylabel=label)
        table += [
            f"{name},{k},{a:.6g},{b:.6g},{c:.6g}"
            for k, a, b, c in zip(number, low, middle, high, strict=True)
        ]
    return finish_figure(
        "sparsified_beside_full",
        figure,
        table,
        "The map with nodes removed beside the full one, at the poses that both have: median, and "
        "from 5 to 95 %.",
    )


def draw_ellipses(small: Map, full: Map) -> PublishedFigure:
    """Draw three-sigma ellipses along and across the hull [Ozog2016 Fig. 2.21]."""
    figure, axes = new_canvas(9.0, 3.4)
    axis, table = axes[0][0], ["map,x_m,y_m,sigma_1_m,sigma_2_m"]
    kept = np.isin(full.number, small.number)
    for name, known, mask, ink in (
        ("full", full, kept, RED),
        ("small", small, np.ones(len(small.number), bool), COLOURS["maxmix"]),
    ):
        spread = pose_covariances(known.graph, covariance(known.graph, known.state))[mask, :2, :2]
        for at, block in zip(known.state.poses.translation[mask], spread, strict=True):
            draw_ellipse(axis, at, block, 3, ink, 0.9)
            low, high = np.sqrt(np.linalg.eigvalsh(block))
            table.append(f"{name},{at[0]:.3f},{at[1]:.3f},{low:.5f},{high:.5f}")
        axis.plot([], [], color=ink, label=name)
    axis.plot(*small.truth.translation[:, :2].T, ".", ms=2, color=INK, label="truth")
    axis.set(xlabel="x (m)", ylabel="y (m)")
    axis.legend(fontsize=8, frameon=False)
    return finish_figure(
        "ellipses_of_both",
        figure,
        table,
        "Three-sigma ellipses of the poses that are kept, by the full graph and by the small one.",
    )


def _rms(poses: Poses, truth: Poses) -> float:
    """Compute the rms distance, m, of poses from the truth."""
    return rms_length(path_errors(poses, truth)[:, :3])


def _euler(poses: Poses) -> Array:
    """Compute roll, pitch, yaw (n, 3) rad of poses."""
    turns: Rotation = poses.rotation
    return np.asarray(turns.as_euler("xyz"))

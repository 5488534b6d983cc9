# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Ranges of beams too few for a plane, held to planes known already [Ozog2016 2.3.4.3, Fig. 2.7].

Near the surface only two of the DVL's beams come back. They lie on a line and make no plane, but
tell how far the planes of the leg below are.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.studies.figure_style import COLOURS, RED, PublishedFigure, finish_figure, new_canvas
from hullrecon.studies.sessions.anchors import path_errors
from hullrecon.studies.sessions.factors import Beams, Factors, Links, PlanePairs, Sightings
from hullrecon.studies.sessions.graph import solve, whole
from hullrecon.studies.sessions.survey import Session, legs, ranges, survey
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array

FROM_M, TO_M, BELOW_M, SURFACED_M = -9.0, 9.0, 1.6, 0.7
# unit, in the vehicle's frame, of the beams that come back
RAYS = np.array([[0.75**0.5, 0.5, 0.0], [0.75**0.5, -0.5, 0.0]])
RANGE_SIGMA_M = 0.02
BEND_M = 0.04  # by how much the hull leaves the plane of the leg below, from its curvature
DRAWS = 12


@dataclass(frozen=True, kw_only=True)
class Drift:
    """How far surfaced poses are off those below towards the hull, m, by draw and pose."""

    without: Array  # (draws, n)
    held: Array


def surfaced(rng: np.random.Generator) -> tuple[Session, int]:
    """Survey one leg under water with planes, and back along the surface without.

    Returns the session, and how many poses are under water.
    """
    session = survey(legs(FROM_M, TO_M, (BELOW_M, SURFACED_M)), rng)
    count = len(session.truth) // 2
    kept: list[Factors] = []
    for table in session.factors:
        if isinstance(table, (Sightings, PlanePairs)):
            ends = session.seen_from[table.planes].max(axis=1)
            kept.append(table.take(ends < count))
        elif isinstance(table, Links) and (np.diff(table.poses, axis=1) > 1).any():
            kept.append(table.take(table.poses.max(axis=1) < count))  # no image at the surface
        else:
            kept.append(table)
    return Session(
        frame=session.frame, truth=session.truth, start=session.start,
        factors=tuple(table for table in kept if len(table)), seen_from=session.seen_from,
    ), count  # fmt: skip


def beams(session: Session, count: int, rng: np.random.Generator) -> Beams:
    """Measure the ranges of two beams of each surfaced pose, and pair each with a plane below.

    That is the plane seen from the pose nearest to where the beam meets the hull. The poses
    from `count` on are surfaced.
    """
    poses = np.repeat(np.arange(count, len(session.truth)), len(RAYS))
    ray = np.tile(RAYS, (len(session.truth) - count, 1))
    where = session.truth[poses]
    way = where.rotation.apply(ray)
    length = ranges(where.translation, way)
    below = np.flatnonzero(session.seen_from < count)
    met = where.translation + length[:, None] * way
    seers = session.truth.translation[session.seen_from[below]]
    nearest = below[np.argmin(np.linalg.norm(seers - met[:, None], axis=2), axis=1)]
    return Beams(
        poses=poses[:, None], planes=nearest[:, None], ray=ray,
        measured_m=length + RANGE_SIGMA_M * rng.standard_normal(len(poses)),
        sigma_m=float(np.hypot(RANGE_SIGMA_M, BEND_M)),
    )  # fmt: skip


def towards_hull(poses: Poses, truth: Poses) -> Array:
    """Compute how far poses are off the truth towards the hull (n,) m, which is ahead of them."""
    return path_errors(poses, truth)[:, 0]


def drift(seeds: Iterable[int] = range(DRAWS)) -> Drift:
    """Solve surveys without the lone beams and with them, and measure how far poses drift."""
    without: list[Array] = []
    held: list[Array] = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        session, count = surfaced(rng)
        single, truth = beams(session, count, rng), session.truth_in_session
        for factors, into in ((session.factors, without), ((*session.factors, single), held)):
            graph = whole(factors, session.start)
            # planes that only a surfaced pose would have seen are in no factor
            graph.live_planes[session.seen_from >= count] = False
            state = solve(graph, session.start).state
            off = towards_hull(state.poses, truth)
            into.append(off[count:] - off[count - 1 :: -1])  # the leg below, driven the other way
    return Drift(without=np.array(without), held=np.array(held))


def study() -> StudyResult:
    """Measure how far a surfaced vehicle drifts from the hull, without lone beams and with them."""
    found = drift()
    return StudyResult(
        figures=(draw(found),),
        compared=tuple(
            ComparedValue(
                what=f"surfaced poses off those below, towards the hull, {name}",
                unit="m",
                ours=float(np.sqrt(np.mean(off**2))),
                note="well aligned with range factors, some drift without: drawn alone",
            )
            for name, off in (("without lone beams", found.without), ("with them", found.held))
        ),
    )


def draw(found: Drift) -> PublishedFigure:
    """Draw the drift along the surfaced leg."""
    figure, axes = new_canvas(7.0, 3.2)
    axis, number = axes[0][0], np.arange(found.held.shape[1])
    table = ["pose,rms_without_m,rms_with_m"]
    for off, ink, name in (
        (found.without, RED, "without lone beams"),
        (found.held, COLOURS["maxmix"], "with them"),
    ):
        axis.plot(number, off.T, color=ink, lw=0.4, alpha=0.5)
        axis.plot(number, np.sqrt((off**2).mean(axis=0)), color=ink, lw=2, label=name)
    both = (np.sqrt((off**2).mean(axis=0)) for off in (found.without, found.held))
    table += [f"{k},{a:.5f},{b:.5f}" for k, a, b in zip(number, *both, strict=True)]
    axis.set(xlabel="pose since the vehicle surfaced", ylabel="off towards the hull (m)")
    axis.legend(fontsize=8, frameon=False)
    return finish_figure(
        "lone_beams",
        figure,
        table,
        "A leg at the surface with two beams a ping, held to the planes of the leg below or not.",
    )

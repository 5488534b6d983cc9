# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which leg to drive next, by what it does to the path's sigma [Ozog2016 5.2, active SLAM].

The source asks for planes in the choice. A leg's factors are predicted from the path that it would
have. The measured values do not matter to the covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses, stacked
from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.sessions.factors import State
from hullrecon.studies.sessions.graph import covariance, pose_covariances, whole
from hullrecon.studies.sessions.motions import plane_out
from hullrecon.studies.sessions.survey import facing, legs, planes_before, surface, survey
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array

FROM_M, TO_M = -10.0, 10.0  # x of the legs' ends, along the hull
SPACING_M = 2.6  # of the two legs in depth: their images do not overlap
SHALLOW_M, DEEP_M = 1.5, 1.5 + SPACING_M  # depths of the two legs
HALF_WAY_M = 0.5 * (DEEP_M + SHALLOW_M)  # images overlap with those of both legs
SEED = 0


@dataclass(frozen=True, kw_only=True)
class Choice:
    """A leg that could be driven, and what it would leave."""

    name: str
    path: Poses
    sigma_m: dict[str, float]  # of the path driven so far, root mean square, by sensors

    @property
    def length_m(self) -> float:
        """Length of the leg."""
        return float(np.linalg.norm(np.diff(self.path.translation, axis=0), axis=1).sum())


SENSORS = {"links and planes": True, "links": False}


def driven() -> Poses:
    """Drive two legs, one below the other."""
    return legs(FROM_M, TO_M, (SHALLOW_M, DEEP_M))


def legs_to_choose() -> dict[str, Poses]:
    """Lay out the legs that could follow: paths that face the hull, with a pose every metre.

    The second leg was driven back, so each of them begins where it ended, at x = FROM_M. Depths are
    chosen so that images overlap with those of the legs that a path runs beside.
    """

    def at(x_m: Array, depth_m: float | Array) -> Poses:
        """Face the hull at places (n,) m along it, x, and at their depths."""
        return facing(*surface(x_m, np.broadcast_to(depth_m, x_m.shape)))

    x = np.arange(FROM_M, TO_M + 1e-9)
    middle = len(x) // 2
    up_to_first = at(np.full(4, FROM_M), np.linspace(DEEP_M, SHALLOW_M, 4))
    up_from_middle = at(np.full(3, x[middle]), np.linspace(2.5, 1.6, 3))
    return {
        "a new leg below": at(x, DEEP_M + 1.3),
        "back between both legs": at(x, HALF_WAY_M),
        "up to the first leg, and along it": stacked([up_to_first, at(x[1:], 1.7)]),
        "half of the way between, then up": stacked(
            [at(x[: middle + 1], HALF_WAY_M), up_from_middle]
        ),
    }


def foreseen_sigma(path: Poses, first: int, planes: bool) -> float:
    """Predict the sigma of the first `first` poses of a path after all of it, m, root mean square.

    planes: whether the DVL's planes are measured beside the links of images.
    """
    session = survey(path, np.random.default_rng(SEED), planes=planes)
    truth = session.truth_in_session
    seen = planes_before(session.truth[session.seen_from])
    state = State(
        poses=truth,
        planes=plane_out(truth[session.seen_from], seen) if planes else np.zeros((0, 3)),
    )
    graph = whole(session.factors, state)
    own = pose_covariances(graph, covariance(graph, state))[:first, :3, :3]
    return float(np.sqrt(np.trace(own, axis1=1, axis2=2).mean()))


def choices() -> tuple[dict[str, float], list[Choice]]:
    """Predict the sigmas, by sensors: of the path driven so far, and after each possible leg."""
    so_far = driven()
    count = len(so_far)
    before = {name: foreseen_sigma(so_far, count, planes) for name, planes in SENSORS.items()}
    found = []
    for name, path in legs_to_choose().items():
        both = stacked([so_far, path])
        after = {s: foreseen_sigma(both, count, planes) for s, planes in SENSORS.items()}
        found.append(Choice(name=name, path=path, sigma_m=after))
    return before, found


def gain(before: float, after: float, length_m: float) -> float:
    """Compute what a metre of a leg takes off the path's sigma, mm."""
    return 1e3 * (before - after) / length_m


def study() -> StudyResult:
    """Rank the possible legs by what a metre of each takes off the path's sigma.

    With the DVL's planes and without them.
    """
    before, found = choices()
    best = {s: max(found, key=lambda c: gain(before[s], c.sigma_m[s], c.length_m)) for s in SENSORS}
    rows = [("none", "0", *(f"{1e3 * sigma:.1f}" for sigma in before.values()), "")]
    rows += [
        (c.name, f"{c.length_m:.0f}", *(f"{1e3 * sigma:.1f}" for sigma in c.sigma_m.values()),
         f"{gain(before['links and planes'], c.sigma_m['links and planes'], c.length_m):.2f}")
        for c in found
    ]  # fmt: skip
    chosen = best["links and planes"]
    return StudyResult(
        figures=(draw(before, found),),
        heads=("leg", "m", *(f"sigma by {s}, mm" for s in SENSORS), "mm less by metre"),
        rows=tuple(rows),
        compared=(
            *(
                ComparedValue(
                    what=f"sigma of the path after the best leg over that before, {sensors}",
                    ours=best[sensors].sigma_m[sensors] / before[sensors],
                    note=f"{best[sensors].name}; future work in the source",
                )
                for sensors in SENSORS
            ),
            ComparedValue(
                what="length of the best leg, by planes and links",
                unit="m",
                ours=chosen.length_m,
                note=chosen.name,
            ),
        ),
    )


def draw(before: dict[str, float], found: list[Choice]) -> PublishedFigure:
    """Draw the legs on the hull, and the sigmas that they leave.

    before: sigma of the path driven so far without another leg, m, by sensors.
    """
    figure, axes = new_canvas(9.6, 3.4, 1, 2)
    so_far = driven().translation
    axes[0][0].plot(so_far[:, 0], so_far[:, 2], ".-", color=COLOURS["naive"], label="driven")
    for choice in found:
        at = choice.path.translation
        axes[0][0].plot(at[:, 0], at[:, 2], "-", lw=1.2, label=choice.name)
    axes[0][0].invert_yaxis()
    axes[0][0].set(xlabel="x (m)", ylabel="depth (m)")
    axes[0][0].legend(fontsize=6, frameon=False)
    names = ["none", *(c.name for c in found)]
    place = np.arange(len(names))
    table = ["leg,sensors,length_m,sigma_m"]
    for k, (sensors, ink) in enumerate(zip(SENSORS, (COLOURS["maxmix"], GREEN), strict=True)):
        sigma: list[float] = [before[sensors], *(c.sigma_m[sensors] for c in found)]
        axes[0][1].barh(place + 0.4 * k, 1e3 * np.array(sigma), 0.38, color=ink, label=sensors)
        lengths = [0.0, *(c.length_m for c in found)]
        table += [
            f"{n},{sensors},{m:.2f},{s:.5f}" for n, m, s in zip(names, lengths, sigma, strict=True)
        ]
    axes[0][1].set_yticks(place + 0.2, names, fontsize=7)
    axes[0][1].set_xlabel("sigma of the path driven so far (mm)")
    axes[0][1].legend(fontsize=8, frameon=False)
    return finish_figure(
        "next_legs",
        figure,
        table,
        "Legs that could be driven next, and the sigma of the path so far that each would leave.",
    )

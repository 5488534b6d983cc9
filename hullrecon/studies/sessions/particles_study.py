# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How often, how soon and among how many images a vehicle is found again [Ozog2016 2.5.4]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses, from_rpy, stacked
from hullrecon.studies.figure_style import (
    COLOURS,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.sessions.motions import between, plane_out
from hullrecon.studies.sessions.particles import (
    PlaneMap,
    area_m2,
    as_poses,
    candidates,
    drawn_again,
    moved_on,
    plane_distances,
    spread,
    weights,
)
from hullrecon.studies.sessions.survey import PLANE_SIGMA_M, facing, planes_before, surface
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array

AXES_M = np.array([90.0, 12.0, 9.0])  # of a ship of 180 m
MAP_EVERY_M, MAP_DEPTHS_M = 2.5, (1.0, 2.25, 3.5)
ENDS = 0.65  # of the half length: the map ends there
PARTICLES, TRIALS, STEP_M, LONGEST = 6000, 24, 1.0, 20  # steps
ODOMETRY_SIGMA = np.array([0.02, 0.02, 0.005])
HEADING_SIGMA = 0.5  # rad, of a compass beside steel: it shows which side of the ship is ahead
AREA_M2 = 250.0  # below it images are compared, as printed
AGAIN_M = 1.0  # until they are compared again, as printed
SHARED_M = 1.6  # images nearer than that have enough in common for a match
SPEED_M_S, IMAGE_S = 0.25, 0.07  # of the vehicle; of a candidate's comparison, as printed
SEED = 0
SHOWN = (0, 4, 16)  # steps that are drawn


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One start at an unknown place."""

    images: tuple[int, ...]  # candidates of each search
    true: tuple[int, ...]  # how many of these candidates are of the same place
    there: tuple[int, ...]  # how many key frames of the map are of the same place
    driven_m: float  # until found, or until given up
    found: bool
    shown: tuple[Array, ...]  # particles at steps
    truth: Array  # (3,) of the first pose

    @property
    def seconds(self) -> float:
        """Compute the time to alignment: driving and comparing images."""
        return self.driven_m / SPEED_M_S + IMAGE_S * sum(self.images)


def study() -> StudyResult:
    """Localise a vehicle in an old map from many starts, and measure how soon it is aligned."""
    rng = np.random.default_rng(SEED)
    known = old_map(rng)
    trials = [run(known, rng) for _ in range(TRIALS)]
    images, true, there = (
        np.concatenate([getattr(t, name) for t in trials]) for name in ("images", "true", "there")
    )
    on_map = there > 0
    found = [t for t in trials if t.found]
    figure = draw(known, run(known, rng, search=False))
    return StudyResult(
        figures=(figure,),
        compared=(
            _value("searches whose candidates hold an image of the place", "%", 100.0,
                   100 * float((true[on_map] > 0).mean()), "FAB-MAP: 27.7 %"),
            _value("candidates that are of the place, mean", "%", 3.0,
                   100 * float((true / images)[on_map].mean()), "FAB-MAP: 12.1 %"),
            _value("candidates of a search, mean", "", 100.0, float(images.mean()), "about 100"),
            _value("time to alignment, under water throughout, median", "s", 15.3,
                   float(np.median([t.seconds for t in found])),
                   f"at {SPEED_M_S:g} m/s, images compared in {1e3 * IMAGE_S:g} ms as printed"),
            _value("starts that are aligned", "%", None, 100 * len(found) / len(trials),
                   f"within {LONGEST * STEP_M:g} m; images of one place are taken to match"),
        ),
    )  # fmt: skip


def old_map(rng: np.random.Generator) -> PlaneMap:
    """Map both sides of a ship, planes with their noise."""
    x = np.arange(-ENDS * AXES_M[0], ENDS * AXES_M[0], MAP_EVERY_M)
    side = facing(*surface(np.tile(x, len(MAP_DEPTHS_M)), np.repeat(MAP_DEPTHS_M, len(x)), AXES_M))
    poses = stacked([side, mirrored(side)])
    seen = planes_before(poses, AXES_M)
    seen = seen + PLANE_SIGMA_M * rng.standard_normal(seen.shape)
    return PlaneMap(poses=poses, planes=plane_out(poses, seen))


def mirrored(poses: Poses) -> Poses:
    """Put level poses on the ship's other side."""
    rpy = poses.rotation.as_euler("xyz")
    return from_rpy(poses.translation * [1, -1, 1], rpy * [1, 1, -1])


def path(rng: np.random.Generator) -> Poses:
    """Drive a leg along either side, beginning and turning anywhere on the map."""
    start = rng.uniform(-ENDS, ENDS) * AXES_M[0]
    ahead = -np.sign(start) * STEP_M * np.arange(LONGEST)
    depth = rng.uniform(MAP_DEPTHS_M[0], MAP_DEPTHS_M[-1])
    leg = facing(*surface(start + ahead, np.full(LONGEST, depth), AXES_M))
    return leg if rng.random() < 0.5 else mirrored(leg)


def run(known: PlaneMap, rng: np.random.Generator, *, search: bool = True) -> Trial:
    """Filter along a path, and search the candidates' images where they are few enough."""
    truth = path(rng)
    depth = float(truth.translation[0, 2])
    yaw = truth.rotation.as_euler("xyz")[:, 2]
    seen = planes_before(truth, AXES_M) + PLANE_SIGMA_M * rng.standard_normal((len(truth), 3))
    particles = spread(known, depth, PARTICLES, rng)
    compass = (particles[:, 2] - yaw[0] - HEADING_SIGMA * rng.standard_normal() + np.pi) % (
        2 * np.pi
    ) - np.pi
    likelihood = np.exp(-0.5 * (compass / HEADING_SIGMA) ** 2)
    particles = drawn_again(particles, likelihood / likelihood.sum(), rng)
    images, true, there, shown = [], [], [], []  # as of `Trial`
    searched = -np.inf  # m of the way at which images were searched last
    for k in range(len(truth)):
        if k:
            step = between(truth[k - 1], truth[k])[0].log()[0][[0, 1, 5]]
            particles = moved_on(
                particles, step + ODOMETRY_SIGMA * rng.standard_normal(3), ODOMETRY_SIGMA, rng
            )
        distance = plane_distances(known, as_poses(particles, depth), seen[k])
        particles = drawn_again(particles, weights(*distance), rng)
        if k in SHOWN:
            shown.append(particles.copy())
        if not search or area_m2(particles) > AREA_M2 or STEP_M * k - searched < AGAIN_M:
            continue
        searched = STEP_M * k
        chosen = candidates(known, particles, depth)
        near = np.linalg.norm(known.poses.translation - truth.translation[k], axis=1) < SHARED_M
        images.append(len(chosen))
        true.append(int(near[chosen].sum()))
        there.append(int(near.sum()))
        if true[-1]:
            break
    return Trial(
        images=tuple(images), true=tuple(true), there=tuple(there), driven_m=STEP_M * k,
        found=bool(true and true[-1]), shown=tuple(shown), truth=truth.translation[0],
    )  # fmt: skip


def draw(known: PlaneMap, trial: Trial) -> PublishedFigure:
    """Draw the map with the particles of one trial [Ozog2016 Fig. 2.10]."""
    figure, axes = new_canvas(9.6, 1.9 * len(trial.shown), len(trial.shown), 1, sharex="all")
    table = ["step,x_m,y_m,yaw_rad"]
    for (axis,), step, particles in zip(axes, SHOWN, trial.shown, strict=False):
        axis.plot(*known.poses.translation[:, :2].T, ".", ms=2, color=INK)
        axis.plot(*particles[:, :2].T, ".", ms=1, color=RED, alpha=0.4)
        axis.plot(*trial.truth[:2], "x", color=COLOURS["maxmix"], ms=9)
        axis.set(ylabel="y (m)")
        axis.set_title(f"after {STEP_M * step:g} m", fontsize=9)
        table += [f"{step},{x:.2f},{y:.2f},{a:.3f}" for x, y, a in particles[::10]]
    axes[-1][0].set_xlabel("x (m)")
    return finish_figure(
        "particles_on_map",
        figure,
        table,
        "Particles (red) over the poses of an old map as planes are seen; the cross is where the "
        "vehicle began.",
    )


def _value(what: str, unit: str, printed: float | None, ours: float, note: str) -> ComparedValue:
    return ComparedValue(what=what, unit=unit, printed=printed, ours=ours, note=note)

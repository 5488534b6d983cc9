# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Targets of several side-scan passes: paired, placed, and held against the truth."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.studies.association.point_sets import chi_square
from hullrecon.studies.figure_style import (
    GREEN,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.studies.targets.side_scan import (
    ALTITUDE_M,
    LANE_M,
    RANGES_M,
    Kind,
    Thing,
    draw_thing,
    draw_tile,
    rows_of_lanes,
)
from hullrecon.studies.targets.sonar_targets import (
    Pass,
    ReadingErrors,
    Readings,
    Sigmas,
    SonarTarget,
    place_targets,
    read_detections,
    sonar_sees,
)
from hullrecon.studies.targets.thresholds import detect_by_thresholds
from hullrecon.typing import Array

SEED, SURVEYS = 7, 40
OFFSETS_M = (0.0, 4.0, -4.0)  # of the passes, across
LYING = (*[Kind.TARGET] * 6, Kind.BRIGHT, Kind.DARK, Kind.HOLLOW)
FISH, FISH_LANES = 2, 4  # shoals a pass, like targets and gone by the next; where they may be
CALIBRATION_TILES = 40
NEAR_M = 1.0  # a detection this near a thing is of it


@dataclass(frozen=True, kw_only=True)
class Survey:
    """What lies on a floor, and what the passes saw."""

    points: Array  # (t, 2) m, near edges of the targets
    heights_m: Array  # (t,)
    decoys: Array  # (d, 2) m, of what lies there and is no target
    passes: tuple[Pass, ...]
    fish: int  # shoals met


@dataclass(frozen=True, kw_only=True)
class Trial:
    """Many surveys, their targets found and placed."""

    errors: ReadingErrors
    surveys: tuple[Survey, ...]
    confirmed: tuple[list[SonarTarget], ...]
    alone: tuple[list[SonarTarget], ...]
    chi2: Array  # (n,) of the confirmed targets' places, two degrees of freedom
    height_off: Array  # (n,) in sigmas
    missed: int  # targets that are not confirmed
    false: int  # confirmed, yet no target is there

    @property
    def targets(self) -> int:
        """Number of targets in all surveys."""
        return sum(len(survey.points) for survey in self.surveys)

    @property
    def fish(self) -> int:
        """Number of shoals in all surveys."""
        return sum(survey.fish for survey in self.surveys)


def study() -> StudyResult:
    """Place the targets of many surveys and hold them against the truth."""
    trial = try_surveys(SEED, SURVEYS)
    rows = [t.row(k + 1) for k, t in enumerate(trial.confirmed[0])]
    return StudyResult(
        figures=(draw_survey(trial),),
        values={"objects": rows},
        heads=("objects.json of the first survey, a row a target",),
        rows=tuple((json.dumps(row, default=float),) for row in _rounded(rows)),
        compared=compare(trial),
    )


def _rounded(rows: Sequence[dict[str, object]]) -> list[object]:
    return [json.loads(json.dumps(r), parse_float=lambda v: float(f"{float(v):.3g}")) for r in rows]


def try_surveys(seed: int, surveys: int) -> Trial:
    """Calibrate the readings on tiles of their own, then place the targets of new surveys."""
    sigmas = Sigmas()
    errors = calibrate_readings(np.random.default_rng(seed + 1), CALIBRATION_TILES)
    rng = np.random.default_rng(seed)
    flown = tuple(simulate(rng, sigmas) for _ in range(surveys))
    confirmed, alone, chi2, height_off, missed, false = [], [], [], [], 0, 0
    area_m2 = (len(LYING) + FISH_LANES) * LANE_M * (RANGES_M[1] - RANGES_M[0])
    for survey in flown:
        sure, unsure = place_targets(survey.passes, sigmas, errors, area_m2)
        confirmed.append(sure)
        alone.append(unsure)
        met = set()
        for target in sure:
            off = target.center[:2] - survey.points
            nearest = int(np.argmin(np.linalg.norm(off, axis=1)))
            if np.linalg.norm(off[nearest]) > NEAR_M:
                false += 1
                continue
            met.add(nearest)
            chi2.append(off[nearest] @ np.linalg.solve(target.covariance, off[nearest]))
            up = target.center[2] - survey.heights_m[nearest]
            height_off.append(up / target.height_sigma_m)
        missed += len(survey.points) - len(met)
    return Trial(
        errors=errors,
        surveys=flown,
        confirmed=tuple(confirmed),
        alone=tuple(alone),
        chi2=np.array(chi2),
        height_off=np.array(height_off),
        missed=missed,
        false=false,
    )


def calibrate_readings(rng: np.random.Generator, tiles: int) -> ReadingErrors:
    """Measure how readings of targets at known places err: their bias and covariance."""
    off = []
    for _ in range(tiles):
        along = (np.arange(len(LYING)) + 1.0) * LANE_M
        ranges = rng.uniform(*RANGES_M, len(LYING))
        things = [draw_thing(rng, Kind.TARGET, *it) for it in zip(along, ranges, strict=True)]
        seen = _read(rng, things)
        for thing in things:
            near = np.hypot(seen.along_m - thing.along_m, seen.range_m - thing.range_m)
            if len(near) and near.min() < NEAR_M:
                k = int(np.argmin(near))
                read = np.array([seen.along_m[k], seen.range_m[k], seen.height_m[k]])
                off.append(read - [thing.along_m, thing.range_m, thing.highlight_m])
    return ReadingErrors(bias=np.mean(off, axis=0), covariance=np.cov(np.transpose(off)))


def _read(rng: np.random.Generator, things: Sequence[Thing]) -> Readings:
    """Draw a tile with things, and measure what is detected in it."""
    tile = draw_tile(rng, rows_of_lanes(len(LYING) + FISH_LANES + 1), things)
    return read_detections(detect_by_thresholds(tile))


def simulate(rng: np.random.Generator, sigmas: Sigmas) -> Survey:
    """Pass a floor with targets several times, each pass and the mount a little off."""
    lanes = 1.0 + rng.permutation(np.arange(float(len(LYING) + FISH_LANES)))
    lying = [
        draw_thing(rng, kind, lane * LANE_M, rng.uniform(RANGES_M[0] + 5, RANGES_M[1] - 5))
        for kind, lane in zip(LYING, lanes[: len(LYING)], strict=True)
    ]
    mount = sigmas.mount_rad * rng.standard_normal()
    passes = []
    for offset in OFFSETS_M:
        start = np.array([0.0, offset]) + sigmas.place_m * rng.standard_normal(2)
        heading = sigmas.heading_rad * rng.standard_normal()
        things = [_as_seen(thing, start, heading, mount) for thing in lying]
        things += [
            draw_thing(rng, Kind.TARGET, along, rng.uniform(*RANGES_M))
            for along in _shoals(rng, lanes[len(LYING) :])
        ]
        passes.append(Pass(start=np.array([0.0, offset]), readings=_read(rng, things)))
    targets = [t for t in lying if t.kind is Kind.TARGET]
    decoys = [t for t in lying if t.kind is not Kind.TARGET]
    return Survey(
        points=np.array([[t.along_m, t.range_m] for t in targets]),
        heights_m=np.array([t.highlight_m for t in targets]),
        decoys=np.array([[t.along_m, t.range_m] for t in decoys]),
        passes=tuple(passes),
        fish=FISH * len(OFFSETS_M),
    )


def _shoals(rng: np.random.Generator, lanes: Array) -> Array:
    """Draw where along the track a pass meets shoals, m. lanes: numbers (n,) of those to use."""
    off = rng.uniform(-0.25, 0.25, FISH)  # of a lane, so that none covers another thing
    return np.asarray((rng.choice(lanes, FISH, replace=False) + off) * LANE_M)


def _as_seen(thing: Thing, start: Array, heading: float, mount: float) -> Thing:
    """Move a thing of the map to where a pass's tile shows it, and cast a target's shadow anew.

    start, heading, mount: of the pass, as of `sonar_sees`.
    """
    point = np.array([thing.along_m, thing.range_m])
    along, range_m = sonar_sees(point, start, heading, mount)
    height = thing.highlight_m
    shadow = height * (range_m + height) / (ALTITUDE_M - height)
    if thing.kind is not Kind.TARGET:
        shadow = thing.shadow_m
    return replace(thing, along_m=along, range_m=range_m, shadow_m=shadow)


def compare(trial: Trial) -> tuple[ComparedValue, ...]:
    """Compare detection rates, and errors of place and height in their own sigmas."""
    found = trial.targets - trial.missed
    three_sigmas = chi_square(0.9973, 2)
    sigma = [np.sqrt(t.covariance.trace()) for found in trial.confirmed for t in found]
    return (
        ComparedValue(
            what="targets confirmed by two passes or three",
            unit="%",
            ours=100 * found / trial.targets,
            note=f"{found} of {trial.targets} in {len(trial.surveys)} surveys; the source "
            "shows one picture and no rates",
        ),
        ComparedValue(
            what="confirmed where no target lies",
            ours=float(trial.false),
            note=f"of {trial.fish} shoals that look like a target in one pass, and of what is "
            "bright or dark alone; joint compatibility over the passes is the second check",
        ),
        ComparedValue(
            what="places within three sigmas of the truth",
            unit="%",
            ours=100 * float(np.mean(trial.chi2 < three_sigmas)),
            note=f"of {len(trial.chi2)}; mean chi-square {trial.chi2.mean():.2f} for 2 degrees of "
            f"freedom, median sigma {np.median(sigma):.2f} m. Passes know their place to 0.15 m, "
            "heading to 0.3 degrees, the mount to 0.5",
        ),
        ComparedValue(
            what="heights within three sigmas of the truth",
            unit="%",
            ours=100 * float(np.mean(np.abs(trial.height_off) < 3)),
            note="by the length of the shadow; the source does not measure it. Sigma of one "
            f"reading {np.sqrt(trial.errors.covariance[2, 2]):.3f} m",
        ),
    )


def draw_survey(trial: Trial) -> PublishedFigure:
    """Draw the first survey: detections by pass, and targets with their ellipses."""
    canvas, axes = new_canvas(9.0, 5.2)
    axis = axes[0][0]
    survey = trial.surveys[0]
    for number, (of, marker) in enumerate(zip(survey.passes, "x+1", strict=True)):
        places = of.start + np.column_stack([of.readings.along_m, of.readings.range_m])
        axis.plot(*places.T, marker, color=INK, ms=6, label=f"detected, pass {number + 1}")
    axis.plot(*survey.points.T, "s", mfc="none", color=GREEN, ms=11, label="target, true place")
    axis.plot(*survey.decoys.T, "s", mfc="none", color=RED, ms=11, label="bright or dark alone")
    angle = np.linspace(0, 2 * np.pi, 60)
    for k, target in enumerate(trial.confirmed[0]):
        circle = np.linalg.cholesky(target.covariance) @ np.array([np.cos(angle), np.sin(angle)])
        ellipse = target.center[:2, None] + 3 * circle
        label = "confirmed, three sigmas" if k == 0 else None
        axis.plot(*ellipse, color=GREEN, lw=1, label=label)
    axis.set(xlabel="along the passes (m)", ylabel="to port of the first (m)", aspect="equal")
    axis.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    table = ["x_m,y_m,height_m,passes,pings,p_value,confirmed"]
    for confirmed, found in ((1, trial.confirmed[0]), (0, trial.alone[0])):
        for t in found:
            place = ",".join(f"{value:.3f}" for value in t.center)
            table.append(f"{place},{t.passes},{t.pings},{t.p_value:.3g},{confirmed}")
    return finish_figure(
        "sonar-targets",
        canvas,
        table,
        "Detections of three passes, and the targets that they confirm. A detection without an "
        "ellipse was seen by one pass alone.",
    )

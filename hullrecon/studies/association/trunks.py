# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Trunks of trees in a laser's half circle [Aulinas2011 4.2.1]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array

BEAMS = 361  # over half a circle, every half degree, from the right to the left
STEP_RAD = np.pi / (BEAMS - 1)
REACH_M = 80.0
NEAREST_M, FARTHEST_M = 3.0, 40.0  # as printed, p. 62
GAP_M = 0.7  # between neighbouring beams of two things
WIDEST_M = 1.5  # of a trunk; wider is a wall or a car

BEARINGS = np.arange(BEAMS) * STEP_RAD
RADII_M = (0.15, 0.5)  # of the trees that are simulated
EDGES = 48  # places of an edge between two beams at which the best fit looks


@dataclass(frozen=True, kw_only=True)
class Trunk:
    """A trunk as it was found."""

    range_m: float  # of its middle
    bearing_rad: float  # from the car's right
    radius_m: float
    beams: tuple[int, int]  # the first and the last that hit it


def scan_trees(pose: Array, trees: Array, range_sigma_m: float, rng: np.random.Generator) -> Array:
    """Simulate the ranges (BEAMS,) m of a laser among trees (n, 3): x, y, radius, m.

    pose: (3,) of the laser, x, y, heading. A beam that hits no tree has REACH_M.
    """
    off = trees[:, :2] - pose[:2]
    middle = np.hypot(off[:, 0], off[:, 1])
    bearing = np.arctan2(off[:, 1], off[:, 0]) - pose[2] + np.pi / 2
    turn = np.mod(BEARINGS[:, None] - bearing[None, :] + np.pi, 2 * np.pi) - np.pi
    across = middle * np.sin(turn)  # how far a beam passes from the trunk's middle
    half_chord = np.sqrt(np.maximum(trees[:, 2] ** 2 - across**2, 0.0))
    hits = (np.abs(across) < trees[:, 2]) & (np.abs(turn) < np.pi / 2)
    ranges = np.where(hits, middle * np.cos(turn) - half_chord, REACH_M).min(axis=1)
    noisy = ranges + range_sigma_m * rng.standard_normal(BEAMS)
    return np.where(ranges < REACH_M, noisy, REACH_M)


def find_trunks(ranges: Array, widened: bool = True) -> list[Trunk]:
    """Find trunks in a scan.

    The outer two beams that hit are taken for tangents: the middle lies on their bisector,
    their ends are a diameter apart, and the middle's range is that of the middle beam plus the
    radius. On average the tangents lie half a beam's distance outside of those that still hit.

    Parameters
    ----------
    ranges
        Of the beams (BEAMS,), m.
    widened
        Whether the trunk is taken half a beam wider on each side; the thesis does not.
    """
    trunks = []
    for first, last in _groups(ranges):
        middle = (first + last) / 2
        nearest = float(ranges[int(np.floor(middle)) : int(np.ceil(middle)) + 1].min())
        width = _chord(ranges[first], ranges[last], (last - first) * STEP_RAD)
        if widened:
            width = width + nearest * STEP_RAD
        if width < WIDEST_M and NEAREST_M < nearest < FARTHEST_M:
            trunks.append(
                Trunk(
                    range_m=nearest + width / 2,
                    bearing_rad=middle * STEP_RAD,
                    radius_m=width / 2,
                    beams=(first, last),
                )
            )
    return trunks


def _groups(ranges: Array) -> list[tuple[int, int]]:
    """Group neighbouring beams whose ranges (BEAMS,) m are alike, as those that hit one thing.

    Returns the first and last beam of each group. Beams that hit nothing near are in none.
    """
    stops = ranges < FARTHEST_M + GAP_M
    starts = stops & ~np.concatenate([[False], stops[:-1] & (np.abs(np.diff(ranges)) < GAP_M)])
    ends = stops & ~np.concatenate([stops[1:] & (np.abs(np.diff(ranges)) < GAP_M), [False]])
    return list(zip(np.flatnonzero(starts).tolist(), np.flatnonzero(ends).tolist(), strict=True))


def _chord(first_m: float, last_m: float, angle: float) -> float:
    """Compute the distance, m, between the ends of two beams that are `angle`, rad, apart."""
    square = first_m**2 + last_m**2 - 2 * first_m * last_m * np.cos(angle)
    return float(np.sqrt(max(square, 0.0)))


@dataclass(frozen=True, kw_only=True)
class FittedTrunk:
    """A trunk's middle with the least mean square error that its beams allow."""

    middle_m: Array  # (2,) ahead of the laser, to its left
    mean_square_m2: float  # expected squared error of the middle


def fit_trunk(ranges: Array, beams: tuple[int, int], range_sigma_m: float) -> FittedTrunk:
    """Estimate the mean of a trunk's middle, given which beams hit it and their ranges.

    Either edge lies between the last beam that hit and the first that missed. Given both edges,
    the bearing is half way between them, the radius is the range of the middle D times sin(h) of
    half the angle h between them, and a beam at angle t from the bearing stops at
    D (cos t - sqrt(sin^2 h - sin^2 t)): linear in D. So the likelihood of an edge pair is that of
    a line through the ranges. The mean over all edge pairs is the estimate of least mean square
    error where any place and any radius is as likely as another: no rule does better on average.

    Parameters
    ----------
    ranges
        Of the beams (BEAMS,), m.
    beams
        The first and the last that hit.
    range_sigma_m
        Of a beam.
    """
    first, last = beams
    share = (np.arange(EDGES) + 0.5) / EDGES
    right, left = np.meshgrid((first - 1 + share) * STEP_RAD, (last + share) * STEP_RAD)
    bearing, half = 0.5 * (left + right).ravel(), 0.5 * (left - right).ravel()
    turn = BEARINGS[first : last + 1] - bearing[:, None]
    per_metre = np.cos(turn) - np.sqrt(
        np.maximum(np.sin(half)[:, None] ** 2 - np.sin(turn) ** 2, 0.0)
    )
    measured, information = ranges[first : last + 1], (per_metre**2).sum(axis=1)
    middle = per_metre @ measured / information
    misfit = ((measured - middle[:, None] * per_metre) ** 2).sum(axis=1) / range_sigma_m**2
    radius = middle * np.sin(half)
    possible = (RADII_M[0] <= radius) & (radius <= RADII_M[1])
    possible |= ~possible.any()
    # bearing and radius to edges: a density of D / 2; integrated over D: 1 / sqrt(information)
    weight = np.exp(-0.5 * (misfit - misfit[possible].min())) * middle / np.sqrt(information)
    weight = np.where(possible, weight, 0.0)
    weight /= weight.sum()
    angle = bearing - np.pi / 2
    places = middle[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    mean = weight @ places
    along = range_sigma_m**2 * float(weight @ (1 / information))
    return FittedTrunk(
        middle_m=mean,
        mean_square_m2=along + float(weight @ ((places - mean) ** 2).sum(axis=1)),
    )


def trunk_readings(trunks: list[Trunk]) -> Array:
    """Convert trunks to ranges and bearings (n, 2), m and rad, as the filter takes them."""
    return np.array([[t.range_m, t.bearing_rad] for t in trunks]).reshape(-1, 2)

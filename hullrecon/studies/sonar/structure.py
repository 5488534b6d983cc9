# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Structure from motion by an imaging sonar whose servo is not well known [Ozog2016 5.2].

A sonar tells range and bearing of a feature, not its elevation. The servo's offset is an unknown
beside the features' places, and the hull's surface is what the source's model-assisted adjustment
would add: features lie on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from hullrecon.studies.figure_style import (
    COLOURS,
    INK,
    RED,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array, Ints

RANGE_SIGMA_M, BEARING_SIGMA_RAD, SURFACE_SIGMA_M = 0.01, np.radians(0.2), 0.01
OFFSET_RAD = np.radians(1.5)  # of the servo, true
OFFSET_SIGMA_RAD = np.radians(2.0)  # of its prior, which is zero
FEATURES, PINGS, SEED, DRAWS = 40, 12, 0, 6
TILT_RAD = np.radians(35.0)  # of the sonar's middle below level
BEARING_LIMIT_RAD, ELEVATION_LIMIT_RAD = np.radians(14.5), np.radians(7.0)
RADIUS_M = 8.0  # of the hull, about an axis along x
CASES = ("servo as logged", "servo unknown", "servo unknown, on the hull's surface")


@dataclass(frozen=True, kw_only=True)
class Survey:
    """Pings along a hull, and features that they see."""

    places: Array  # (pings, 3) m of the sonar; it looks to +y, level but for its servo
    features: Array  # (n, 3) m, true
    ping: Ints  # (m,) of each sighting
    feature: Ints  # (m,)
    measured: Array  # (m, 2) range m, bearing rad


def hull_distance(points: Array) -> Array:
    """Compute signed distances (n,) of points to the hull: a cylinder along x, 2 m ahead."""
    return np.asarray(np.hypot(points[:, 1] - 2.0 - RADIUS_M, points[:, 2]) - RADIUS_M)


def sighted(places: Array, points: Array, offset: float) -> tuple[Array, Array]:
    """Compute what a sonar at places (m, 3) m sees of points (m, 3) m, one each.

    offset: of the servo, rad. Returns range m and bearing rad (m, 2), and elevation (m,) rad, which
    a sonar does not measure.
    """
    turn = Rotation.from_euler("x", TILT_RAD + offset).inv()
    local = turn.apply(points - places)
    reach = np.linalg.norm(local, axis=1)
    bearing = np.arctan2(local[:, 0], local[:, 1])
    return np.column_stack([reach, bearing]), np.arcsin(local[:, 2] / reach)


def simulate(rng: np.random.Generator) -> Survey:
    """Survey in one leg along the hull that goes up and down a little."""
    x = np.linspace(-1.5, 1.5, PINGS)
    places = np.column_stack([x, 0.1 * np.sin(2 * x), 0.15 * np.sin(3 * x)])
    angle = rng.uniform(np.radians(4), np.radians(16), FEATURES)
    features = np.column_stack(
        [rng.uniform(-2, 2, FEATURES), 2 + RADIUS_M * (1 - np.cos(angle)), RADIUS_M * np.sin(angle)]
    )
    ping, feature = (k.ravel() for k in np.meshgrid(np.arange(PINGS), np.arange(FEATURES)))
    exact, elevation = sighted(places[ping], features[feature], OFFSET_RAD)
    seen = (np.abs(exact[:, 1]) < BEARING_LIMIT_RAD) & (np.abs(elevation) < ELEVATION_LIMIT_RAD)
    often = np.bincount(feature[seen], minlength=FEATURES) >= 2
    seen &= often[feature]
    names = np.cumsum(often) - 1
    noise = rng.standard_normal((int(seen.sum()), 2)) * [RANGE_SIGMA_M, BEARING_SIGMA_RAD]
    return Survey(
        places=places, features=features[often], ping=ping[seen],
        feature=np.asarray(names[feature[seen]], int), measured=exact[seen] + noise,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Structure:
    """Features and servo as estimated."""

    features: Array  # (n, 3) m
    offset: float  # rad, of the servo
    offset_sigma: float  # rad


def estimate(survey: Survey, case: str) -> Structure:
    """Solve for the features, and for the servo's offset unless it is taken as logged."""
    free, on_hull = case != CASES[0], case == CASES[2]
    count = len(survey.features)

    def residuals(numbers: Array) -> Array:
        """Compute the whitened residuals.

        numbers (3 n + 1,): the features' positions m, then the servo's offset rad.
        """
        points, offset = numbers[:-1].reshape(-1, 3), numbers[-1]
        seen, elevation = sighted(
            survey.places[survey.ping], points[survey.feature], float(offset) if free else 0.0
        )
        off = (seen - survey.measured) / [RANGE_SIGMA_M, BEARING_SIGMA_RAD]
        # Of elevation it is only known that it is within the beam. A Gaussian as wide stands in for
        # that. The offset has its prior in every case: without one the Jacobian would be singular
        # where the offset is not free
        parts = [off.ravel(), elevation / ELEVATION_LIMIT_RAD, [offset / OFFSET_SIGMA_RAD]]
        if on_hull:
            parts.append(hull_distance(points) / SURFACE_SIGMA_M)
        return np.concatenate(parts)

    found = least_squares(residuals, np.r_[_start(survey).ravel(), 0.0], x_scale="jac")
    jacobian = np.asarray(found.jac, float)
    spread = np.linalg.inv(jacobian.T @ jacobian)
    return Structure(
        features=found.x[: 3 * count].reshape(-1, 3),
        offset=float(found.x[-1]) if free else 0.0,
        offset_sigma=float(np.sqrt(spread[-1, -1])),
    )


def _start(survey: Survey) -> Array:
    """Place each feature (n, 3) m in the middle of the beam of the first ping that sees it."""
    first = np.unique(survey.feature, return_index=True)[1]
    reach, bearing = survey.measured[first].T
    local = np.column_stack(
        [reach * np.sin(bearing), reach * np.cos(bearing), np.zeros(len(first))]
    )
    return np.asarray(
        Rotation.from_euler("x", TILT_RAD).apply(local) + survey.places[survey.ping[first]]
    )


def study() -> StudyResult:
    """Estimate features in three ways, with several draws of noise."""
    surveys = [simulate(np.random.default_rng(SEED + k)) for k in range(DRAWS)]
    found = {case: [estimate(s, case) for s in surveys] for case in CASES}
    off = {
        case: float(np.sqrt(np.mean([((s.features - survey.features) ** 2).sum(axis=1).mean()
                                     for s, survey in zip(each, surveys, strict=True)])))
        for case, each in found.items()
    }  # fmt: skip
    rows = tuple(
        (
            case,
            f"{1e3 * off[case]:.0f}",
            f"{np.degrees(np.mean([s.offset for s in each])):.2f}" if case != CASES[0] else "",
            f"{np.degrees(np.mean([s.offset_sigma for s in each])):.2f}"
            if case != CASES[0]
            else "",
        )
        for case, each in found.items()
    )
    compared = [
        ComparedValue(
            what=f"error of the features, {case}",
            unit="mm",
            ours=1e3 * off[case],
            note="future work in the source: significant improvements are expected",
        )
        for case in CASES
    ]
    return StudyResult(
        figures=(draw(surveys[0], {case: each[0] for case, each in found.items()}),),
        heads=("case", "error of features, mm", "servo's offset, degrees", "its sigma, degrees"),
        rows=rows,
        compared=tuple(compared),
    )


def draw(survey: Survey, found: dict[str, Structure]) -> PublishedFigure:
    """Draw the features across the hull."""
    figure, axes = new_canvas(9.6, 3.6, 1, 3, sharex="all", sharey="all")
    table = ["case,x_m,y_m,z_m"]
    for axis, (case, structure) in zip(axes[0], found.items(), strict=True):
        z = np.linspace(0.3, 2.6, 60)
        axis.plot(2 + RADIUS_M - np.sqrt(RADIUS_M**2 - z**2), z, color=COLOURS["naive"])
        axis.plot(*survey.features[:, 1:].T, ".", color=INK, ms=3, label="truth")
        axis.plot(*structure.features[:, 1:].T, "x", color=RED, ms=4, label="estimated")
        axis.set_title(case, fontsize=8)
        axis.set_xlabel("y (m)")
        table += [f"{case},{x:.4f},{y:.4f},{z:.4f}" for x, y, z in structure.features]
    axes[0][0].invert_yaxis()
    axes[0][0].set_ylabel("z, down (m)")
    axes[0][0].legend(fontsize=8, frameon=False)
    return finish_figure(
        "sonar_features",
        figure,
        table,
        "Features of a sonar seen along the hull: with its servo as logged, with the servo as an "
        "unknown, and held to the hull's surface.",
    )

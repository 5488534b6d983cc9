# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A graph of three poses on a line [Ozog2016 1.3.1, Fig. 1.10]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.figure_style import (
    COLOURS,
    GREEN,
    INK,
    PublishedFigure,
    finish_figure,
    new_canvas,
)
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.typing import Array

PRINTED_M = (0.0, 2 / 3, 4 / 3)


@dataclass(frozen=True, kw_only=True)
class LineFactor:
    """A measured difference of two positions, or a measured position."""

    first: int | None  # None: of the second alone
    second: int
    measured_m: float
    variance_m2: float


# a step, a step, and a loop closure that contradicts their sum; the first pose is held
TOY = (
    LineFactor(first=None, second=0, measured_m=0.0, variance_m2=0.001),
    LineFactor(first=0, second=1, measured_m=1.0, variance_m2=1.0),
    LineFactor(first=1, second=2, measured_m=1.0, variance_m2=1.0),
    LineFactor(first=0, second=2, measured_m=1.0, variance_m2=1.0),
)


def solve_line(factors: tuple[LineFactor, ...]) -> tuple[Array, Array]:
    """Solve the normal equations [Ozog2016 eq. 1.4]: positions (n,) and covariance (n, n)."""
    count = 1 + max(factor.second for factor in factors)
    jacobian, measured = np.zeros((len(factors), count)), np.zeros(len(factors))
    for row, factor in enumerate(factors):
        jacobian[row, factor.second] = 1.0
        if factor.first is not None:
            jacobian[row, factor.first] = -1.0
        measured[row] = factor.measured_m
    weight = np.diag([1 / factor.variance_m2 for factor in factors])
    covariance = np.asarray(np.linalg.inv(jacobian.T @ weight @ jacobian), float)
    return covariance @ jacobian.T @ weight @ measured, covariance


def study() -> StudyResult:
    """Solve the graph and draw it."""
    position, covariance = solve_line(TOY)
    return StudyResult(figures=(draw(position, np.sqrt(np.diag(covariance))),))


def draw(position: Array, sigma: Array) -> PublishedFigure:
    """Draw the factors where they were measured, and the poses where they were estimated.

    position, sigma: (n,) m, of the poses.
    """
    figure, axes = new_canvas(7.4, 3.0)
    axis = axes[0][0]
    for row, factor in enumerate(TOY[1:]):
        assert factor.first is not None
        start = position[factor.first]
        axis.annotate(
            "",
            (start + factor.measured_m, -row - 1),
            (start, -row - 1),
            arrowprops={"arrowstyle": "->", "color": COLOURS["geva"]},
        )
        axis.annotate(
            f"measured x{factor.second} - x{factor.first} = {factor.measured_m:g} m",
            (start + 0.5 * factor.measured_m, -row - 1),
            ha="center",
            va="bottom",
            fontsize=8,
        )
    axis.errorbar(
        position,
        [0.3, 0.0, -0.3],
        xerr=sigma,
        fmt="o",
        color=COLOURS["maxmix"],
        capsize=4,
        label="solved",
    )
    axis.plot(np.arange(3.0), np.full(3, 1.0), "s", color=INK, label="by the steps alone")
    axis.plot(
        PRINTED_M,
        [0.3, 0.0, -0.3],
        "x",
        color=GREEN,
        markersize=11,
        label="as printed",
    )
    axis.set(xlabel="position (m)", ylim=(-3.8, 2.8), yticks=[])
    axis.legend(fontsize=8, frameon=False, ncols=3, loc="upper left")
    table = ["pose,position_m,sigma_m"]
    table += [f"{k},{x:.9f},{s:.9f}" for k, (x, s) in enumerate(zip(position, sigma, strict=True))]
    words = ", ".join(f"{x:.4f}" for x in position)
    return finish_figure(
        "toy_graph",
        figure,
        table,
        f"Two steps of 1 m and a loop closure of 1 m put three poses at {words} m.",
        tuple(
            ComparedValue(what=f"position of pose {k}", unit="m", printed=printed, ours=float(ours))
            for k, (printed, ours) in enumerate(zip(PRINTED_M, position, strict=True))
        ),
    )

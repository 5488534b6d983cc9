# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""On a linear problem all filters and the batch are one [Aulinas2011 Alg. 1, 2, eq (3.11)]."""

from __future__ import annotations

import numpy as np

from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.studies.submaps.filters import (
    Gaussian,
    LinearStep,
    filter_information,
    filter_steps,
    smooth,
    solve_batch,
)

STEPS, STEP_S = 60, 0.5
HEADS = ("against the batch", "largest difference of the mean", "of the covariance")


def linear_problem(seed: int, steps: int = STEPS) -> tuple[Gaussian, list[LinearStep]]:
    """Simulate a point of constant velocity in the plane, whose place is observed."""
    rng = np.random.default_rng(seed)
    # State: position, m, and velocity, m/s. Random accelerations of 0.2 m/s2 act through `into`
    move = np.eye(4)
    move[0, 2] = move[1, 3] = STEP_S
    into = np.array([[STEP_S**2 / 2, 0], [0, STEP_S**2 / 2], [STEP_S, 0], [0, STEP_S]])
    noise = 0.04 * into @ into.T + 1e-4 * np.eye(4)
    see = np.eye(2, 4)
    start = Gaussian(mean=np.zeros(4), covariance=np.diag([1.0, 1.0, 0.25, 0.25]))
    true, problem = rng.multivariate_normal(start.mean, start.covariance), []
    for _ in range(steps):
        true = move @ true + rng.multivariate_normal(np.zeros(4), noise)
        seen = see @ true + 0.3 * rng.standard_normal(2)
        problem.append(
            LinearStep(
                by_state=move,
                offset=np.zeros(4),
                motion_noise=noise,
                observation=see,
                observed=seen,
                observation_noise=0.09 * np.eye(2),
            )
        )
    return start, problem


def study_filters() -> StudyResult:
    """Hold the Kalman, the information filter and the smoother against the batch."""
    start, problem = linear_problem(0)
    batch, filtered = solve_batch(start, problem), filter_steps(start, problem)
    information = filter_information(start, problem)
    smoothed = smooth(filtered, problem)
    last = Gaussian(
        mean=information.mean(), covariance=np.asarray(np.linalg.inv(information.matrix))
    )
    pairs = {
        "Kalman filter, last state": [(filtered[-1], batch[-1])],
        "information filter, last state": [(last, batch[-1])],
        "smoother, all states": list(zip(smoothed, batch, strict=True)),
    }
    off = {name: _largest(states) for name, states in pairs.items()}
    return StudyResult(
        values={name: max(values) for name, values in off.items()},
        heads=HEADS,
        rows=tuple((name, f"{mean:.1e}", f"{cov:.1e}") for name, (mean, cov) in off.items()),
        compared=tuple(
            ComparedValue(
                what=f"{name}, against the batch",
                unit="m",
                ours=max(values),
                note="equal but for rounding; with P - W S P, as printed, nothing would be",
            )
            for name, values in off.items()
        ),
    )


def _largest(states: list[tuple[Gaussian, Gaussian]]) -> tuple[float, float]:
    """Compute the largest differences in mean and in covariance between two states of each pair."""
    return (
        max(float(np.abs(a.mean - b.mean).max()) for a, b in states),
        max(float(np.abs(a.covariance - b.covariance).max()) for a, b in states),
    )

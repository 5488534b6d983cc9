# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Kalman filter, its extended and its information form, and a smoother [Aulinas2011 Alg. 1, 2]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class Gaussian:
    """A state with its covariance: the belief (3.1)."""

    mean: Array  # (n,)
    covariance: Array  # (n, n)


def predict(state: Gaussian, moved: Array, by_state: Array, noise: Array) -> Gaussian:
    """Move a state (3.7): a linear motion gives the Kalman filter, a linearised one the extended.

    Parameters
    ----------
    state
        Before the motion.
    moved
        The motion model's value at its mean: g of (3.4).
    by_state
        F, the model's Jacobian (3.6).
    noise
        G Q G', in the state's own units.
    """
    return Gaussian(mean=moved, covariance=by_state @ state.covariance @ by_state.T + noise)


def update(state: Gaussian, innovation: Array, by_state: Array, noise: Array) -> Gaussian:
    """Update a state by an observation, with the covariance in Joseph's form.

    The thesis prints P - W S P in Algorithms 1 and 2 and in (3.11), whose units do not even
    agree: it is P - W S W'. And it takes S from the covariance before the prediction in (3.10).

    Parameters
    ----------
    state
        As predicted.
    innovation
        z - h(x) with h of (3.5), where (3.10) prints the motion model for h.
    by_state
        H, the Jacobian of h.
    noise
        R.
    """
    spread = by_state @ state.covariance @ by_state.T + noise  # S
    gain = np.linalg.solve(spread, by_state @ state.covariance).T  # W
    keep = np.eye(len(state.mean)) - gain @ by_state
    return Gaussian(
        mean=state.mean + gain @ innovation,
        covariance=keep @ state.covariance @ keep.T + gain @ noise @ gain.T,
    )


@dataclass(frozen=True, kw_only=True)
class Information:
    """A state in information form."""

    vector: Array  # (n,) matrix times mean
    matrix: Array  # (n, n) inverse of the covariance

    def mean(self) -> Array:
        """Recover the mean."""
        return np.asarray(np.linalg.solve(self.matrix, self.vector))


def predict_information(
    state: Information, by_state: Array, offset: Array, noise: Array
) -> Information:
    """Move a state x to F x + offset, in information form.

    Parameters
    ----------
    state
        Before the motion.
    by_state, offset
        F (n, n), and the offset (n,).
    noise
        Covariance (n, n) of the motion, which must be invertible.
    """
    inverse = np.asarray(np.linalg.inv(noise))
    carried = inverse @ by_state
    rest = np.linalg.inv(state.matrix + by_state.T @ carried)
    matrix: Array = inverse - carried @ rest @ carried.T
    return Information(matrix=matrix, vector=carried @ rest @ state.vector + matrix @ offset)


def update_information(
    state: Information, observed: Array, by_state: Array, noise: Array
) -> Information:
    """Add an observation z = H x with noise: information of independent sources is a sum.

    Parameters
    ----------
    state
        Before the observation.
    observed, by_state, noise
        z (k,), H (k, n), and R (k, k).
    """
    weighted = np.linalg.solve(noise, by_state).T
    return Information(
        matrix=state.matrix + weighted @ by_state, vector=state.vector + weighted @ observed
    )


@dataclass(frozen=True, kw_only=True)
class LinearStep:
    """A linear motion x' = F x + offset (3.2), and the observation z = H x after it (3.3)."""

    by_state: Array  # F
    offset: Array
    motion_noise: Array  # Q
    observation: Array  # H
    observed: Array  # z
    observation_noise: Array  # R


def filter_steps(start: Gaussian, steps: Sequence[LinearStep]) -> list[Gaussian]:
    """Run the Kalman filter: the state after each step, the start first."""
    states = [start]
    for step in steps:
        moved = step.by_state @ states[-1].mean + step.offset
        predicted = predict(states[-1], moved, step.by_state, step.motion_noise)
        innovation = step.observed - step.observation @ predicted.mean
        states.append(update(predicted, innovation, step.observation, step.observation_noise))
    return states


def filter_information(start: Gaussian, steps: Sequence[LinearStep]) -> Information:
    """Run the information filter to the last state."""
    matrix = np.asarray(np.linalg.inv(start.covariance))
    state = Information(matrix=matrix, vector=matrix @ start.mean)
    for step in steps:
        state = predict_information(state, step.by_state, step.offset, step.motion_noise)
        state = update_information(state, step.observed, step.observation, step.observation_noise)
    return state


def smooth(states: Sequence[Gaussian], steps: Sequence[LinearStep]) -> list[Gaussian]:
    """Smooth the states of `filter_steps`, from the last one back [RauchTungStriebel1965].

    Each state learns from the one after it, which knows all later observations. steps: those that
    the filter ran over.
    """
    smoothed = [states[-1]]
    for state, step in zip(states[-2::-1], steps[::-1], strict=True):
        later = smoothed[-1]
        moved = step.by_state @ state.mean + step.offset
        predicted = predict(state, moved, step.by_state, step.motion_noise)
        gain = np.linalg.solve(predicted.covariance, step.by_state @ state.covariance).T
        change = later.covariance - predicted.covariance
        smoothed.append(
            Gaussian(
                mean=state.mean + gain @ (later.mean - predicted.mean),
                covariance=state.covariance + gain @ change @ gain.T,
            )
        )
    return smoothed[::-1]


def solve_batch(start: Gaussian, steps: Sequence[LinearStep]) -> list[Gaussian]:
    """Estimate all states at once by least squares, with which a smoother must agree.

    The normal equations sum over the start, all motions and all observations.
    """
    size, count = len(start.mean), len(steps) + 1
    matrix, vector = np.zeros((count * size, count * size)), np.zeros(count * size)

    def add(jacobian: Array, value: Array, noise: Array) -> None:
        """Add to the normal equations that jacobian @ states = value, with covariance `noise`."""
        weighted = np.linalg.solve(noise, jacobian).T
        matrix[:] += weighted @ jacobian
        vector[:] += weighted @ value

    identity = np.eye(count * size)
    pick = [identity[k * size : (k + 1) * size] for k in range(count)]  # state k out of all
    add(pick[0], start.mean, start.covariance)
    for number, step in enumerate(steps):
        motion = pick[number + 1] - step.by_state @ pick[number]
        add(motion, step.offset, step.motion_noise)
        add(step.observation @ pick[number + 1], step.observed, step.observation_noise)
    covariance = np.asarray(np.linalg.inv(matrix))
    mean = covariance @ vector
    return [
        Gaussian(
            mean=mean[k * size : (k + 1) * size],
            covariance=covariance[k * size : (k + 1) * size, k * size : (k + 1) * size],
        )
        for k in range(count)
    ]

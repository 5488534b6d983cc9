# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A comparison of two sensors by a motion that both measured (docs/methods.md, Suspects).

Each comparison is a table of residuals with their sigmas. Errors that faultless sensors have too (a
mount's tilt, a scale) are nuisances: the table holds the change of the residuals by one sigma of
each, and `Comparison.chi2` fits them. Stamps are taken as they are: clocks are compared in
navigation/clocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np

from hullrecon.dive.logs.turns import SHARED
from hullrecon.geometry.robust import GAIN, SIGNIFICANT
from hullrecon.navigation.sensors.motion_signals import is_still
from hullrecon.records.clock import NS
from hullrecon.typing import Array, Ints

# What decides:
CLIP = 4.0  # sigmas at which a residual is clipped
# of chi-square over the rows: 1.2 at most on 17 faultless dives, 3.3 to 11 with faults
MISFIT = 2.0
# A turn between two sensors that accuses: beyond what the adjustment believes of a mount
# (adjustment/contradictions), by SIGNIFICANT of its own sigmas
LARGEST_TURN_RAD = np.radians(5.0)
# Windows in which motions are compared
LEAST_WINDOWS, MOST_WINDOWS = 4, 2000
LONGEST_GAP_S = 1.5  # between two readings of a window
SMOOTH_S = 0.4  # sigma of the weights by which depth, ranges and velocities are smoothed
# One sigma of errors that faultless sensors have:
TILT_RAD = np.radians(2.0)  # between DVL and IMU: mounts as measured by hand, backlash of a tray
LATE_S = 0.15  # between two sensors' clocks; larger offsets are judged in navigation/clocks


class Sensor(StrEnum):
    """What may be wrong: a sensor, or one of the signals of an IMU."""

    PRESSURE = "pressure"
    DVL = "DVL"
    RATES = "IMU's rates"
    ATTITUDE = "IMU's orientation"
    ACCELERATION = "IMU's acceleration"
    TRAY = "tray's angle"
    CAMERA = "camera"


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Residuals of two sensors' measurements of one motion."""

    kind: str  # a key of DEPENDS_ON, which says what is compared
    sensors: frozenset[Sensor]
    residual: Array  # (n,)
    sigma: Array  # (n,)
    by_nuisance: Array  # (n, k) change of the residual by one sigma of each error that is no fault
    first: Array  # (n,) the motion by the sensor that is compared
    second: Array  # (n,) the same motion by the others
    # True of a coarse comparison: agreement clears its sensors, but a disagreement accuses one only
    # where a reversed sign would explain it
    is_coarse: bool = False
    if_reversed: Array | None = None  # (n,) the residual if the first sensor had the other sign
    # those that a disagreement may be the fault of, and that agreement does not clear
    unclear: frozenset[Sensor] = frozenset()
    # (n,) change of the residual by a turn of the first sensor about the vertical, for 1 rad
    by_turn: Array | None = None

    @property
    def accuses(self) -> bool:
        """Tell whether the residuals show that a sensor is wrong."""
        return self.is_reversed or (self.is_contradiction and not self.is_coarse)

    @property
    def is_contradiction(self) -> bool:
        """Tell whether the residuals are larger than those of faultless sensors.

        Their chi-square is too large, or the nuisances would have to be, or a sign is reversed, or
        one of the sensors sits turned.
        """
        remaining, nuisances = self._fit
        rows, chi2 = len(self.residual), _clipped_chi2(remaining)
        # both significant, and more than somewhat too small sigmas would give
        beyond = chi2 - rows > GAIN and chi2 > MISFIT * rows
        far = bool((nuisances**2).sum() > GAIN)
        return beyond or far or self.is_reversed or self.is_turned

    @property
    def is_reversed(self) -> bool:
        """Tell whether the motions agree far better with the opposite sign.

        The size of the noise is taken as unknown: the ratio of the two sums of squares decides.
        """
        if self.if_reversed is None:
            return False
        as_is, other = self._squares(self.residual), self._squares(self.if_reversed)
        rows = len(self.residual) - self.by_nuisance.shape[1]
        # of a noise that is estimated, twice the log likelihood ratio of the two signs
        return bool(rows * np.log((as_is + 1e-9) / (other + 1e-9)) > GAIN)

    @property
    def is_turned(self) -> bool:
        """Tell whether the first sensor's mount is turned about the vertical against the others'.

        The turn is fitted with the nuisances. The sigmas hold for any vehicle, so a turn may be
        significant though all residuals are small in sigmas. The noise is therefore estimated from
        the remaining residuals.
        """
        if self.by_turn is None:
            return False
        design = np.column_stack([self.by_turn, self.by_nuisance]) / self.sigma[:, None]
        prior = np.diag(np.r_[0.0, np.ones(design.shape[1] - 1)])
        normal = design.T @ design + prior
        z = self.residual / self.sigma
        if normal[0, 0] <= 0:
            return False  # nothing moved across the vertical
        found = np.linalg.solve(normal, design.T @ z)
        remaining = z - design @ found
        noise = float(remaining @ remaining) / max(len(z) - len(found), 1)
        sigma_rad = np.sqrt(noise * np.linalg.inv(normal)[0, 0])
        return bool(abs(found[0]) > LARGEST_TURN_RAD + SIGNIFICANT * sigma_rad)

    def _squares(self, residual: Array) -> float:
        """Sum the squares of residuals (m,), in sigmas, after a fit of the nuisance parameters.

        Each of these has a prior of one sigma about zero.
        """
        z, design = residual / self.sigma, self.by_nuisance / self.sigma[:, None]
        prior = np.eye(design.shape[1])
        remaining = z - design @ np.linalg.solve(design.T @ design + prior, design.T @ z)
        return float(remaining @ remaining)

    @property
    def misfit(self) -> float:
        """Compute the rms of the residuals as a share of that of the motion.

        The fitted nuisances (mount, scale) are taken off first, unless they would have to be larger
        than those of faultless sensors.
        """
        motion = np.maximum(np.abs(self.first), np.abs(self.second))
        remaining, nuisances = self._fit
        error = self.residual if (nuisances**2).sum() > GAIN else remaining * self.sigma
        error = np.minimum(np.abs(error), motion)  # so that a single jolt does not decide
        return _rms(error) / max(_rms(motion), 1e-12)

    @property
    def stands_still(self) -> bool:
        """Tell whether the first sensor measures almost none of the motion that the others measure.

        One that measures the motion in another unit, and so a small but correlated signal, does not
        stand still.
        """
        product = (self.first @ self.second) ** 2
        is_scaled = product > SHARED * (self.first @ self.first) * (self.second @ self.second)
        return is_still(self.first, self.second) and not is_scaled

    @property
    def chi2(self) -> float:
        """Sum the squares of clipped residuals and of the fitted nuisances, in sigmas."""
        remaining, nuisances = self._fit
        return _clipped_chi2(remaining) + float((nuisances**2).sum())

    @cached_property
    def _fit(self) -> tuple[Array, Array]:
        """Fit the nuisances by reweighted least squares.

        Their priors have a sigma of one, as each column of the design is of one sigma.

        Returns
        -------
        tuple
            Remaining residuals (n,) and nuisances (k,), both in sigmas.
        """
        z, design = self.residual / self.sigma, self.by_nuisance / self.sigma[:, None]
        remaining: Array = z
        nuisances: Array = np.zeros(design.shape[1])
        weight: Array = np.ones(len(z))
        for _ in range(3):  # Huber's weights, so that clipped residuals do not pull
            normal = design.T @ (weight[:, None] * design) + np.eye(design.shape[1])
            nuisances = np.asarray(np.linalg.solve(normal, design.T @ (weight * z)), float)
            remaining = np.asarray(z - design @ nuisances)
            weight = np.asarray(np.minimum(1.0, CLIP / np.maximum(np.abs(remaining), 1e-9)), float)
        return np.asarray(remaining), np.asarray(nuisances)


def _clipped_chi2(residual: Array) -> float:
    """Sum the squares of residuals (n,), in sigmas, each clipped at CLIP."""
    return float(np.square(np.minimum(np.abs(residual), CLIP)).sum())


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else 0.0


def cut_windows(t_ns: Ints, lasts_s: float, inside: Array | None = None) -> Ints:
    """Cut a record into consecutive windows, at most about MOST_WINDOWS, thinned evenly.

    Parameters
    ----------
    t_ns
        Stamps (n,).
    lasts_s
        Length of a window.
    inside
        Mask (n,) of the rows at which a window may begin or end. None: at any row.

    Returns
    -------
    Ints
        First and last row (m, 2) of windows without a gap longer than LONGEST_GAP_S.
    """
    if len(t_ns) < 2:
        return np.zeros((0, 2), np.int64)
    usable = np.ones(len(t_ns), bool) if inside is None else inside
    begin = np.arange(t_ns[0], t_ns[-1] - round(lasts_s * NS), round(lasts_s * NS))
    rows = np.searchsorted(t_ns, np.stack([begin, begin + round(lasts_s * NS)], axis=1))
    # how many gaps lie before each row: a window without one has the same number at both ends
    gaps = np.cumsum(np.concatenate([[0], np.diff(t_ns) > LONGEST_GAP_S * NS]))
    whole = (gaps[rows[:, 0]] == gaps[rows[:, 1]]) & (rows[:, 1] > rows[:, 0])
    rows = rows[whole & usable[rows].all(axis=1)]
    return np.asarray(rows[:: 1 + len(rows) // MOST_WINDOWS])


def change_over(values: Array, windows: Ints) -> Array:
    """Compute how much a signal (n, ...) changes over windows (m, 2)."""
    return np.asarray(values[windows[:, 1]] - values[windows[:, 0]])

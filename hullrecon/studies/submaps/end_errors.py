# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Consistency of the ends of submaps, in their own frames [Aulinas2011 (3.21)].

A submap begins without error and knows nothing of the one before, so the ends of all submaps of all
worlds are independent draws of three degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.studies.association.point_sets import chi_square
from hullrecon.studies.study import ComparedValue
from hullrecon.studies.submaps.effort import Effort
from hullrecon.studies.submaps.ekf_slam import EkfMap, Limits
from hullrecon.studies.submaps.missions import build_submaps
from hullrecon.studies.submaps.models import compose, invert, wrap
from hullrecon.studies.submaps.worlds import World
from hullrecon.typing import Array

DEGREES = 3  # of freedom of a pose


@dataclass(frozen=True, kw_only=True)
class Ends:
    """Errors of where submaps end."""

    errors: Array  # (n, 3) m, m, rad in the frames of their starts
    covariances: Array  # (n, 3, 3)
    worlds: Array  # (n,) number of the world

    @property
    def nees(self) -> Array:
        """Normalised errors squared (n,) (3.21)."""
        solved = np.linalg.solve(self.covariances, self.errors[..., None])[..., 0]
        return np.asarray(np.einsum("ni,ni->n", self.errors, solved))

    @property
    def bias_ahead(self) -> float:
        """Mean error along the first heading in sigmas, given the errors aside and in heading."""
        last = self.covariances[:, ::-1, ::-1]  # x is the last to be whitened
        white = np.linalg.solve(np.linalg.cholesky(last), self.errors[:, ::-1, None])
        return float(white[:, 2, 0].mean())

    @property
    def inside(self) -> str:
        """Say where the mean NEES lies."""
        low, high = mean_band(len(self.nees))
        mean = self.nees.mean()
        return "above the band" if mean > high else "inside the band" if mean > low else "below it"

    def missions_inside(self) -> int:
        """Count the worlds whose own mean is inside the band of as many ends."""
        inside = 0
        for world in np.unique(self.worlds):
            nees = self.nees[self.worlds == world]
            low, high = mean_band(len(nees))
            inside += int(low < nees.mean() < high)
        return inside


def ends_of(world: World, submaps: Sequence[EkfMap], number: int = 0) -> Ends:
    """Compare where each submap ended with the truth, in its own frame."""
    errors, base = [], world.track[0]
    for built in submaps:
        end = world.track[built.path[-1].step + 1]
        off = built.mean[:3] - compose(invert(base), end)
        off[2] = wrap(off[2])
        errors.append(off)
        base = end
    return Ends(
        errors=np.array(errors),
        covariances=np.array([built.covariance[:3, :3] for built in submaps]),
        worlds=np.full(len(errors), number),
    )


def together(parts: Sequence[Ends]) -> Ends:
    """Put the ends of several worlds together."""
    return Ends(
        errors=np.concatenate([part.errors for part in parts]),
        covariances=np.concatenate([part.covariances for part in parts]),
        worlds=np.concatenate([part.worlds for part in parts]),
    )


def build_variant(
    world: World, first_estimates: bool = False, true_covariance: bool = False
) -> list[EkfMap]:
    """Build the submaps of a world.

    Parameters
    ----------
    world
        What is surveyed.
    first_estimates
        Take Jacobians at first estimates, not at the newest.
    true_covariance
        Take the odometry's covariance at the true speed and steering with the product of both
        errors, not at the readings and of first order.
    """
    log = replace(world.log, covariance_at=world.controls if true_covariance else None)
    return build_submaps(log, Limits(), Effort(), first_estimates=first_estimates)


def mean_band(count: int) -> tuple[float, float]:
    """Compute what the mean NEES of a pose over consistent runs lies between in 95 of 100."""
    low, high = (chi_square(share, DEGREES * count) / count for share in (0.025, 0.975))
    return low, high


@dataclass(frozen=True, kw_only=True)
class EndsByForm:
    """Ends of the submaps of the same worlds by our filter, by the printed one, and by variants.

    What else might be wrong was tried once on the same worlds. With pairs by the truth the printed
    form has a mean NEES of 3.15 in place of 3.19. From there landmarks placed by a linear reading
    leave 3.15, a linear law of all readings 3.16, a linear motion 3.11, an iterated update as much.
    Linear readings and linear motion together leave 3.02: what matters is that all Jacobians by a
    pose or a landmark are taken at one place.
    """

    first_estimates: Ends  # ours
    printed: Ends
    true_covariance: Ends  # of the odometry, else as printed
    both: Ends  # ours, with the true covariance of the odometry


def compare_ends(ends: EndsByForm) -> tuple[ComparedValue, ...]:
    """Compare the sigmas of submaps' ends with their errors, in our form and as printed."""
    ours, printed, known = ends.first_estimates, ends.printed, ends.true_covariance
    low, high = mean_band(len(ours.nees))
    count = len(np.unique(ours.worlds))
    cases = (
        (
            "mean NEES of where our submaps end",
            ours,
            f"{ours.inside} of {len(ours.nees)} ends, of {count} worlds: {low:.2f} to {high:.2f}; "
            f"{ours.missions_inside()} of {count} missions are inside the band of their own ends. "
            f"Printed: below the bound of (3.21), as {_share_below(ours):.1f} % of the ends are. "
            "It differs from the print in one thing: Jacobians are taken at first estimates, a "
            "landmark's where it was placed first, a pose's where it was predicted [Huang2010]",
        ),
        (
            "the same as printed, Jacobians at the newest estimates",
            printed,
            f"{printed.inside}, by (3.8) and (3.9). A pose or a landmark that is linearised at two "
            "places, before and after an update, seems to add information on the heading "
            "that no reading holds, so the filter is too sure. "
            f"{_share_below(printed):.1f} % of the ends are below the bound of (3.21), and "
            f"{printed.missions_inside()} of {count} missions inside the "
            "band of their own ends: one mission hardly shows it",
        ),
        (
            "as printed, but with the odometry's covariance at the true controls",
            known,
            f"{known.inside}. With the product of both errors, and of no use to a filter, which "
            "does not know them. By (3.7) it is of first order and at readings, whose speed errs "
            "by half and whose steering by 7 degrees. That is a fifth too large in the mean and "
            "hides some of the false certainty. It also goes with the very error: ends are off "
            f"along the first heading by {printed.bias_ahead:+.2f} sigmas, given the rest of their "
            f"errors; here by {known.bias_ahead:+.2f}",
        ),
        (
            "ours with the odometry's covariance at the true controls",
            ends.both,
            f"{ends.both.inside}, off by {ends.both.bias_ahead:+.2f} sigmas. With pairs by the "
            "truth it was 3.07, tried once: the gate of 99 %, which drops one honest reading in a "
            "hundred, makes the rest",
        ),
    )
    return tuple(
        ComparedValue(what=what, ours=float(of.nees.mean()), note=note) for what, of, note in cases
    )


def _share_below(ends: Ends) -> float:
    return 100 * float(np.mean(ends.nees < chi_square(0.95, DEGREES)))

# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Test whether a CAD model that does not fit the survey would fit with the DVL's beams reordered.

Where a DVL numbers its beams in another way than dive.toml or the message says, ranges are laid
along wrong beams, and the surveyed hull is bent. Without a camera only the CAD model shows it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hullrecon.adjustment.hull_pose.registration import (
    Registration,
    few_points,
    fits_far_better,
    register_near,
    rms_m,
)
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.records.trajectory import Returns
from hullrecon.typing import Array

MOST_BEAMS = 4  # with more, there are too many orders to try


def find_fitting_beams(
    returns: Returns,
    ends: Callable[[Returns], Array],
    cad_model: CadModel,
    range_sigma_m: float,
) -> tuple[tuple[int, ...], float, float] | None:
    """Register the CAD model to the ends of a DVL's beams in each order of their directions.

    Parameters
    ----------
    returns
        Ranges of the DVL, ordered by ping and then by beam, with their beams' directions.
    ends
        Computes the ends (n, 3) m in g of returns, flagged ones left out.
    cad_model, range_sigma_m
        The CAD model, and the sigma of a range.

    Returns
    -------
    order, rms before, rms after
        Numbers of the beams, from 1, to which the first, second ... range belongs, and the RMS
        distance from the CAD model, m, with the beams as logged and in that order. None where no
        other order fits far better, or where the number of beams is not 2 to MOST_BEAMS.
    """
    distinct, beam = np.unique(returns.beam, axis=0, return_inverse=True)
    if not 2 <= len(distinct) <= MOST_BEAMS:
        return None
    # Directions in the order of the beams of one ping, and the number in it of each return's beam
    of_ping = np.flatnonzero(returns.t_ns == returns.t_ns[_first_whole(returns, len(distinct))])
    directions = returns.beam[of_ping]
    number = np.array([np.flatnonzero(beam[of_ping] == k)[0] for k in range(len(distinct))])[beam]
    found: dict[tuple[int, ...], Registration] = {}
    for order in itertools.permutations(range(len(distinct))):
        other = replace(returns, beam=directions[list(order)][number])
        points = few_points(ends(other))
        found[order] = register_near(points, cad_model, range_sigma_m)
    as_is = found.pop(tuple(range(len(distinct))))
    best = fits_far_better(as_is, found, range_sigma_m)
    if best is None:
        return None
    return tuple(k + 1 for k in best), rms_m(as_is), rms_m(found[best])


def _first_whole(returns: Returns, beams: int) -> int:
    """Find the first row of a ping in which all beams returned, or row 0 if there is none."""
    _, first, count = np.unique(returns.t_ns, return_index=True, return_counts=True)
    return int(first[np.argmax(count >= beams)])

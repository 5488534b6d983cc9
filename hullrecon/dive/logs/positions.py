# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Turn positions from outside, of GPS and USBL, into metres north and east; leave out what cannot
be one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.dive.logs.samples import PositionSample
from hullrecon.geometry.geodesy import north_east
from hullrecon.records.clock import seconds_to_nearest
from hullrecon.records.sensors import PositionFixes, PressureSamples
from hullrecon.typing import Array, Mask

# of a satellite's signal; centimetres of sea water end it, the rest is for waves and the sensor
DEEPEST_RECEPTION_M = 1.0
NEAR_DEPTH_S = 10.0  # of a depth that tells whether an antenna was under water


@np.errstate(all="ignore")
def position_fixes(
    samples: Sequence[PositionSample],
    sigma_m: float,
    frame: str,
    pressure: PressureSamples | None,
    remarks: list[str],
) -> PositionFixes | None:
    """Return the fixes about the first of them, None without any. sigma_m: where a message has
    none; frame: "enu" or "ned", of x and y in a local frame; pressure: tells where an antenna was
    under water.
    """
    fixed = [s for s in samples if _is_position(s)]
    if len(fixed) < len(samples):
        remarks.append(
            f"position: {len(samples) - len(fixed)} of {len(samples)} messages have no fix and were left out"
        )
    of_one_form = [s for s in fixed if s.geographic == fixed[0].geographic]
    if len(of_one_form) < len(fixed):
        remarks.append(
            f"position: {len(fixed) - len(of_one_form)} of {len(fixed)} fixes are not of the form of the first "
            "(latitude and longitude, or metres) and were left out"
        )
    drowned = _under_water(of_one_form, pressure)
    if drowned.any():
        remarks.append(
            f"position: {drowned.sum()} of {len(drowned)} GPS fixes are of a vehicle deeper than {DEEPEST_RECEPTION_M:g} m, "
            "where no antenna receives: they are not used"
        )
    kept = [s for s, is_drowned in zip(of_one_form, drowned, strict=True) if not is_drowned]
    if not kept:
        return None
    given = np.array([s.sigma_m for s in kept])
    return PositionFixes(
        t_ns=np.array([s.t_ns for s in kept], np.int64),
        north_east=_in_metres(np.array([s.place for s in kept]), kept[0].geographic, frame),
        sigma=np.where(np.isfinite(given) & (given > 0), given, sigma_m),
    )


def _is_position(sample: PositionSample) -> bool:
    """Return whether a sample has a place; latitude and longitude of zero are what receivers send
    before they know.
    """
    first, second = sample.place[:2]
    if not np.isfinite([first, second]).all():
        return False
    return not sample.geographic or (
        abs(first) <= 90 and abs(second) <= 360 and (first, second) != (0.0, 0.0)
    )


def _under_water(samples: Sequence[PositionSample], pressure: PressureSamples | None) -> Mask:
    """Return which samples (n,) are of satellites while the vehicle was under water; none where no
    depth is known then.
    """
    t_ns = np.array([s.t_ns for s in samples], np.int64)
    by_satellite = np.array([s.by_satellite for s in samples], bool)
    if pressure is None or not len(pressure.t_ns) or not len(samples):
        return np.zeros(len(samples), bool)
    depth = np.interp(t_ns, pressure.t_ns, pressure.depth)
    known = seconds_to_nearest(pressure.t_ns, t_ns) <= NEAR_DEPTH_S
    return np.asarray(by_satellite & known & (depth > DEEPEST_RECEPTION_M))


def _in_metres(place: Array, geographic: bool, frame: str) -> Array:
    """Return metres north and east (n, 2) of the first place (n, 3)."""
    if geographic:
        return north_east(place[:, 0], place[:, 1])
    shift = place[:, :2] - place[0, :2]
    return shift[:, ::-1].copy() if frame == "enu" else shift

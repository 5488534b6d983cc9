# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stack the readings of a pressure sensor into a record: metres below the water."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from hullrecon.dive.logs.lost_values import describe_lost
from hullrecon.dive.logs.samples import DepthSample, PressureSample, is_of_dvl, stamps
from hullrecon.dive.logs.two_sensors import refuse_two_sensors, windows
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS
from hullrecon.records.sensors import PressureSamples
from hullrecon.typing import Array, Ints, Mask

# span of depths from the 5th to the 95th percentile; that of an enclosure's air is smaller
STILL_M = 0.15
HIGHEST_M = 1.0  # median height over the water, above which depths are wrong
HIGHEST_DECK_M = 6.0  # from which a vehicle is launched; zero pascal is 10 m above the water
# A depth is a spike where it differs from the median of SPIKE_READINGS around it by more than
# SPIKE_M plus what a vehicle can sink or rise between the first and the last of them.
SPIKE_READINGS, SPIKE_M, FASTEST_DIVE_M_S = 5, 2.0, 4.0
DEEPEST_HULL_M = 40.0  # the largest ships draw 25 m
PASCALS = {"Pa": 1.0, "mbar": 1e2, "hPa": 1e2, "kPa": 1e3, "psi": 6894.757, "dbar": 1e4, "bar": 1e5}
# Units that are read where dive.toml gives them, and never guessed: too near to another one
GIVEN_PASCALS = PASCALS | {"kgf/cm2": 98066.5}
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048}


@dataclass(frozen=True)
class PressureModel:
    """The conversion from logged values to depth."""

    density: float  # kg/m3
    gravity: float  # m/s2
    atmosphere: float  # Pa
    z_axis: str | None = None  # "up" or "down", of logged depths; None: as their type has it
    unit: str | None = None  # of GIVEN_PASCALS or METRES; None: as the type has it


@np.errstate(all="ignore")
def pressure_samples(
    samples: Sequence[PressureSample | DepthSample],
    model: PressureModel,
    notes: list[Finding],
    compared: bool = False,
) -> PressureSamples | None:
    """Stack the depths of one sensor, positive down. None where no reading is finite.

    Depths higher above the water than any deck, and spikes, are dropped.

    Parameters
    ----------
    samples : readings in order of time
    model : constants and units by which a reading becomes a depth
    notes : findings of what was assumed or dropped are added
    compared : whether another sensor tells how the vehicle sank, so that a wrong unit of pressure
        is found later; depths above the water are then returned, not refused

    Raises
    ------
    InputError
        Half of the depths lie above the water, two units fit the numbers, or two sensors share the
        topic.
    """
    if any(is_of_dvl(s) for s in samples):
        notes.append(Finding("depth-of-dvl", where="pressure"))
    depth = np.array([_depth_m(s, model) for s in samples])
    good = np.isfinite(depth)
    notes += describe_lost("pressure", good)
    if not good.any():
        return None
    samples, depth = [s for s, known in zip(samples, good, strict=True) if known], depth[good]
    t_ns = stamps(samples)
    cut = windows(depth)
    leave_away = "leave topics.pressure (or pressure.csv) away"
    refuse_two_sensors("pressure", np.abs(cut - cut[:, :1]), "m", leave_away)
    _refuse_unclear_numbers(samples, model)
    if np.median(depth) < -HIGHEST_M:
        if (
            compared
            and (model.unit or "Pa") in GIVEN_PASCALS
            and isinstance(samples[0], PressureSample)
        ):
            return PressureSamples(t_ns=t_ns, depth=depth)
        raise _above_water(samples, model)
    in_water = depth > -HIGHEST_DECK_M
    if not in_water.all():
        values = {"lost": int((~in_water).sum()), "count": len(depth), "limit_m": HIGHEST_DECK_M}
        notes.append(Finding("depths-above-water", values, "pressure"))
    t_ns, depth = t_ns[in_water], depth[in_water]
    spikes = _are_spikes(t_ns, depth)
    if spikes.any():
        counts = {"spikes": int(spikes.sum()), "count": len(depth)}
        notes.append(Finding("depths-spikes", counts, "pressure"))
    return PressureSamples(t_ns=t_ns[~spikes], depth=depth[~spikes])


def _are_spikes(t_ns: Ints, depth: Array) -> Mask:
    """Mark depths (n,), m, that a vehicle cannot have reached from the readings around them.

    t_ns: (n,) of the readings. Each is compared with the median of SPIKE_READINGS around it. The
    threshold grows with the noise, so that depths in a wrong unit, whose noise is metres, are not
    all spikes.
    """
    if len(depth) < SPIKE_READINGS:
        return np.zeros(len(depth), bool)
    difference = np.abs(depth - median_filter(depth, SPIKE_READINGS, mode="mirror"))
    rows, half = np.arange(len(depth)), SPIKE_READINGS // 2
    after, before = t_ns[np.minimum(rows + half, rows[-1])], t_ns[np.maximum(rows - half, 0)]
    # what a vehicle can sink or rise between the first and the last of them, m
    reachable_m = FASTEST_DIVE_M_S * (after - before) / NS
    noise = float(np.median(np.abs(np.diff(depth))))
    return np.asarray(difference > np.maximum(SPIKE_M + reachable_m, 10 * noise))


def _refuse_unclear_numbers(
    samples: Sequence[PressureSample | DepthSample], model: PressureModel
) -> None:
    """Raise InputError for numbers without a unit that are no depth in metres but a pressure.

    A centimetre of water is a hectopascal: motion does not tell them apart. Where the numbers are
    depths of a hull in both, either may be meant.
    """
    if model.unit is not None or isinstance(samples[0], PressureSample):
        return
    fitting = _fitting_units(samples, model, ("Pa", "hPa"))
    if not fitting:
        return
    fitting += _fitting_units(samples, model, ("cm",))
    typical = float(np.median([_depth_m(s, model) for s in samples]))
    raise InputError(
        f"half of the depths are {abs(typical):.4g} m and more: they are a pressure"
        + (", or in centimetres, which change as hectopascals do" if len(fitting) > 1 else ""),
        where="pressure.unit",
        remedy=f"give pressure.unit = {' or '.join(fitting)}",
    )


def _fitting_units(
    samples: Sequence[PressureSample | DepthSample], model: PressureModel, names: Iterable[str]
) -> list[str]:
    """List the units, each with the depths in it, in which the readings are depths of a hull."""
    fitting = []
    for name in names:
        depth = [_depth_m(s, replace(model, unit=name)) for s in samples]
        low, high = np.percentile(depth, [5, 95])
        if low >= -HIGHEST_M and high <= DEEPEST_HULL_M:
            fitting.append(f'"{name}" ({low:.1f} to {high:.1f} m deep then)')
    return fitting


def _depth_m(sample: PressureSample | DepthSample, model: PressureModel) -> float:
    """Convert a reading to metres below the water.

    A unit in dive.toml decides whether the number is a pressure or a depth, else its type does.
    """
    is_pressure = isinstance(sample, PressureSample)
    value = sample.pascal if isinstance(sample, PressureSample) else sample.height
    unit = model.unit or ("Pa" if is_pressure else "m")
    if unit in GIVEN_PASCALS:
        return (value * GIVEN_PASCALS[unit] - model.atmosphere) / (model.density * model.gravity)
    is_up_by_type = isinstance(sample, DepthSample) and sample.is_up
    is_up = is_up_by_type if model.z_axis is None else model.z_axis == "up"
    return -value * METRES[unit] if is_up else value * METRES[unit]


def _above_water(
    samples: Sequence[PressureSample | DepthSample], model: PressureModel
) -> InputError:
    """Make the error for depths that lie above the water, with the units that bring them below.

    It names the keys of dive.toml that may be wrong: the unit or the air pressure of a pressure,
    the direction in which a depth grows.
    """
    unit = model.unit or ("Pa" if isinstance(samples[0], PressureSample) else "m")
    height = -float(np.median([_depth_m(s, model) for s in samples]))
    what = f"half of the depths lie {height:.1f} m or more above the water"
    if unit not in GIVEN_PASCALS:
        other = "down" if samples[0].is_up else "up"  # type: ignore[union-attr]
        if model.z_axis is not None:
            other = "down" if model.z_axis == "up" else "up"
        remedy = (
            f'give pressure.z_axis = "{other}" where they grow so; a height above another level'
        )
        return InputError(what, where="pressure", remedy=f"{remedy} than the water is no depth")
    names = {scale: name for name, scale in PASCALS.items()}.values()  # hPa stands for mbar
    fitting = [f"pressure.unit = {words}" for words in _fitting_units(samples, model, names)]
    relative = "pressure.atmosphere = 0 for a pressure over that of the air"
    still_m = float(np.ptp(np.percentile([_depth_m(s, model) for s in samples], [5, 95])))
    if still_m < STILL_M:
        relative += (
            f"; readings that stay within {still_m:.2f} m may be the air's in an enclosure: then "
            "name another topic, or none"
        )
    return InputError(
        f"{what}, as no absolute pressure in {unit} does",
        where="pressure",
        remedy=f"give {', or '.join([*fitting, relative])}",
    )

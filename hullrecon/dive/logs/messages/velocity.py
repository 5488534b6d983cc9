# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Translate messages of DVLs, and of velocities alone, to samples: one small function per type.

Arguments are those of `Translate` in samples.py.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.dive.logs.dvl_beams import A50, a50_beams
from hullrecon.dive.logs.messages.covariance import LOST_SIGMA, UNKNOWN_SIGMA, sigma_of
from hullrecon.dive.logs.messages.decode import Fields, vector
from hullrecon.dive.logs.samples import LOST, DvlSample, Sample
from hullrecon.typing import Array

NO_RANGES = np.zeros(0)
VELOCITY = (0, 1, 2)  # axes of a covariance
# m/s; Water Linked: velocities with a larger figure of merit are not valid
FIGURE_OF_MERIT_LIMIT = 0.4
# m/s; Nortek: velocities of -32.768 and figures of merit of 10 are invalid
NORTEK_LOST, NORTEK_BAD_MERIT = -32.0, 10.0
# marine_acoustic_msgs and ds_sensor_msgs: velocity_mode; ds_sensor_msgs: coordinate_mode
OF_THE_WATER, IN_EARTH = 2, 3
TO_THE_WATER, ALONG_EARTH = "relative to the water", "along the earth's axes"


def marine_dvl(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read marine_acoustic_msgs/Dvl.

    A velocity relative to the water counts as lost. A beam is lost where its range is 0, negative
    or NaN, or where its covariance is negative.
    """
    sigma = sigma_of(message.velocity_covar, VELOCITY)
    ranges = np.asarray(message.range, float).copy()
    bad = np.asarray(message.range_covar, float) < 0
    ranges[bad | ~(ranges > 0)] = np.nan
    if not message.beam_ranges_valid:
        ranges[:] = np.nan
    beams = np.array([vector(b) for b in message.beam_unit_vec])
    of_the_water = message.velocity_mode == OF_THE_WATER
    velocity = LOST if of_the_water else vector(message.velocity)
    altitude = _positive(message.altitude)
    known_beams = beams if _are_unit(beams) else None
    return [
        _unless_lost(
            DvlSample(
                t_ns,
                velocity,
                sigma,
                ranges,
                known_beams,
                altitude=altitude,
                not_over_ground=TO_THE_WATER if of_the_water else "",
            )
        )
    ]


def deep_submergence_dvl(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read ds_sensor_msgs/Dvl. Its altitude is the mean of the ranges, and is not used.

    A velocity relative to the water, or along the earth's axes, counts as lost.
    """
    sigma = sigma_of(message.velocity_covar, VELOCITY)
    ranges = np.asarray(message.range, float)
    what = ALONG_EARTH if message.coordinate_mode == IN_EARTH else ""
    what = TO_THE_WATER if message.velocity_mode == OF_THE_WATER else what
    ranges = np.where((np.asarray(message.range_covar, float) < 0) | ~(ranges > 0), np.nan, ranges)
    beams = np.array([vector(b) for b in message.beam_unit_vec])
    velocity = LOST if what else vector(message.velocity)
    known_beams = beams if _are_unit(beams) else None
    return [
        _unless_lost(DvlSample(t_ns, velocity, sigma, ranges, known_beams, not_over_ground=what))
    ]


def twist_with_covariance(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read geometry_msgs/TwistWithCovarianceStamped and nav_msgs/Odometry: no ranges."""
    sigma = sigma_of(message.twist.covariance, VELOCITY)
    velocity = vector(message.twist.twist.linear)
    return [_unless_lost(DvlSample(t_ns, velocity, sigma, NO_RANGES, None))]


def twist(message: Fields, t_ns: int, role: str) -> list[Sample]:
    return [DvlSample(t_ns, vector(message.twist.linear), np.nan, NO_RANGES, None)]


def water_linked(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read the A50's report: figure of merit as sigma, one entry per beam with its own validity.

    Its beams are those of the A50, since the message has none.
    """
    ranges = [
        b.distance if b.valid else np.nan for b in sorted(message.beams, key=lambda b: int(b.id))
    ]
    return [_water_linked(message, vector(message.velocity), ranges, t_ns, A50)]


def transducer_report(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read waterlinked_a50/TransducerReportStamped, of an A50."""
    return [_transducers(message.report, t_ns, A50)]


def unnamed_transducer_report(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read waterlinked_dvl/TransducerReportStamped, whose beams dive.toml has to give."""
    return [_transducers(message.report, t_ns, "")]


def _transducers(report: Fields, t_ns: int, instrument: str) -> DvlSample:
    """Read one ping, velocity and ranges by beam, of a Water Linked transducer report.

    instrument: A50, or "" where the message's type does not name it.
    """
    ranges = [
        b.distance if b.beam_valid else np.nan
        for b in sorted(report.transducers, key=lambda b: int(b.id))
    ]
    return _water_linked(
        report, np.array([report.vx, report.vy, report.vz], float), ranges, t_ns, instrument
    )


def _water_linked(
    report: Fields, velocity: Array, distances: list[float], t_ns: int, instrument: str
) -> DvlSample:
    """Read the fields common to all drivers: x forward, y right, z out of the transducers.

    A velocity whose figure of merit is FIGURE_OF_MERIT_LIMIT or more is lost.

    Parameters
    ----------
    report : the message
    velocity : (3,) m/s
    distances : along the beams, m, NaN where lost
    t_ns : stamp
    instrument : A50, whose beams are then used, or ""
    """
    ranges = np.array(distances, float)
    ranges[~(ranges > 0)] = np.nan
    merit = float(report.fom)
    is_valid = bool(report.velocity_valid) and not merit >= FIGURE_OF_MERIT_LIMIT
    beams = a50_beams() if instrument == A50 and len(ranges) == len(a50_beams()) else None
    return DvlSample(
        t_ns,
        velocity if is_valid else LOST,
        merit if is_valid and merit > 0 else np.nan,
        ranges,
        beams,
        instrument if beams is not None else "",
        _positive(report.altitude) if is_valid else np.nan,
    )


def simulator_dvl(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read DVLs of UUV Simulator, Stonefish and COLA2, whose beams' directions dive.toml gives.

    Each beam is a message of its own, in which a covariance of -1 marks the range as lost. Old
    messages of COLA2 have no beams.
    """
    sigma = sigma_of(message.velocity_covariance, VELOCITY)
    ranges = [
        b.range if b.range > 0 and not b.range_covariance < 0 else np.nan
        for b in getattr(message, "beams", ())
    ]
    velocity = vector(message.velocity)
    return [_unless_lost(DvlSample(t_ns, velocity, sigma, np.array(ranges, float), None))]


def nortek_dvl(message: Fields, t_ns: int, role: str) -> list[Sample]:
    """Read nortek_dvl/Dvl, whose figure of merit is the sigma.

    A velocity of -32.768, or with a figure of merit of NORTEK_BAD_MERIT, is lost, and so is a
    distance of 0. It does not carry its beams' directions.
    """
    velocity, merit = vector(message.velocity), float(message.figureOfMerit)
    lost = bool(np.any(velocity <= NORTEK_LOST)) or merit >= NORTEK_BAD_MERIT
    ranges = np.asarray(message.beamDistance, float)
    sigma = merit if merit > 0 and not lost else np.nan
    return [
        DvlSample(
            t_ns, LOST if lost else velocity, sigma, np.where(ranges > 0, ranges, np.nan), None
        )
    ]


def _unless_lost(sample: DvlSample) -> DvlSample:
    """Replace a velocity by NaN where its covariance marks it as lost."""
    if sample.sigma < LOST_SIGMA or np.isnan(sample.sigma):
        return sample
    return replace(sample, velocity=LOST, sigma=UNKNOWN_SIGMA)


def _positive(altitude: float) -> float:
    """Replace an altitude of -1 or 0, which means none, by NaN."""
    return float(altitude) if altitude > 0 else float("nan")


def _are_unit(beams: Array) -> bool:
    """Tell whether vectors (b, 3) have length 1, within 2 % as they may be rounded."""
    return bool(np.all(np.abs(np.linalg.norm(beams, axis=1) - 1) < 0.02))

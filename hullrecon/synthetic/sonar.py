# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""An imaging sonar by ray casting.

Every beam integrates over its arc of elevation, and objects cast shadows.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.poses import Poses
from hullrecon.synthetic.built_hull import Block
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.vehicle import SONAR_ELEVATION_DEG, SONAR_ORIGIN, ticks
from hullrecon.typing import Array

BEAM_COUNT, BIN_COUNT = 96, 256  # beams, and range bins of a beam
NEAR_M, FAR_M = 0.6, 3.0  # first and last range
AZIMUTH = np.radians(np.linspace(14.5, -14.5, BEAM_COUNT))  # of the beams
RANGE = np.linspace(NEAR_M, FAR_M, BIN_COUNT)  # of the bins, m
ARC_RAYS, SUB_BEAMS = 260, 2  # rays of a beam: over its elevation, and over its width
LOOKS = 3.0  # shape of the gamma-distributed speckle
RATE_HZ = 2.0  # pings per second


@dataclass(frozen=True)
class Fan:
    """The rays of one ping, in the sonar's frame."""

    direction: Array  # (n, 3)
    beam: NDArray[np.int64]  # (n,) to which each belongs
    gain: Array  # (n,) of the beam pattern


def pings(dive: Dive) -> tuple[Array, Iterator[NDArray[np.uint8]]]:
    """Simulate the pings: their times (n,), s, and an iterator that renders the images.

    An image is (beams, ranges).
    """
    random = dive.spec.random("sonar")
    t_s = ticks(dive.motion, RATE_HZ, random, first_s=0.3)
    at = dive.motion.on_tray(t_s, dive.rig.servo_from_sonar, SONAR_ORIGIN, dive.motion.sonar_tray)
    hull_from_sonar, rays = dive.motion.in_hull(at), fan()
    return t_s, (
        ping(hull_from_sonar[k], dive.hull.near(hull_from_sonar.translation[k, 0]), rays, random)
        for k in range(len(t_s))
    )


def beam_directions() -> Array:
    """List the beams' unit vectors (beams, 3): the fan lies in the y-z plane."""
    return np.stack([np.zeros(BEAM_COUNT), np.sin(AZIMUTH), np.cos(AZIMUTH)], axis=1)


def fan() -> Fan:
    """Make the rays of a ping, which fill the elevation and width of every beam."""
    half = np.radians(SONAR_ELEVATION_DEG / 2)
    step = abs(AZIMUTH[1] - AZIMUTH[0])
    offset = ((np.arange(SUB_BEAMS) + 0.5) / SUB_BEAMS - 0.5) * step
    elevation = half * (2 * (np.arange(ARC_RAYS) + 0.5) / ARC_RAYS - 1)
    # Of every ray: its beam, azimuth from the beam's middle, and elevation
    beam, beside, e = (
        grid.ravel()
        for grid in np.meshgrid(np.arange(BEAM_COUNT), offset, elevation, indexing="ij")
    )
    azimuth = AZIMUTH[beam] + beside
    direction = np.stack(
        [np.sin(e), np.cos(e) * np.sin(azimuth), np.cos(e) * np.cos(azimuth)], axis=1
    )
    # The beam pattern falls off with elevation
    return Fan(direction, beam.astype(np.int64), np.exp(-1.2 * (e / half) ** 2))


def ping(
    hull_from_sonar: Poses, block: Block, rays: Fan, random: np.random.Generator
) -> NDArray[np.uint8]:
    """Render a ping as image (beams, ranges).

    The echoes of all rays, by angle of incidence and beam pattern, are summed in range bins.
    Speckle and a noise floor are added.

    Parameters
    ----------
    hull_from_sonar
        A single pose.
    block
        The part of the hull near it.
    rays
        As by `fan`.
    random
        Draws the noise.
    """
    direction = hull_from_sonar.rotation.apply(rays.direction)
    hits = block.rays.cast(hull_from_sonar.translation, direction)
    corner = block.built.mesh.faces[hits.face]
    normal = np.einsum("nk,nkd->nd", hits.weight, block.built.normal[corner])
    # Cosine of the angle of incidence
    facing = np.clip(-np.einsum("nd,nd->n", normal, direction), 0, 1)
    bins = np.rint((hits.range_m - NEAR_M) / (FAR_M - NEAR_M) * (BIN_COUNT - 1))
    seen = hits.hit & (bins >= 0) & (bins < BIN_COUNT)
    cell = rays.beam[seen] * BIN_COUNT + bins[seen].astype(np.int64)
    total = np.bincount(
        cell, (rays.gain * (0.3 * facing + 0.7 * facing**2))[seen], BEAM_COUNT * BIN_COUNT
    )
    # Far echoes are amplified, as by a sonar's gain that grows with time
    echo = total.reshape(BEAM_COUNT, BIN_COUNT) * RANGE / (ARC_RAYS * SUB_BEAMS / 40.0)
    speckle = random.gamma(LOOKS, 1 / LOOKS, echo.shape) * (
        1 + 0.05 * random.standard_normal((BEAM_COUNT, 1))
    )
    floor = 0.004 * random.gamma(1.0, 1.0, echo.shape)
    # The root makes weak echoes visible beside strong ones
    loud = 255 * np.sqrt(np.abs(0.65 * echo * speckle + floor))
    return np.asarray(np.clip(loud, 0, 255), np.uint8)
